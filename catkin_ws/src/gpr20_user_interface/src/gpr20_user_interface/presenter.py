"""Between the main control and the window: the survey that runs, and the operator's requests."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Optional

from gpr20_operator.ground.grid import FinerPlan
from gpr20_operator.plan.form import (
    CostEstimated,
    SurveyPreview,
    preview,
)
from gpr20_operator.robot.events import Answer, Configured, Request, StartPlan, SurveyControl
from gpr20_operator.robot.snapshot import Snapshot, SurveyModel
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters


class WindowPresenter:
    """Carries events to the model and requests to the main control. Belongs to one thread.

    Args:
        estimate: Makes a CostEstimated beside this thread, which comes as an event.

    Attributes:
        snapshot: What the window shows now.
        preview: What the survey of the fields will be; None while they are wrong.
        finer: The finer survey that was put into the fields; None: none.
    """

    def __init__(
        self,
        model: SurveyModel,
        control: SurveyControl,
        estimate: Callable[[Configured, SurveyParameters], None],
    ) -> None:
        self._model = model
        self._control = control
        self._estimate = estimate
        self._parameters: Optional[SurveyParameters] = None
        self._permittivity = 1.0
        self._resumed = ""
        self.preview: Optional[SurveyPreview] = None
        self.finer: Optional[FinerPlan] = None
        self.snapshot = model.state()

    def on_event(self, event: object) -> Optional[Answer]:
        """Take an event; return what the operator must see at once."""
        if isinstance(event, CostEstimated):
            if self.preview is not None and event.parameters == self._parameters:
                self.preview = replace(self.preview, cost=event.cost)
            return None
        return self._model.handle(event)

    def state(self) -> Snapshot:
        """Return what is known now."""
        robot, self.snapshot = self.snapshot.robot, self._model.state()
        if self.snapshot.robot != robot:
            self.set_plan(self._parameters, self._permittivity)
        return self.snapshot

    def set_plan(self, parameters: Optional[SurveyParameters], permittivity: float) -> None:
        """Preview another plan; parameters None: something in the fields is wrong."""
        self._parameters, self._permittivity = parameters, permittivity
        self.preview = None if parameters is None else preview(parameters, permittivity)
        if parameters is not None and self.snapshot.robot is not None:
            self._estimate(self.snapshot.robot, parameters)

    def preview_of(self, parameters: SurveyParameters) -> SurveyPreview:
        """Return the preview of parameters; with their cost if they are those of the plan."""
        if self.preview is not None and parameters == self._parameters:
            return self.preview
        return preview(parameters, self._permittivity)

    def check_master(self) -> None:
        """Check that the master answers."""
        self._control.check_master()

    def start(
        self, parameters: SurveyParameters, permittivity: float, annotation: Annotation
    ) -> None:
        """Ask for a survey."""
        self._model.request_sent(Request.START)
        plan = StartPlan(parameters, annotation, self.refines(parameters), permittivity)
        self._control.start_survey(plan)

    def refines(self, parameters: SurveyParameters) -> str:
        """Return the id of the survey that these parameters measure more finely; empty: none."""
        return "" if self.finer is None else self.finer.refined_by(parameters)

    def stop(self) -> None:
        """Stop whatever moves, and the survey."""
        self._model.request_sent(Request.STOP)
        self._control.stop()

    def pause(self) -> None:
        """Ask to pause the survey."""
        self._model.request_sent(Request.PAUSE)
        self._control.pause_survey()

    def resume(self, folder: str = "", accept_zeros: bool = False) -> None:
        """Ask to resume the paused survey, or the one of a folder, which ended early."""
        self._resumed = folder
        self._model.request_sent(Request.RESUME)
        self._control.resume_survey(folder, accept_zeros=accept_zeros)

    def resume_with(self, analyzer: str) -> None:
        """Ask again to resume the survey, with another analyzer that the operator accepts."""
        self._model.request_sent(Request.RESUME)
        self._control.resume_survey(self._resumed, analyzer)

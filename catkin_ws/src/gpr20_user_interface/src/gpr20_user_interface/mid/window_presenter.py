"""Between main_control and the window: what is shown of the survey, and what the operator asks."""

from __future__ import annotations

from dataclasses import replace
from typing import Optional, Protocol

from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.events import Request
from gpr20_user_interface.mid.survey_model import Refusal, Snapshot, SurveyModel
from gpr20_user_interface.mid.survey_preview import (
    CostEstimated,
    CostEstimator,
    SurveyPreview,
    preview,
)


class SurveyControl(Protocol):
    """main_control, asked without waiting; what it answers comes as events."""

    def start_survey(self, parameters: SurveyParameters) -> None:
        """Ask to accept the parameters and to start."""

    def stop_survey(self) -> None:
        """Ask to stop."""

    def pause_survey(self) -> None:
        """Ask to hold the survey."""

    def resume_survey(self, survey_id: str = "") -> None:
        """Ask to go on with the paused survey, or with one by its id or its folder's name."""

    def read_axis_limits(self) -> None:
        """Read what the axes can do."""


class WindowPresenter:
    """Carries events to the model and wishes to main_control. Belongs to one thread.

    Attributes:
        snapshot: What the window shows now.
        preview: What the survey of the fields will be; None while they are wrong.
    """

    def __init__(
        self, model: SurveyModel, control: SurveyControl, estimator: CostEstimator
    ) -> None:
        self._model = model
        self._control = control
        self._estimator = estimator
        self._parameters: Optional[SurveyParameters] = None
        self.preview: Optional[SurveyPreview] = None
        self.snapshot = model.snapshot()

    def on_event(self, event: object) -> Optional[Refusal]:
        """Take note of an event; return what the operator must be told at once."""
        if isinstance(event, CostEstimated):
            if self.preview is not None and event.parameters == self._parameters:
                self.preview = replace(self.preview, cost=event.cost)
            return None
        return self._model.handle(event)

    def refresh(self) -> Snapshot:
        """Return what is known now."""
        figures, self.snapshot = self.snapshot.figures, self._model.snapshot()
        if self.snapshot.figures != figures:
            self.set_parameters(self._parameters)
        return self.snapshot

    def set_parameters(self, parameters: Optional[SurveyParameters]) -> None:
        """Preview other parameters; None: those in the fields are wrong."""
        self._parameters = parameters
        self.preview = None if parameters is None else preview(parameters)
        if parameters is not None and self.snapshot.figures is not None:
            self._estimator.ask(parameters, self.snapshot.figures)

    def read_axis_limits(self) -> None:
        """Ask what the axes can do, and by that whether the master answers."""
        self._control.read_axis_limits()

    def start(self, parameters: SurveyParameters) -> None:
        """Ask for a survey."""
        self._model.request_sent(Request.START)
        self._control.start_survey(parameters)

    def stop(self) -> None:
        """Ask to stop the survey."""
        self._model.request_sent(Request.STOP)
        self._control.stop_survey()

    def pause(self) -> None:
        """Ask to hold the survey."""
        self._model.request_sent(Request.PAUSE)
        self._control.pause_survey()

    def resume(self, folder: str = "") -> None:
        """Ask to go on with the paused survey, or with one that has ended early."""
        self._model.request_sent(Request.RESUME)
        self._control.resume_survey(folder)

    def end(self) -> None:
        """Let go of what is still being estimated."""
        self._estimator.close()

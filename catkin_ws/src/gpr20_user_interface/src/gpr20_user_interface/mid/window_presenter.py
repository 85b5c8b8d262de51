"""Between the window, the model and main_control; in the thread of the window."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Optional, Protocol

from PyQt5.QtCore import QObject, QTimer, pyqtSignal

from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.events import Answer, ControlState, Request
from gpr20_user_interface.mid.request_outcome import RequestOutcome
from gpr20_user_interface.mid.survey_model import Snapshot, SurveyModel
from gpr20_user_interface.mid.survey_preview import CostEstimator, SurveyPreview, preview
from gpr20_user_interface.views.main_window import MainWindow

# Topics come at up to 50 Hz; nobody reads figures that change more often than this.
REFRESH_MS = 100
# A robot may be started, or started anew with other limits, after the window; and whether
# the master answers is seen by it.
LIMITS_MS = 2000


class SurveyControl(Protocol):
    """main_control, asked without waiting; what it answers comes as events."""

    def start_survey(self, parameters: SurveyParameters) -> None:
        """Ask to accept the parameters and to start."""

    def stop_survey(self) -> None:
        """Ask to stop."""

    def pause_survey(self) -> None:
        """Ask to hold the survey."""

    def resume_survey(self, survey: str = "") -> None:
        """Ask to go on with the paused survey, or with one by its id or its folder's name."""

    def read_axis_limits(self) -> None:
        """Read what the axes can do."""


class WindowPresenter(QObject):
    """Carries events to the model, snapshots to the window and wishes to main_control."""

    # Carries the Snapshot that the window shows now.
    refreshed = pyqtSignal(object)

    def __init__(self, model: SurveyModel, window: MainWindow, control: SurveyControl) -> None:
        super().__init__()
        self._preview: Optional[SurveyPreview] = None
        self._estimator = CostEstimator()
        self._estimator.estimated.connect(self._on_estimated)
        self._outcome = RequestOutcome()
        self._model = model
        self._window = window
        self._snapshot = model.snapshot()
        self._control = control
        window.start_requested.connect(self._start)
        window.control.parameters_changed.connect(self._on_parameters)
        window.stop_requested.connect(self._stop)
        window.pause_requested.connect(self._pause)
        window.resume_requested.connect(self._resume)
        self._refresh_timer = self._timer(REFRESH_MS, self.refresh)
        self._limits_timer = self._timer(LIMITS_MS, control.read_axis_limits)

    @property
    def snapshot(self) -> Snapshot:
        """What the window shows now."""
        return self._snapshot

    def begin(self) -> None:
        """Keep the window up to date from now on."""
        self._control.read_axis_limits()
        self.refresh()
        self._on_parameters(self._window.control.parameters)
        self._refresh_timer.start()
        self._limits_timer.start()

    def end(self) -> None:
        """Leave the window as it is."""
        self._refresh_timer.stop()
        self._limits_timer.stop()
        self._estimator.close()

    def on_event(self, event: object) -> None:
        """Take note of an event; tell the operator at once what was refused."""
        self._model.handle(event)  # type: ignore[arg-type]
        if isinstance(event, ControlState):
            self._tell_failure(event)
        if isinstance(event, Answer):
            self._outcome.answered(event)
            if not event.success:
                self._window.show_refusal(event.request, event.message)
            self.refresh()

    def refresh(self) -> None:
        """Show what is known now."""
        figures, self._snapshot = self._snapshot.figures, self._model.snapshot()
        self._window.refresh(self._snapshot)
        self.refreshed.emit(self._snapshot)
        if self._snapshot.figures != figures:
            self._on_parameters(self._window.control.parameters)

    def resume_past_survey(self, folder: str) -> None:
        """Ask to go on with a survey that has ended early."""
        self._sent(Request.RESUME)
        self._control.resume_survey(folder)

    def _on_parameters(self, parameters: Optional[SurveyParameters]) -> None:
        self._preview = None if parameters is None else preview(parameters)
        self._window.control.show_preview(self._preview)
        if parameters is not None and self._snapshot.figures is not None:
            self._estimator.ask(parameters, self._snapshot.figures)

    def _on_estimated(self, parameters: SurveyParameters, cost: SurveyCost) -> None:
        if self._preview is not None and parameters == self._window.control.parameters:
            self._window.control.show_preview(replace(self._preview, cost=cost))

    def _tell_failure(self, state: ControlState) -> None:
        failed = self._outcome.failed_request(state)
        if failed is not None:
            self._window.show_refusal(failed, state.message)

    def _start(self, parameters: SurveyParameters) -> None:
        self._sent(Request.START)
        self._control.start_survey(parameters)

    def _stop(self) -> None:
        self._sent(Request.STOP)
        self._control.stop_survey()

    def _pause(self) -> None:
        self._sent(Request.PAUSE)
        self._control.pause_survey()

    def _resume(self) -> None:
        self._sent(Request.RESUME)
        self._control.resume_survey()

    def _sent(self, request: Request) -> None:
        self._outcome.asked(request)
        self._model.request_sent(request)
        self.refresh()

    def _timer(self, period_ms: int, slot: Callable[[], None]) -> QTimer:
        timer = QTimer(self)
        timer.setInterval(period_ms)
        timer.timeout.connect(slot)
        return timer

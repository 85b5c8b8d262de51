"""Connects the job screen with the survey that runs: what CONTROL shows, faults, and STOP."""

from __future__ import annotations

import math
from typing import Optional

from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtWidgets import QLabel, QStackedWidget, QVBoxLayout, QWidget

from gpr20_common.low.clock import Clock
from gpr20_operator.ground.trace_events import SurveyDescribed
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.robot.fault_messages import FaultWatch, is_fault
from gpr20_operator.robot.job import JobScreen, survey_name
from gpr20_operator.robot.motion import motion_of
from gpr20_operator.robot.notices import fault_notice, motion_notice, state_notice
from gpr20_operator.robot.stop_confirmation import ANSWER_S, StopConfirmation, StopWarning
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.job.view import JobView
from gpr20_user_interface.pages.status.page import SurveyBinding
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.labels import LinesLabel
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.top_bar import TopBar


class StopWarningView(Overlay):
    """Stays until the stop is confirmed, or the operator closes it by a hold."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("stop_warning")
        self._warning: Optional[StopWarning] = None
        self.title = QLabel()
        self.title.setObjectName("motors_off")
        self.title.setWordWrap(True)
        self.title.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.text = LinesLabel()
        self.close_button = HoldButton()
        self._layout = QVBoxLayout(self)
        self._layout.addWidget(self.title, 3)
        self._layout.addWidget(self.text, 1)
        self._layout.addWidget(self.close_button)
        self.retranslate()

    def show_warning(self, warning: Optional[StopWarning]) -> None:
        """Show a warning over everything; None: there is none."""
        if warning is None:
            self.hide()
            return
        if warning != self._warning:
            self._warning = warning
            self.retranslate()
        if not self.isVisible():
            self.open()
        # Another sheet may have opened since.
        self.raise_()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.close_button.setText(self.tr("Hold to close"))
        if self._warning is not None:
            self.title.setText(shown_text(self._warning.title))
            self.text.show_text(shown_text(self._warning.text))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        margin_px = 3 * look_of(self).px(GAP_PX)
        self._layout.setContentsMargins(margin_px, margin_px, margin_px, margin_px)


class JobBinding(Page):
    """Shows the job while there is one, the card of each fault, and a STOP without answer.

    Args:
        window: The window that the warning covers.
        survey: The survey that runs.
        traces: The traces, for the small map.
        top_bar: State, PAUSE and STOP.
        pages: Of CONTROL: the plan, then the job.
        dialogs: Shows the cards.
        clock: Measures how long a STOP is not confirmed.

    Attributes:
        view: The job screen.
        stop_warning: What is shown until a STOP is confirmed.
    """

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        traces: TracePresenter,
        top_bar: TopBar,
        pages: QStackedWidget,
        dialogs: SurveyBinding,
        clock: Clock,
    ) -> None:
        self._survey = survey
        self._traces = traces
        self._pages = pages
        self._dialogs = dialogs
        self._screen = JobScreen()
        self._faults = FaultWatch()
        self._stop = StopConfirmation(clock)
        # The survey that was described last, and its name.
        self._named = ("", "")
        self.view = JobView(traces.running.map)
        self.stop_warning = StopWarningView(window)
        self._plan_page = pages.currentIndex()
        self._job_page = pages.addWidget(self.view)
        self._answer_due = QTimer(window)
        self._answer_due.setSingleShot(True)
        self._answer_due.setTimerType(Qt.TimerType.PreciseTimer)
        self._answer_due.setInterval(math.ceil(ANSWER_S * 1000.0) + 1)
        self._answer_due.timeout.connect(self._show_stop)
        self.view.plan_pressed.connect(self.show_plan)
        self.view.fault_pressed.connect(self._show_state)
        top_bar.band.touched.connect(self._show_state)
        top_bar.stop.pressed.connect(self._on_stop)
        self.stop_warning.close_button.held.connect(self._on_stop_warning_closed)

    def on_event(self, event: object) -> None:
        """Follow what is known of a STOP, and the name of the survey."""
        self._stop.on_event(event)
        if isinstance(event, SurveyDescribed):
            self._named = survey_name(event.text)
            self._show_name()

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._screen.note(snapshot)
        page = self._job_page if self._screen.visible else self._plan_page
        if self._pages.currentIndex() != page:
            self._pages.setCurrentIndex(page)
        self._show_name()
        self.view.refresh(snapshot)
        self.view.map.set_carriage(self._traces.carriage_mm)
        fault = snapshot.replay is None and snapshot.state is not None and is_fault(snapshot.state)
        self.view.show_fault_button(fault)
        if snapshot.replay is None:
            self._note_fault(snapshot)
        self._show_stop()

    def draw(self) -> None:
        """Draw the small map."""
        self.view.draw(self._traces.running.map)

    def _show_name(self) -> None:
        """Show the name of the survey; not that of the one before it, until it is described."""
        survey_id, name = self._named
        state = self._survey.snapshot.state
        self.view.set_name(name if state is not None and state.survey_id == survey_id else "")

    def _note_fault(self, snapshot: Snapshot) -> None:
        state = self._faults.note(snapshot.state)
        if state is not None:
            self._dialogs.show_fault(fault_notice(state))
        elif not snapshot.paused:
            self._dialogs.hide_resumable()

    def _show_state(self) -> None:
        state, motion = self._survey.snapshot.state, motion_of(self._survey.snapshot)
        if motion is not None:
            self._dialogs.notice.show_notice(motion_notice(motion))
            return
        if state is None or self._survey.snapshot.replay is not None:
            return
        notice = fault_notice(state) if is_fault(state) else state_notice(state)
        self._dialogs.notice.show_notice(notice)

    def show_plan(self) -> None:
        """Show the plan of the next survey; not while one is running."""
        self._screen.leave(self._survey.snapshot)
        self.refresh(self._survey.snapshot)

    def _on_stop(self) -> None:
        self._stop.press(self._survey.snapshot)
        # Not with the next refresh, which may come later.
        self._answer_due.start()

    def _show_stop(self) -> None:
        self.stop_warning.show_warning(self._stop.warning(self._survey.snapshot))
        outcome, self._stop.outcome = self._stop.outcome, None
        if outcome is not None:
            self._dialogs.notice.show_notice(outcome)

    def _on_stop_warning_closed(self) -> None:
        self._stop.close()
        self.stop_warning.show_warning(None)

"""SURVEY: its plan, its result, or while it runs how far it is in large figures and its map."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QStackedWidget, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.traces import SurveyDescribed, TracePresenter
from gpr20_operator.robot.condition import left_of
from gpr20_operator.robot.snapshot import (
    Snapshot,
    area_of,
    line_of,
    percent_of,
    survey_name,
)
from gpr20_survey.plan.survey_state import ENDED
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.widgets.ground_picture import GroundPicture
from gpr20_user_interface.widgets.tile import LinesLabel
from gpr20_user_interface.widgets.widgets import Page, column, new_button, new_label, row


class JobPage(QWidget, Page):
    """Percentage, time that is left, line, name and area; the map fills the rest."""

    notes_pressed = pyqtSignal()

    def __init__(self, traces: TracePresenter) -> None:
        super().__init__()
        self._traces = traces
        # The survey that was described last, and its name.
        self._named = ("", "")
        self._drawn: object = None
        self.percent = new_label("percent")
        self.stored = new_label("quiet")
        self.left, self.line = new_label("figure", wraps=True), new_label("figure", wraps=True)
        self.area = LinesLabel()
        self.area.setObjectName("quiet")
        self.map = GroundPicture(interactive=False, beside=True)
        self.map.labels = ("X mm", "Y mm")
        self.notes = new_button(self.notes_pressed.emit, Message("NOTES"))
        left = column(self.percent, self.stored, self.left, self.line, (self.area, 1), self.notes)
        self.setLayout(row((left, 2), (self.map, 3), margin=GAP_PX))

    def on_event(self, event: object) -> None:
        """Follow the name of the survey."""
        if isinstance(event, SurveyDescribed):
            self._named = survey_name(event.text)

    def show_state(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        percent = percent_of(snapshot)
        self.percent.setText("—" if percent is None else f"{percent} %")
        progress, stored = snapshot.progress, None
        if percent is not None and progress is not None:
            done, planned = progress.visited_points, progress.total_points
            stored = Message("{done} of {planned} traces stored", done=done, planned=planned)
        for label, text in (
            (self.stored, stored),
            *((self.left, left_of(snapshot)), (self.line, line_of(snapshot))),
        ):
            label.setText("" if text is None else sentence_text(text))
            label.setVisible(text is not None)
        # Not the name of the survey before this one, until it is described.
        survey_id, name = self._named
        known = snapshot.state is not None and snapshot.state.survey_id == survey_id
        parameters = snapshot.job_parameters
        area = "" if parameters is None else shown_text(area_of(parameters))
        self.area.setText(", ".join(text for text in (name if known else "", area) if text))
        self.notes.setVisible(snapshot.running and not snapshot.replay)
        self._draw()

    def _draw(self) -> None:
        """Draw the map, if it is seen and something has changed."""
        model = self._traces.running.map
        state = model, model.revision, model.current
        if self.isVisible():
            self.map.set_carriage(self._traces.carriage_mm)
            if state != self._drawn:
                self._drawn = state
                self.map.show_coverage(model)


class SurveyTab(QStackedWidget, Page):
    """Shows the screen that the state of the survey needs.

    Args:
        plan: The plan of the next survey.
        job: A survey that runs, or a replay.
        result: A survey that has ended, or a stored one.
        open_result: Opens the result of a survey, by id or folder.
    """

    def __init__(
        self, plan: QWidget, job: QWidget, result: QWidget, open_result: Callable[[str], None]
    ) -> None:
        super().__init__()
        # The survey that ended and was left for the plan of the next one.
        self._left = ""
        self._plan, self._job = plan, job
        self._result, self._open_result = result, open_result
        # Folder of a stored survey whose result was opened; empty: none.
        self._opened = ""
        for screen in (plan, job, result):
            self.addWidget(screen)

    def show_state(self, snapshot: Snapshot) -> None:
        """Show the screen that is needed now."""
        if snapshot.running:
            self._opened = self._left = ""
        self._show(snapshot)

    def show_plan(self, snapshot: Snapshot) -> None:
        """Show the plan of the next survey; not while one is running."""
        self._opened = ""
        if snapshot.state is not None and not snapshot.running:
            self._left = snapshot.state.survey_id
        self._show(snapshot)

    def show_result(self, folder: str, snapshot: Snapshot) -> None:
        """Show the result of a stored survey; not while one is running."""
        if not snapshot.running:
            self._opened = folder
            self._show(snapshot)

    def _show(self, snapshot: Snapshot) -> None:
        survey, screen, state = self._opened, self._plan, snapshot.state
        if snapshot.running:
            screen = self._job
        elif state is not None and state.shown in ENDED and state.survey_id != self._left:
            # It stays until the next survey is planned.
            screen = self._job
            if not snapshot.replay:
                survey = survey or state.survey_id
        if survey:
            self._open_result(survey)
            screen = self._result
        if self.currentWidget() is not screen:
            self.setCurrentWidget(screen)

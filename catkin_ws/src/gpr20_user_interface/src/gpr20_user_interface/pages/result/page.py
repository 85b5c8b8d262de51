"""The page of a result: it searches by itself, and opens what belongs to a place."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QVBoxLayout, QWidget

from gpr20_operator.ground.trace_events import SurveyDescribed
from gpr20_operator.jobs.result import SurveyResult
from gpr20_operator.robot.events import Answer, Request
from gpr20_operator.robot.job import survey_name
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.results.candidates import Candidate
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.pages.result.sheets import (
    HidingSheet,
    PlaceSheet,
    SoilSheet,
    StickSheet,
)
from gpr20_user_interface.pages.result.view import ResultView
from gpr20_user_interface.widgets.page import Page


class ResultPage(QWidget, Page):
    """Shows the result of the survey that has ended, or of a stored one that was opened.

    Args:
        window: The window that its sheets cover.
        result: The result.
        languages: Languages of the window.
        operator: Returns who operates the robot now.
        permittivity: Returns that of the plan; None: its text is wrong.
    """

    # Id and folder of a survey; X, Y and depth of a place in mm.
    show_wanted = pyqtSignal(str, str, float, float, float)
    # A SurveyGrid, X and Y in mm.
    finer_wanted = pyqtSignal(object, float, float)
    # The operator plans the next survey.
    plan_wanted = pyqtSignal()

    def __init__(
        self,
        window: QWidget,
        result: SurveyResult,
        languages: Languages,
        operator: Callable[[], str],
        permittivity: Callable[[], Optional[float]],
    ) -> None:
        super().__init__()
        self.result = result
        self._permittivity = permittivity
        self.view = ResultView(result)
        self.place = PlaceSheet(window, result, operator)
        self.soil = SoilSheet(window, result)
        self.hiding = HidingSheet(window, result)
        self.stick = StickSheet(window, result, lambda: languages.language.value)
        self.sheets = (self.place, self.soil, self.hiding, self.stick)
        self.view.place_touched.connect(self.place.ask)
        self.view.stick_wanted.connect(self.stick.ask)
        self.view.hiding_wanted.connect(lambda: self.hiding.open_now())
        self.view.soil_wanted.connect(self.soil.ask)
        self.view.plan_wanted.connect(self.plan_wanted)
        self.place.finer_wanted.connect(self._on_finer)
        self.place.show_wanted.connect(self._on_show)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.view)

    def on_event(self, event: object) -> None:
        """Keep the permittivity of the plan with the survey that begins."""
        if isinstance(event, Answer) and event.request is Request.START and event.success:
            self.result.note_plan(event.survey_id, self._permittivity())
        elif isinstance(event, SurveyDescribed):
            # Not before the storage has opened it.
            self.result.store_soil(survey_name(event.text)[0])

    def refresh(self, snapshot: Snapshot) -> None:
        """Search when nothing else happens and the page is seen; never during a survey."""
        self.result.note_running(snapshot.running)
        if snapshot.running:
            for sheet in (*self.sheets, self.place.pad, self.soil.pad):
                sheet.hide()
        if self.isVisible() and snapshot.replay is None:
            self.result.keep()
        self._show()

    def end(self) -> None:
        """End what is awaited."""
        self.result.end()
        self.result.export.job.end()

    def _show(self) -> None:
        self.view.refresh()
        for sheet in self.sheets:
            sheet.refresh()

    def _on_finer(self, place: Candidate) -> None:
        if self.result.record is not None:
            self.finer_wanted.emit(self.result.record.grid, place.x_mm, place.y_mm)

    def _on_show(self, place: Candidate) -> None:
        if self.result.record is not None:
            survey = self.result.record.survey_id, self.result.survey
            self.show_wanted.emit(*survey, place.x_mm, place.y_mm, place.depth_mm)

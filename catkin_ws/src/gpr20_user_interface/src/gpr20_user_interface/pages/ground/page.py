"""GROUND: follows the survey that is shown, and passes the operator's wishes on."""

from __future__ import annotations

from typing import Callable, Optional, Tuple

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QWidget

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.ground.additions import AdditionsPresenter, MarkingFailed
from gpr20_operator.ground.finer_plan import FinerPlan
from gpr20_operator.ground.grid import SurveyGrid
from gpr20_operator.ground.model import GroundModel
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.plan.fields import Keys
from gpr20_operator.robot.events import Answer, Request
from gpr20_operator.robot.notices import Refused
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_survey.plan.annotation import check_text
from gpr20_survey.plan.markers import MAX_TEXT_CHARACTERS, TEXT
from gpr20_survey.plan.survey_cost import survey_cost
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.ground.finer_sheet import FinerSheet
from gpr20_user_interface.pages.ground.layers_sheet import LayersSheet
from gpr20_user_interface.pages.ground.markers_sheet import MarkersSheet
from gpr20_user_interface.pages.ground.view import GroundView
from gpr20_user_interface.widgets.keys import Pad
from gpr20_user_interface.widgets.page import Page

ShowRefusal = Callable[[Refused, Message], None]


class GroundPage(QObject, Page):
    """Shows the running survey, or a past one that was opened, with what belongs to it.

    Args:
        window: The window that the sheets cover.
        survey: The survey that runs.
        traces: Which survey is shown.
        additions: What belongs to that survey.
        imaging: Asks for focused images while the page is seen.
        show_refusal: Shows why something did not succeed.
    """

    # A FinerPlan that is to be measured now.
    finer_chosen = pyqtSignal(object)
    # A past survey was opened: the page should be seen.
    wanted = pyqtSignal()

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        traces: TracePresenter,
        additions: AdditionsPresenter,
        imaging: Imaging,
        show_refusal: ShowRefusal,
    ) -> None:
        super().__init__(window)
        self._survey, self._traces, self._additions = survey, traces, additions
        self._imaging, self._show_refusal = imaging, show_refusal
        self._running = self._replay = False
        self._described: Tuple[Optional[SurveyGrid], Optional[float]] = (None, None)
        # A place of another survey, which is shown as soon as that is here.
        self._awaited: Optional[Tuple[str, float, float, float]] = None
        self.model = GroundModel(traces.shown, additions)
        self.view = GroundView(self.model)
        self.layers = LayersSheet(window, self.model)
        self.finer = FinerSheet(window, self._duration_s)
        self.markers = MarkersSheet(window)
        self.note_pad = Pad(window)
        self._connect()

    def show_place(self, x_mm: float, y_mm: float, depth_mm: Optional[float] = None) -> None:
        """Bring crosshair, picture and depth to a place of the survey that is shown."""
        self.model.choose_place(x_mm, y_mm, depth_mm)
        self.view.pictures.enlarge(None)
        self.view.pictures.above.centre_on(x_mm, y_mm)
        self.view.refresh()

    def show_place_of(
        self, survey_id: str, folder: str, x_mm: float, y_mm: float, depth_mm: float
    ) -> None:
        """Show a place of a survey, which is read first if another one is shown."""
        self._awaited = survey_id, x_mm, y_mm, depth_mm
        if self._traces.running.survey_id == survey_id:
            self._traces.show_live()
        elif self._traces.shown.survey_id != survey_id:
            self._traces.open_survey(folder)
        self._follow()

    def on_event(self, event: object) -> None:
        """Take what belongs to a survey."""
        self._traces.on_event(event)
        self._follow()
        self._additions.on_event(event)
        if isinstance(event, MarkingFailed):
            self._show_refusal(Refused.MARKER, event.reason)
        if isinstance(event, Answer) and event.request is Request.START and event.success:
            if self._survey.finer is not None and self._survey.finer == self._additions.plan:
                self._additions.keep_plan(None)
            self._survey.finer = None

    def refresh(self, snapshot: Snapshot) -> None:
        """Follow the survey that is shown, and whether one runs."""
        self._replay = snapshot.replay is not None
        self._traces.note_state(snapshot)
        self._follow()
        additions = self._additions
        additions.follow(self._traces.shown.survey_id, not self._replay)
        additions.refresh()
        self.finer.note_running(snapshot.running)
        self.markers.set_markers(additions.markers)
        if snapshot.running != self._running:
            # A finer survey may have begun or ended.
            self._running = snapshot.running
            additions.read_again()

    def draw(self) -> None:
        """Request the missing traces and draw what is new."""
        self._traces.refresh()
        self._follow_soil()
        if not self._replay and self.view.isVisible():
            self.model.keep_image(self._imaging)
        self.view.problem = self._imaging.problem
        self.view.carriage_mm = self._traces.carriage_mm
        self.view.refresh()

    def _connect(self) -> None:
        view, additions = self.view, self._additions
        view.set_marker.clicked.connect(lambda: self._ask_marker())
        view.finer.clicked.connect(lambda: self._ask_finer())
        view.layers.clicked.connect(lambda: self.layers.open())
        view.back.clicked.connect(lambda: self._traces.show_live())
        view.back.clicked.connect(lambda: self._follow())
        view.opened.connect(additions.read_again)
        self.layers.changed.connect(view.refresh)
        self.layers.fit.clicked.connect(lambda: view.begin_fit())
        self.layers.markers.clicked.connect(lambda: self.markers.show_markers(additions.markers))
        self.finer.chosen.connect(self._on_plan)
        self.finer.dropped.connect(lambda: self._keep(None))
        self.markers.show_wanted.connect(self.model.choose_mark)
        self.markers.show_wanted.connect(view.refresh)
        self.markers.remove_wanted.connect(lambda one: additions.remove_marker(one.marker_id))

    def _ask_marker(self) -> None:
        """Ask for the text of a marker at the crosshair, and store it."""
        point = self.model.point
        if point is None or not self._additions.can_mark:
            return
        x_mm, y_mm, depth_mm = point
        # Another survey may begin while the text is written.
        survey = self._additions.survey_id

        def add(text: str) -> None:
            try:
                self._additions.add_marker(survey, x_mm, y_mm, depth_mm, text)
            except InvalidValueError as error:
                self._show_refusal(Refused.MARKER, error.message)

        self.note_pad.ask(
            add,
            shown_text(Message("Text of the marker")),
            shown_text(Message("at most {count} characters", count=MAX_TEXT_CHARACTERS)),
            "",
            _problem_of_text,
            Keys.LETTERS,
        )

    def _ask_finer(self) -> None:
        """Open the plan that was kept, or ask how to measure the crosshair more finely."""
        grid, plan, point = self._traces.shown.map.grid, self._additions.plan, self.model.point
        if grid is not None and plan is not None:
            self.finer.show_plan(grid, plan)
        elif grid is not None and grid.plan is not None and point is not None:
            self.finer.show_place(grid, *point[:2])

    def _on_plan(self, plan: FinerPlan) -> None:
        self._keep(plan)
        if not self._running:
            self._survey.finer = plan
            self.finer_chosen.emit(plan)

    def _keep(self, plan: Optional[FinerPlan]) -> None:
        self._additions.keep_plan(plan)
        if plan is None:
            self._survey.finer = None
        self.view.refresh()

    def _duration_s(self, parameters: SurveyParameters) -> Optional[float]:
        robot = self._survey.snapshot.robot
        if robot is None:
            return None
        return survey_cost(parameters, robot.config, robot.settings).duration_s

    def _follow(self) -> None:
        """Show another survey if another one was opened, or the running one again."""
        self.view.show_band(self._traces.band)
        shown = self._traces.shown
        if shown is not self.model.survey:
            self.model.show_survey(shown)
            self.view.refresh()
            if self._traces.opened_folder:
                self.wanted.emit()
        if self._awaited is not None and self._awaited[0] == shown.survey_id:
            place, self._awaited = self._awaited[1:], None
            self.show_place(*place)
            self.wanted.emit()

    def _follow_soil(self) -> None:
        """Use the permittivity of the survey that is shown."""
        grid, soils = self._traces.shown.map.grid, self._imaging.soils
        if grid is not None:
            if (grid, grid.permittivity) != self._described:
                self._described = grid, grid.permittivity
                if grid.permittivity is not None:  # of a survey that runs it is not read yet
                    soils.take(grid.survey_id, grid.permittivity)
            self.model.take_soil(grid.survey_id, soils.of(grid.survey_id))


def _problem_of_text(text: str) -> str:
    try:
        check_text(TEXT, text, MAX_TEXT_CHARACTERS)
    except InvalidValueError as error:
        return shown_text(error.message)
    return ""

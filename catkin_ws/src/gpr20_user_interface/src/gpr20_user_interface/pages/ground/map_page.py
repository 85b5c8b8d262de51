"""Connects MAP with markers, candidates and the plan of a finer survey."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtWidgets import QWidget

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.finer_plan import FinerPlan
from gpr20_operator.ground.grid import Cell
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.robot.events import Answer, Request
from gpr20_operator.robot.notices import Refused
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_survey.plan.annotation import check_text
from gpr20_survey.plan.markers import MAX_TEXT_CHARACTERS, TEXT, Marker
from gpr20_survey.plan.survey_cost import survey_cost
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.ground.finer_sheet import FinerSheet
from gpr20_user_interface.pages.ground.map_selection import Selection
from gpr20_user_interface.pages.ground.map_view import MapView
from gpr20_user_interface.pages.ground.markers_sheet import MarkersSheet
from gpr20_user_interface.pages.ground.trace_sheet import TraceSheet
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.text_pad import TextPad

ShowRefusal = Callable[[Refused, Message], None]


class MapBinding(Page):
    """Opens the sheets of MAP and passes the operator's requests on.

    Args:
        window: The window that the sheets cover.
        survey: The survey that runs.
        traces: Which survey MAP and RADAR show.
        additions: What belongs to that survey.
        map_view: MAP.
        use_parameters: Puts the parameters of a plan into CONTROL and brings it to the front.
        show_refusal: Shows why something did not succeed.

    Attributes:
        trace: The sheet of a trace.
        finer: The sheet of the plan of a finer survey.
        markers: The sheet of the markers.
        note_pad: The keys for the text of a marker.
    """

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        traces: TracePresenter,
        additions: AdditionsPresenter,
        map_view: MapView,
        use_parameters: Callable[[SurveyParameters], None],
        show_refusal: ShowRefusal,
    ) -> None:
        self._survey = survey
        self._traces = traces
        self._additions = additions
        self._map = map_view
        self._use_parameters = use_parameters
        self._show_refusal = show_refusal
        self._running = False
        self.trace = TraceSheet(window)
        self.finer = FinerSheet(window, self._duration_s)
        self.markers = MarkersSheet(window)
        self.note_pad = TextPad(window)
        map_view.trace_wanted.connect(self._on_trace)
        map_view.marker_wanted.connect(self.ask_marker)
        map_view.markers_wanted.connect(lambda: self.markers.show_markers(additions.markers))
        map_view.finer_wanted.connect(self._on_finer)
        map_view.opened.connect(additions.read_again)
        self.finer.chosen.connect(self._on_plan)
        self.finer.dropped.connect(lambda: self._keep(None))
        self.markers.show_wanted.connect(map_view.select_mark)
        self.markers.remove_wanted.connect(self._on_remove)

    def on_event(self, event: object) -> None:
        """Take what belongs to a survey."""
        self._additions.on_event(event)
        problem = self._additions.take_problem()
        if problem is not None:
            self._show_refusal(Refused.MARKER, problem)
        started = isinstance(event, Answer) and event.request is Request.START and event.success
        if started:
            if self._survey.finer is not None and self._survey.finer == self._additions.plan:
                self._additions.keep_plan(None)
            self._survey.finer = None

    def refresh(self, snapshot: Snapshot) -> None:
        """Follow the survey that MAP shows, and whether one runs."""
        self._additions.follow(self._traces.shown.survey_id, snapshot.replay is None)
        self._additions.refresh()
        if not snapshot.running and snapshot.replay is None:
            self._additions.focus_finer()
        self.finer.note_running(snapshot.running)
        self.markers.set_markers(self._additions.markers)
        if snapshot.running != self._running:
            # A finer survey may have begun or ended.
            self._running = snapshot.running
            self._additions.read_again()

    def ask_marker(self, x_mm: float, y_mm: float, depth_mm: Optional[float]) -> None:
        """Ask for the text of a marker, and store it."""
        if not self._additions.can_mark:
            return
        # Another survey may begin while the text is written.
        survey = self._additions.survey_id
        self.note_pad.ask(
            lambda text: self._add_marker(survey, x_mm, y_mm, depth_mm, text),
            shown_text(Message("Text of the marker")),
            shown_text(Message("at most {count} characters", count=MAX_TEXT_CHARACTERS)),
            "",
            _problem_of_text,
            several_lines=False,
        )

    def _add_marker(
        self, survey: str, x_mm: float, y_mm: float, depth_mm: Optional[float], text: str
    ) -> None:
        try:
            self._additions.add_marker(survey, x_mm, y_mm, depth_mm, text)
        except InvalidValueError as error:
            self._show_refusal(Refused.MARKER, error.message)

    def _on_remove(self, marker: Marker) -> None:
        self._additions.remove_marker(marker.marker_id)

    def _on_trace(self, cell: Cell) -> None:
        shown = self._traces.shown
        self.trace.show_trace(shown.map, shown.radar, cell)

    def _on_finer(self, selected: Optional[Selection]) -> None:
        grid, plan = self._traces.shown.map.grid, self._additions.plan
        if grid is None:
            return
        if selected is not None:
            self.finer.show_place(grid, selected.x_mm, selected.y_mm)
        elif plan is not None:
            self.finer.show_plan(grid, plan)

    def _on_plan(self, plan: FinerPlan) -> None:
        self._keep(plan)
        if not self._running:
            self._survey.finer = plan
            self._use_parameters(plan.parameters)

    def _keep(self, plan: Optional[FinerPlan]) -> None:
        self._additions.keep_plan(plan)
        if plan is None:
            self._survey.finer = None
        self._map.refresh()

    def _duration_s(self, parameters: SurveyParameters) -> Optional[float]:
        figures = self._survey.snapshot.figures
        if figures is None:
            return None
        return survey_cost(parameters, figures.config, figures.settings).duration_s


def _problem_of_text(text: str) -> str:
    try:
        check_text(TEXT, text, MAX_TEXT_CHARACTERS)
    except InvalidValueError as error:
        return shown_text(error.message)
    return ""

"""Between MAP, RADAR, the list of past surveys and the storage; in the thread of the window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from PyQt5.QtCore import QObject, QTimer, pyqtSignal

from gpr20_user_interface.errors import SurveyNotReadableError
from gpr20_user_interface.mid.map_coverage import CoverageRuns, coverage_of_stored
from gpr20_user_interface.mid.map_grid import grid_from_description
from gpr20_user_interface.mid.past_surveys import PastSurveys
from gpr20_user_interface.mid.radar_model import RadarTrace
from gpr20_user_interface.mid.shown_survey import ShownSurvey
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.trace_events import (
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TraceSource,
    TracesRead,
)
from gpr20_user_interface.views.map_view import MapView
from gpr20_user_interface.views.past_surveys_view import PastSurveysView
from gpr20_user_interface.views.radar_view import RadarView

# A trace must be seen within a second; drawing more often than this costs a core and shows no more.
REFRESH_MS = 250
# How long a page that was asked for may be on its way, in refreshes, before it is asked for again.
PATIENCE_REFRESHES = 80


@dataclass(frozen=True)
class SurveyViews:
    """The widgets that this presenter fills; the frame puts them into its tabs."""

    map: MapView
    radar: RadarView
    past: PastSurveysView


class TracePresenter(QObject):
    """Carries what the storage and main_control say of traces to the views."""

    # A past survey is on RADAR now: the frame may bring that tab to the front.
    radar_wanted = pyqtSignal()
    # The name of a past survey's folder.
    resume_requested = pyqtSignal(str)
    # A trace or a survey that cannot be shown, for people.
    problem = pyqtSignal(str)

    def __init__(self, source: TraceSource) -> None:
        super().__init__()
        self._source = source
        self._live = ShownSurvey()
        self._opened: Optional[ShownSurvey] = None
        self._coverage: Optional[CoverageRuns] = None
        self._past = PastSurveys()
        self._waiting = 0
        self.views = SurveyViews(
            MapView(self._live.map, self._live.radar),
            RadarView(self._live.radar),
            PastSurveysView(self._past),
        )
        self.views.past.page_requested.connect(source.list_surveys)
        self.views.past.open_requested.connect(source.read_survey)
        self.views.past.resume_requested.connect(self.resume_requested)
        self.views.radar.back_to_live_requested.connect(self.show_live)
        self._timer = QTimer(self)
        self._timer.setInterval(REFRESH_MS)
        self._timer.timeout.connect(self.refresh)

    @property
    def shown(self) -> ShownSurvey:
        """The survey on MAP and RADAR: a past one that was opened, else the one that runs."""
        return self._opened or self._live

    @property
    def live(self) -> ShownSurvey:
        """The survey that runs, or ran last."""
        return self._live

    def begin(self) -> None:
        """Keep the views up to date from now on."""
        self._timer.start()

    def end(self) -> None:
        """Leave the views as they are."""
        self._timer.stop()

    def on_event(self, event: object) -> None:
        """Take note of what the storage or main_control says of traces."""
        try:
            self._take(event)
        except SurveyNotReadableError as error:
            self.problem.emit(str(error))

    def show_state(self, snapshot: Snapshot) -> None:
        """Show where the antennas are and whether a survey is on its way."""
        target, current = snapshot.target, snapshot.current
        if target is None:
            self._live.map.clear_target()
        else:
            self._live.map.set_target(target.x_mm, target.y_mm)
        is_live = self._opened is None
        place_mm = None if current is None or not is_live else (current.x_mm, current.y_mm)
        self.views.map.set_carriage(place_mm)
        running = snapshot.state.survey_id if snapshot.state and snapshot.running else ""
        if self._past.set_running(running):
            self._list_anew()

    def show_live(self) -> None:
        """Show the survey that runs; the past one is forgotten."""
        self._opened = None
        self._show()

    def refresh(self) -> None:
        """Ask for the traces that lack and draw what is new."""
        self._take_newest_coverage()
        self._ask_for_traces()
        self.views.map.refresh()
        self.views.radar.refresh()

    def _take(self, event: object) -> None:
        if isinstance(event, RadarTrace):
            self._live.take_trace(event)
        elif isinstance(event, CoverageRuns):
            self._coverage = event
        elif isinstance(event, SurveyDescribed):
            self._live.begin(grid_from_description(event.text))
            self._list_anew()
        elif isinstance(event, TracesRead):
            self._waiting = 0
            for problem in self.shown.take_page(event):
                self.problem.emit(problem)
        elif isinstance(event, SurveyRead):
            self._open(event)
        elif isinstance(event, SurveysListed):
            self._past.take(event.before, event.surveys, event.more)
            self.views.past.refresh()
        elif isinstance(event, ReadingFailed):
            self.views.past.show_problem(event.reason)

    def _take_newest_coverage(self) -> None:
        # Here and not when it comes, once per trace: working out the states of all stops takes
        # milliseconds. Coverage and plan are told by two nodes: either may come first, and for
        # a moment they speak of different surveys.
        coverage = self._coverage
        if coverage is None or coverage.survey_id != self._live.survey_id:
            return
        self._coverage = None
        try:
            self._live.take_coverage(coverage)
        except SurveyNotReadableError as error:
            self.problem.emit(str(error))

    def _list_anew(self) -> None:
        self.views.past.refresh()
        if self.views.past.isVisible():
            self._source.list_surveys("")

    def _open(self, survey: SurveyRead) -> None:
        grid = grid_from_description(survey.text)
        opened = ShownSurvey()
        opened.begin(grid)
        opened.take_coverage(
            coverage_of_stored(grid.survey_id, grid.planned, survey.stored_indices)
        )
        self._opened = opened
        self._show(survey.folder)
        self.radar_wanted.emit()

    def _show(self, folder: str = "") -> None:
        self._waiting = 0
        self.views.map.show_models(self.shown.map, self.shown.radar)
        self.views.radar.show_model(self.shown.radar, folder)

    def _ask_for_traces(self) -> None:
        if self._waiting:
            # The answer may have been lost with the storage.
            self._waiting = (self._waiting + 1) % PATIENCE_REFRESHES
            return
        first_index = self.shown.next_page()
        if first_index is not None:
            self._waiting = 1
            self._source.read_traces(self.shown.survey_id, first_index)

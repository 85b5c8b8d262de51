"""Between the storage and MAP, RADAR and the list of past surveys: which survey they show."""

from __future__ import annotations

from typing import Callable, Optional, Protocol, Tuple

from gpr20_common.message import Message
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.trace.trace import Trace
from gpr20_user_interface.errors import SurveyNotReadableError
from gpr20_user_interface.mid.map_coverage import CoverageRuns, coverage_of_stored
from gpr20_user_interface.mid.map_grid import grid_from_description
from gpr20_user_interface.mid.past_surveys import PastSurveys
from gpr20_user_interface.mid.shown_survey import ShownSurvey
from gpr20_user_interface.mid.survey_additions import AdditionsSource
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.trace_events import (
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TracesRead,
)

# How long to wait for a page, in refreshes, before it is requested again.
RETRY_REFRESHES = 80


class TraceSource(AdditionsSource, Protocol):
    """Requests to the storage, without waiting; the answers come as events."""

    def list_surveys(self, before: str) -> None:
        """Ask for the surveys older than a folder; empty: for the newest."""

    def read_survey(self, folder: str) -> None:
        """Ask for the plan of a past survey."""

    def read_traces(self, survey: str, first_index: int) -> None:
        """Ask for a page of stored traces of a survey, by its id."""

    def read_annotation(self, survey: str) -> None:
        """Ask for the annotation of a survey, by its id or folder."""

    def annotate(self, survey: str, annotation: Annotation) -> None:
        """Ask to replace the annotation of a survey, by its id or folder."""


class TracePresenter:
    """Collects what the storage and the main control report about traces. Belongs to one thread.

    Args:
        source: The storage.
        report: Called with the reason why a trace or a survey cannot be shown.

    Attributes:
        live: The survey that runs or ran last.
        past: The list of past surveys.
        carriage_mm: Where the antennas are on the map (X, Y); None if that is not known, or if a
            past survey is shown.
        opened_folder: The folder of the past survey that is shown; empty: the one that runs.
    """

    def __init__(self, source: TraceSource, report: Callable[[Message], None]) -> None:
        self.source = source
        self.live = ShownSurvey()
        self.past = PastSurveys()
        self.carriage_mm: Optional[Tuple[float, float]] = None
        self._report = report
        self._opened: Optional[ShownSurvey] = None
        self.opened_folder = ""
        self._coverage: Optional[CoverageRuns] = None
        self._replay = False
        self._waiting = 0

    @property
    def shown(self) -> ShownSurvey:
        """The survey on MAP and RADAR: a past one that was opened, else the one that runs."""
        return self._opened or self.live

    def on_event(self, event: object) -> None:
        """Take an event about traces."""
        try:
            self._take(event)
        except SurveyNotReadableError as error:
            self._report(error.message)

    def note_state(self, snapshot: Snapshot) -> None:
        """Note where the antennas are and whether a survey is running."""
        target, current = snapshot.target, snapshot.current
        self.live.map.set_target(None if target is None else (target.x_mm, target.y_mm))
        self.carriage_mm = None if current is None or self._opened else (current.x_mm, current.y_mm)
        self._note_replay(snapshot.replay is not None)
        running = snapshot.state.survey_id if snapshot.state and snapshot.running else ""
        self.past.set_running(running)

    def _note_replay(self, replay: bool) -> None:
        if self._replay and not replay:
            # A robot has appeared: nothing of the replay may pass for its survey.
            self.live = ShownSurvey()
            self._coverage = None
        if replay != self._replay:
            self._replay = replay
            self.past.set_replay(replay)

    def show_live(self) -> None:
        """Show the survey that runs, and drop the past one."""
        self._opened, self.opened_folder = None, ""
        self._waiting = 0

    def refresh(self) -> None:
        """Take the newest coverage and request the missing traces."""
        self._take_newest_coverage()
        self._ask_for_traces()

    def _take(self, event: object) -> None:
        if isinstance(event, Trace):
            self.live.take_trace(event)
        elif isinstance(event, CoverageRuns):
            self._coverage = event
        elif isinstance(event, SurveyDescribed):
            self.live.begin(grid_from_description(event.text))
            self.past.set_outdated()
        elif isinstance(event, TracesRead):
            self._waiting = 0
            for problem in self.shown.take_page(event):
                self._report(problem)
        elif isinstance(event, SurveyRead):
            self._open(event)
        elif isinstance(event, SurveysListed):
            self.past.take(event.before, event.surveys, event.more)
        elif isinstance(event, ReadingFailed):
            self.past.set_problem(event.reason)

    def _take_newest_coverage(self) -> None:
        # Here and not when it comes, once per trace: working out the states of all stops takes
        # milliseconds. Coverage and plan come from two nodes: either may come first, and for
        # a moment they belong to different surveys.
        coverage = self._coverage
        if coverage is None or coverage.survey_id != self.live.survey_id:
            return
        self._coverage = None
        try:
            self.live.map.set_coverage(coverage)
        except SurveyNotReadableError as error:
            self._report(error.message)

    def _open(self, survey: SurveyRead) -> None:
        grid = grid_from_description(survey.text)
        opened = ShownSurvey()
        opened.begin(grid)
        opened.map.set_coverage(
            coverage_of_stored(grid.survey_id, grid.planned, survey.stored_indices)
        )
        self._opened, self.opened_folder = opened, survey.folder
        self._waiting = 0

    def _ask_for_traces(self) -> None:
        if self._replay and self._opened is None:
            # No storage has them: they come with the replay.
            return
        if self._waiting:
            # The answer may have been lost with the storage.
            self._waiting = (self._waiting + 1) % RETRY_REFRESHES
            return
        first_index = self.shown.next_page()
        if first_index is not None:
            self._waiting = 1
            self.source.read_traces(self.shown.survey_id, first_index)

"""Between the storage and the pages: which survey they show, and what is known of it."""

from __future__ import annotations

from typing import Callable, List, Optional, Protocol, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.additions import AdditionsSource
from gpr20_operator.ground.coverage import CoverageRuns, coverage_of_stored
from gpr20_operator.ground.grid import grid_from_description
from gpr20_operator.ground.past_surveys import PastSurveys, past_band, survey_label
from gpr20_operator.ground.shown_survey import ShownSurvey
from gpr20_operator.ground.trace_events import (
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TracesRead,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.words import local_time
from gpr20_survey.trace.trace import Trace

# How long to wait for traces, in refreshes, before it is requested again.
RETRY_REFRESHES = 80


class TraceSource(AdditionsSource, Protocol):
    """Requests to the storage, without waiting; the answers come as events."""

    def list_surveys(self, before: str) -> None:
        """Ask for the surveys older than a folder; empty: for the newest."""

    def read_survey(self, folder: str) -> None:
        """Ask for the plan of a past survey."""

    def read_traces(self, survey: str, indices: Tuple[int, ...]) -> None:
        """Ask for stored traces of a survey, by its id and their places in the plan."""


class TracePresenter:
    """Collects what the storage and the main control report about traces. Belongs to one thread.

    Args:
        source: The storage.
        report: Called with the reason why a trace or a survey cannot be shown.

    Attributes:
        live: The last survey whose plan is known; the one that runs, unless that has just begun.
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
        # Of a survey that has begun and whose plan has not come: nothing of the one before it.
        self._awaited = ShownSurvey()
        self._running_id = ""
        self._measuring = False
        # The survey that is replayed, empty if it is not known; None: there is a robot.
        self._replayed_id: Optional[str] = None
        self._coverage: Optional[CoverageRuns] = None
        self._arrived: List[Trace] = []
        self.show_live()

    @property
    def shown(self) -> ShownSurvey:
        """The survey on every tab: a past one that was opened, else the one that runs."""
        return self.running if self._opened is None else self._opened

    @property
    def running(self) -> ShownSurvey:
        """The survey that runs or ran last; empty while the plan of one that begins is awaited."""
        expected = self._running_id or self._replayed_id or self.live.survey_id
        return self.live if expected == self.live.survey_id else self._awaited

    @property
    def band(self) -> Optional[Message]:
        """What pages say of a past survey that they show; None: they show the one that runs."""
        if self._opened is None:
            return None
        label, survey = verbatim(self.opened_folder), self.past.find(self.opened_folder)
        if survey is not None:
            label = survey_label(
                survey.name, survey.survey_id, local_time(survey.started, survey.folder)
            )
        if self._running_id:
            return Message("NOT THE RUNNING SURVEY: {name}", name=label)
        return past_band(label, "" if survey is None else survey.outcome)

    def open_survey(self, folder: str) -> None:
        """Ask for a past survey; it is shown once it is read."""
        self._wanted_folder = folder
        self.source.read_survey(folder)

    def show_live(self) -> None:
        """Show the survey that runs, and drop the past one."""
        self._opened: Optional[ShownSurvey] = None
        self.opened_folder = self._wanted_folder = ""
        self._waiting = 0

    def note_state(self, snapshot: Snapshot) -> None:
        """Note where the antennas are and which survey is running; show one that begins."""
        if snapshot.replay is not None:
            if self._replayed_id is None:
                self.past.set_replay(True)
            self._replayed_id = snapshot.replay.survey_id
        running_id, measuring = snapshot.running_survey, snapshot.running and not snapshot.paused
        if measuring and (not self._measuring or running_id != self._running_id):
            self.show_live()
        self._running_id, self._measuring = running_id, measuring
        target, current = snapshot.target, snapshot.current
        self.live.map.set_target(None if target is None else (target.x_mm, target.y_mm))
        self.carriage_mm = None if current is None or self._opened else (current.x_mm, current.y_mm)
        self.past.set_running(running_id)

    def on_event(self, event: object) -> None:
        """Take an event about traces."""
        try:
            self._take(event)
        except SurveyNotReadableError as error:
            self._report(error.message)

    def refresh(self) -> None:
        """Take what has come, and request the missing traces."""
        # Here and not with each event: many traces at once take hardly longer than one, and working
        # out the states of all stops takes milliseconds.
        arrived, self._arrived = self._arrived, []
        for problem in self.live.take_traces(arrived):
            self._report(problem)
        # Coverage and plan come from two nodes: either may come first, and for a moment they
        # belong to different surveys.
        coverage = self._coverage
        if coverage is not None and coverage.survey_id == self.live.survey_id:
            self._coverage = None
            try:
                self.live.map.set_coverage(coverage)
            except SurveyNotReadableError as error:
                self._report(error.message)
        self._ask_for_traces()

    def _take(self, event: object) -> None:
        if isinstance(event, Trace):
            self._arrived.append(event)
        elif isinstance(event, CoverageRuns):
            self._coverage = event
        elif isinstance(event, SurveyDescribed):
            self.live.begin(grid_from_description(event.text))
            self.past.set_outdated()
        elif isinstance(event, TracesRead):
            self._waiting = 0
            for problem in self.shown.take_block(event):
                self._report(problem)
            self._ask_for_traces()
        elif isinstance(event, SurveyRead):
            self._open(event)
        elif isinstance(event, SurveysListed):
            self.past.take(event.before, event.surveys, event.more)
        elif isinstance(event, ReadingFailed):
            self.past.set_problem(event.reason)

    def _open(self, survey: SurveyRead) -> None:
        if survey.folder != self._wanted_folder:
            return  # a survey has begun since it was asked for
        grid, opened = grid_from_description(survey.text), ShownSurvey()
        opened.begin(grid)
        opened.map.set_coverage(
            coverage_of_stored(grid.survey_id, grid.planned, survey.stored_indices)
        )
        self._opened, self.opened_folder = opened, survey.folder
        self._waiting = 0

    def _ask_for_traces(self) -> None:
        if self._replayed_id is not None:
            # No storage has them: they come with the replay.
            return
        if self._waiting:
            # The answer may have been lost with the storage.
            self._waiting = (self._waiting + 1) % RETRY_REFRESHES
            return
        due = self.shown.due()
        if due:
            self._waiting = 1
            self.source.read_traces(self.shown.survey_id, due)

"""The traces of surveys, running and past: what is shown of which, and what is still to be read."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import Callable, Iterable, List, Optional, Tuple

import numpy as np

from gpr20_common.message import Message, verbatim
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.coverage import CoverageRuns, MapModel, coverage_of_stored
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import SurveyGrid, grid_from_description
from gpr20_operator.ground.past_surveys import PastSurveys, past_band, survey_label
from gpr20_operator.jobs.job import Job, JobState, Service
from gpr20_operator.jobs.pictures import (
    SURVEYS_PER_PAGE,
    Imaging,
    StoredSurvey,
    SurveysListed,
    TracesRead,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.words import local_time
from gpr20_survey.trace.trace import Trace, TraceBlock

# What the storage answers at once at most.
TRACES_PER_BLOCK = 1000
# After a failure it is asked again [s].
RETRY_S = 10.0


@dataclass(frozen=True)
class SurveyDescribed:
    """The storage has opened a survey; its survey.json as it was then."""

    text: str


@dataclass(frozen=True)
class Loading:
    """How far the stored traces of a survey have been read.

    A stop that waits is "loading", never "not measured": what is not here yet says nothing about
    the ground. It is over when `loaded` is `stored`. A trace that a running survey has just stored
    waits, too, for a fraction of a second.

    Attributes:
        loaded: How many traces are here.
        stored: How many will be: all that are stored, but those that cannot be shown
            (`RadarModel.given_up`).
        waiting: Which stored traces are not here yet (bool, polarizations x rows x columns).
    """

    loaded: int
    stored: int
    waiting: np.ndarray


class ShownSurvey:
    """A MapModel and a RadarModel of the same survey.

    Traces that the coverage lists as stored and the radar lacks are read from the storage: those
    from before this window was started, and those that the topic lost.
    """

    def __init__(self) -> None:
        self.map = MapModel()
        self.radar = RadarModel()
        self._lacking = np.zeros(0, np.intp)
        self._loading: Tuple[object, Loading] = None, Loading(0, 0, np.zeros((0, 0, 0), bool))

    @property
    def survey_id(self) -> str:
        """UUID; empty while no plan is known."""
        grid = self.map.grid
        return "" if grid is None else grid.survey_id

    def begin(self, grid: SurveyGrid) -> None:
        """Show the survey of a plan; one that is shown already stays as it is.

        Raises:
            SurveyNotReadableError: Its coverage contradicts the plan.
        """
        own = self.map.grid
        if own is None or (own.survey_id, own.plan) != (grid.survey_id, grid.plan):
            self._lacking = self._lacking[:0]
            self.radar.begin(grid)
            self.map.set_grid(grid)

    def take_traces(self, traces: Iterable[Trace]) -> Tuple[Message, ...]:
        """Take those traces that are of this survey; return why some of them cannot be shown.

        Many at once take hardly longer than one.
        """
        # One that came twice is in no block twice: the last one counts.
        own = {one.index: one for one in traces if one.survey_id == self.survey_id}
        problems: List[Message] = []
        for _same, some in groupby(own.values(), lambda one: one.frequency_hz.tobytes()):
            problems += self.radar.add_block(TraceBlock.of(self.survey_id, list(some)))
        return tuple(problems)

    def take_block(self, first_index: int, read: TracesRead) -> Tuple[Message, ...]:
        """Take traces that were read from a place on; return why some cannot be shown."""
        if read.block.survey_id != self.survey_id:
            return ()
        unreadable = dict(read.unreadable)
        problems = [*self.radar.add_block(read.block)]
        # Whatever the answer was, the same place is not requested again and again.
        if first_index in self._absent() and first_index not in unreadable:
            unreadable[first_index] = Message("the storage has no file of this trace")
        for index, reason in unreadable.items():
            self.radar.give_up(index, reason)
            problems.append(Message("trace {index}: {reason}", index=index, reason=reason))
        return tuple(problems)

    def due(self) -> Tuple[int, ...]:
        """Return the places in the plan whose traces to read now; empty: all are here.

        A trace that was stored just now may still come on the topic: it is due only if it is
        absent at two calls in a row.
        """
        absent = self._absent()
        due = absent[np.isin(absent, self._lacking)]
        self._lacking = absent
        return tuple(due[:TRACES_PER_BLOCK].tolist())

    @property
    def loading(self) -> Loading:
        """How much of what is stored is here."""
        grid, revisions = self.map.grid, (self.map.revision, self.radar.revision)
        if grid is not None and self._loading[0] != revisions:
            absent, count = self._absent(), self.radar.count
            waiting = np.zeros((len(grid.rotations_deg), *grid.shape), bool)
            row, column, polarization = grid.cells(absent)
            waiting[polarization, row, column] = True
            self._loading = revisions, Loading(count, count + len(absent), waiting)
        return self._loading[1]

    def _absent(self) -> np.ndarray:
        return self.radar.absent(self.map.stored)


class TracePresenter:
    """Collects what the storage and the main control report about traces. Belongs to one thread.

    Args:
        imaging: Asks the storage.
        report: Called with the reason why a trace or a survey cannot be shown.

    Attributes:
        live: The last survey whose plan is known; the one that runs, unless that has just begun.
        past: The list of past surveys.
        carriage_mm: Where the antennas are on the map (X, Y); None if that is not known, or if a
            past survey is shown.
        opened_folder: The folder of the past survey that is shown; empty: the one that runs.
    """

    def __init__(self, imaging: Imaging, report: Callable[[Message], None]) -> None:
        self.live = ShownSurvey()
        self.past = past = PastSurveys()
        self._listing: Job[SurveysListed] = imaging.job(
            Service.LIST, self._take_list, past.set_problem
        )
        self.opening: Job[StoredSurvey] = imaging.job(Service.READ, self._open, past.set_problem)
        self._reading: Job[TracesRead] = imaging.job(
            Service.TRACES, self._take_read, past.set_problem
        )
        # The folder before which the page ends that was asked for last, the folder to open, and
        # the place of the first trace that is read.
        self._before = self._wanted = ""
        self._first_due = 0
        self.carriage_mm: Optional[Tuple[float, float]] = None
        self._report = report
        # Of a survey that has begun and whose plan has not come: nothing of the one before it.
        self._awaited = ShownSurvey()
        self._running_id = ""
        self._measuring = False
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
        expected = self._running_id or self.live.survey_id
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

    def list_surveys(self, before: str = "") -> None:
        """Ask for the past surveys older than a folder; empty: for the newest."""
        self._before = before
        self._listing.ask(before=before, max_surveys=SURVEYS_PER_PAGE)

    def open_survey(self, folder: str) -> None:
        """Ask for a past survey; it is shown once it is read."""
        self._wanted = folder
        self.opening.ask(survey=folder)

    def show_live(self) -> None:
        """Show the survey that runs, and drop the past one."""
        self._opened: Optional[ShownSurvey] = None
        self.opened_folder = ""
        # A survey that begins comes before one that is still being opened.
        self.opening.end()

    def note_state(self, snapshot: Snapshot) -> None:
        """Note where the antennas are and which survey is running; show one that begins."""
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

    def _take_list(self, listed: SurveysListed) -> None:
        self.past.take(self._before, listed.surveys, listed.more)

    def _take_read(self, read: TracesRead) -> None:
        for problem in self.shown.take_block(self._first_due, read):
            self._report(problem)
        self._ask_for_traces()

    def _open(self, survey: StoredSurvey) -> None:
        opened = ShownSurvey()
        try:
            grid = grid_from_description(survey.text)
            opened.begin(grid)
            opened.map.set_coverage(
                coverage_of_stored(grid.survey_id, grid.planned, survey.stored_indices)
            )
        except SurveyNotReadableError as error:
            self._report(error.message)
            return
        self._opened, self.opened_folder = opened, self._wanted

    def _ask_for_traces(self) -> None:
        reading = self._reading
        rests = reading.state is JobState.FAILED and reading.age_s < RETRY_S
        due = () if reading.running or rests else self.shown.due()
        if due:
            self._first_due = due[0]
            reading.ask(survey=self.shown.survey_id, indices=due)

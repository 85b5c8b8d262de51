"""The list of past surveys: how each ended and what can be done with it."""

from __future__ import annotations

import datetime
import enum
from dataclasses import dataclass
from typing import List, Optional, Sequence, Tuple

from gpr20_common.message import Message

NO_LIST = Message("During a replay no list of surveys is available.")


FOLDER = "%Y%m%dT%H%M"


class Verdict(enum.Enum):
    """How a survey ended, in one word."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    RUNNING = "running"
    UNREADABLE = "unreadable"


@dataclass(frozen=True)
class PastSurvey:
    """One survey of the data folder; see gpr20_msgs/SurveySummary.

    Attributes:
        verdict: On the coverage; None if there is none.
        problem: Why survey.json cannot be read; None if it can.
        name: What people call it; empty if it has none.
        width_mm: Of the area along X; 0 if it is not known.
        height_mm: Along Y.
        coverage: Stored share of the traces of each part of the area [%] (rows, columns), X and Y
            ascending; None if it is not known.
    """

    folder: str
    survey_id: str
    started: str
    outcome: str
    stored_traces: int
    planned_traces: int
    verdict: Optional[Message]
    complete: bool
    simulated: bool
    problem: Optional[Message]
    name: str = ""
    width_mm: float = 0.0
    height_mm: float = 0.0
    coverage: Optional[Tuple[Tuple[int, ...], ...]] = None

    def local_time(self, zone: Optional[datetime.tzinfo] = None) -> str:
        """Return when it started, as "2026-11-21 05:10"; from its folder if it is not recorded.

        Args:
            zone: In whose time; None: that of this computer.
        """
        for text, pattern in ((self.started[:16], "%Y-%m-%dT%H:%M"), (self.folder[:13], FOLDER)):
            try:
                started = datetime.datetime.strptime(text, pattern)
            except ValueError:
                continue
            at = started.replace(tzinfo=datetime.timezone.utc).astimezone(zone)
            return at.strftime("%Y-%m-%d %H:%M")
        return self.folder


def coverage_map(
    columns: int, rows: int, percent: Sequence[int]
) -> Optional[Tuple[Tuple[int, ...], ...]]:
    """Return the map of a coverage, row by row; None if there is none."""
    if not columns or len(percent) != columns * rows:
        return None
    return tuple(tuple(percent[row * columns : (row + 1) * columns]) for row in range(rows))


class PastSurveys:
    """Collects the pages of the list; knows which survey is running.

    Attributes:
        revision: Changes with everything that a view shows of this.
        outdated: Whether the list should be requested again when it is visible.
        problem: Why the list or a survey cannot be read; None if it can.
        more: Whether there are older ones.
        replay: Whether a replay is shown, and no robot.
    """

    def __init__(self) -> None:
        self.revision = 0
        self.outdated = False
        self.problem: Optional[Message] = None
        self._surveys: List[PastSurvey] = []
        self.more = False
        self._running_id = ""
        self.replay = False

    @property
    def surveys(self) -> Tuple[PastSurvey, ...]:
        """The surveys of the pages so far, the newest first."""
        return tuple(self._surveys)

    @property
    def next_before(self) -> str:
        """Folder before which the next page begins; empty: the first page."""
        return self._surveys[-1].folder if self._surveys else ""

    def find(self, folder: str) -> Optional[PastSurvey]:
        """Return a survey of the pages so far; None if it is not among them."""
        return next((one for one in self._surveys if one.folder == folder), None)

    def take(self, before: str, surveys: Tuple[PastSurvey, ...], more: bool) -> None:
        """Add a page; the first one replaces the list."""
        self._change(problem=None)
        if not before:
            self._surveys = []
        elif before != self.next_before:
            return  # the list was replaced meanwhile
        self._surveys.extend(surveys)
        self.more = more

    def set_running(self, survey_id: str) -> None:
        """Note which survey is running; empty: none."""
        if survey_id != self._running_id:
            self._running_id = survey_id
            self.set_outdated()

    def set_replay(self, replay: bool) -> None:
        """Note whether a replay is shown, beside which nothing can be resumed."""
        self.replay = replay
        self.outdated = not replay
        self._change(problem=NO_LIST if replay else None)

    def set_outdated(self) -> None:
        """Note that the surveys have changed."""
        if not self.replay:
            self.outdated = True
            self._change(problem=None)

    def set_problem(self, reason: Message) -> None:
        """Note why the list or a survey cannot be read."""
        self._change(problem=reason)

    def verdict(self, survey: PastSurvey) -> Verdict:
        """Return how a survey ended; only one with every trace stored is complete."""
        if survey.problem is not None:
            return Verdict.UNREADABLE
        if self._running_id and survey.survey_id == self._running_id:
            return Verdict.RUNNING
        return Verdict.COMPLETE if survey.complete else Verdict.INCOMPLETE

    def can_resume(self, survey: PastSurvey) -> bool:
        """Whether a survey lacks traces that could be measured now."""
        return (
            not self.replay and not self._running_id and self.verdict(survey) is Verdict.INCOMPLETE
        )

    def can_open(self, survey: PastSurvey) -> bool:
        """Whether there is something to show."""
        return survey.problem is None and survey.stored_traces > 0

    def can_analyze(self, survey: PastSurvey) -> bool:
        """Whether it can be searched for candidates or exported: never during a survey."""
        return self.can_open(survey) and not self._running_id and not self.replay

    def _change(self, problem: Optional[Message]) -> None:
        self.problem = problem
        self.revision += 1

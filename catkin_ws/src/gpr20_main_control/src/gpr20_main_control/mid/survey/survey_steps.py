"""The steps of a survey in their order; `engine` executes them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Deque, Dict, Iterator, Optional, Tuple, Union

from gpr20_main_control.mid.survey.known_point import known_traces
from gpr20_main_control.mid.survey.survey_plan import SurveyPlan
from gpr20_survey.plan.survey_points import SurveyPoint
from gpr20_survey.trace.trace import Trace


@dataclass(frozen=True)
class Check:
    """Check that every part of the robot is ready; nothing moves."""


@dataclass(frozen=True)
class Open:
    """Make the survey's folder, or reopen it."""


@dataclass(frozen=True)
class Home:
    """Home the axes whose zero is unknown, or every axis."""

    every_axis: bool


@dataclass(frozen=True)
class Compare:
    """Measure a known point again, at every rotation, and compare it with its stored traces."""

    stored: Tuple[Trace, ...]


@dataclass(frozen=True)
class Visit:
    """Measure the first stop again, at every rotation, to see the drift since."""

    stored: Tuple[Trace, ...]


@dataclass(frozen=True)
class Checkpoint:
    """The survey may be paused here: no sweep is in progress, but one may be unconfirmed."""


@dataclass(frozen=True)
class Move:
    """Move the axes to a point."""

    point: SurveyPoint


@dataclass(frozen=True)
class Settle:
    """Wait until the axes have stopped vibrating, and measure the height meanwhile."""

    point: SurveyPoint


@dataclass(frozen=True)
class Confirm:
    """Wait until the sweep before is confirmed; its trace is stored in the background."""

    point: SurveyPoint


@dataclass(frozen=True)
class Sweep:
    """Take the sweep of a point, and begin to confirm it in the background."""

    point: SurveyPoint


@dataclass(frozen=True)
class Finish:
    """Wait until everything is stored, and close the survey."""


Step = Union[Check, Open, Home, Compare, Visit, Checkpoint, Move, Settle, Confirm, Sweep, Finish]


class SurveyProgress:
    """The progress of a survey, which decides on the remaining steps.

    Attributes:
        last: The trace that was confirmed last; None before the first.
        home_every_axis: Whether every axis must be homed, because the stored traces were measured
            before this process homed the axes.
        compare: Whether the zeros of the axes are other ones than those of the traces.
    """

    def __init__(self, plan: SurveyPlan) -> None:
        """Begin a survey, or continue one from its folder."""
        resumed = plan.reopened is not None
        self.last = plan.last
        self.home_every_axis = self.compare = resumed
        self._rotations = len(plan.parameters.polarizations_deg)
        # Of two stops, of which one is complete.
        most = max(1, 2 * self._rotations - 1)
        self._recent: Deque[Trace] = deque(plan.recent, maxlen=most)
        self._pending = plan.pending
        self._confirmed = 0
        self._awaiting = False
        self._reference: Dict[int, Trace] = {}
        for trace in plan.recent:
            self._keep_reference(trace)
        self._total = plan.total_points
        self._visits = frozenset(plan.visits)
        self._visited: Optional[int] = None
        self._visit_now = resumed and len(self._reference) == self._rotations

    @property
    def unconfirmed(self) -> Optional[SurveyPoint]:
        """The point whose sweep is not confirmed yet; None if every sweep is."""
        return self._pending[self._confirmed] if self._awaiting else None

    @property
    def next(self) -> Optional[SurveyPoint]:
        """The point to measure next; None if every point is measured."""
        measured = self._confirmed + self._awaiting
        return self._pending[measured] if measured < len(self._pending) else None

    @property
    def all_confirmed(self) -> bool:
        """Whether every point is measured and its sweep is confirmed."""
        return self._confirmed == len(self._pending)

    @property
    def known(self) -> Tuple[Trace, ...]:
        """The stored traces of a known point, at every rotation so far."""
        return tuple(known_traces(self._recent, self._rotations))

    @property
    def visit(self) -> Optional[Visit]:
        """The visit of the reference that comes next; None if another point does."""
        index = self._total if self.next is None else self.next.index
        due = self._visit_now or (index in self._visits and index != self._visited)
        if not self._visits or not due or len(self._reference) < self._rotations:
            return None
        return Visit(tuple(trace for _, trace in sorted(self._reference.items())))

    def note_long_pause(self) -> None:
        """Note a pause as long as the time between visits: the reference is visited next."""
        self._visit_now = True

    def note_visited(self) -> None:
        """Note that the reference was visited."""
        self._visited = self._total if self.next is None else self.next.index
        self._visit_now = False

    def _keep_reference(self, trace: Trace) -> None:
        if trace.index < self._rotations:
            self._reference[trace.index] = trace

    def note_homed(self, compare: bool) -> None:
        """Note that the axes are homed.

        Args:
            compare: Whether a known point must be compared before the survey continues.
        """
        self.home_every_axis = False
        self.compare = compare

    def note_swept(self) -> None:
        """Note that the next point has a sweep, which is not confirmed yet."""
        self._awaiting = True

    def note_confirmed(self, trace: Trace) -> None:
        """Note that the sweep that was not confirmed yet is confirmed now."""
        self._awaiting = False
        self._confirmed += 1
        self.last = trace
        self._recent.append(trace)
        self._keep_reference(trace)

    def note_rejected(self) -> None:
        """Note that the sweep could not be confirmed: its point is the next to measure."""
        self._awaiting = False


def survey_steps(plan: SurveyPlan, progress: SurveyProgress) -> Iterator[Step]:
    """Yield the remaining steps of a survey.

    An interrupted survey is continued by calling this again.

    Args:
        plan: What the survey measures.
        progress: The progress so far. Executing the steps updates it, and what comes next is read
            from it: whether a known point is compared after the axes are homed, and whether a
            point is measured again because its sweep could not be confirmed.
    """
    yield Check()
    yield Open()
    yield Home(progress.home_every_axis)
    if progress.compare and progress.known:
        yield Compare(progress.known)
    while not progress.all_confirmed or progress.visit is not None:
        if progress.visit is not None:
            yield Checkpoint()
            if progress.unconfirmed is not None:
                yield Confirm(progress.unconfirmed)
            # Not if the sweep was rejected: its point is measured again first.
            if progress.visit is not None:
                yield progress.visit
            continue
        point = progress.next
        if point is not None:
            yield Checkpoint()
            yield Move(point)
            yield Settle(point)
        if progress.unconfirmed is not None:
            yield Confirm(progress.unconfirmed)
        if point is not None and progress.next == point:
            yield Sweep(point)
    yield Finish()

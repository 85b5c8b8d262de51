"""The steps of a survey in their order; `engine` executes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Optional, Union

from gpr20_main_control.mid.survey.survey_plan import SurveyPlan
from gpr20_survey.plan.survey_plan import SurveyPoint
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
class Repeat:
    """Measure a stored point again and compare the two."""

    point: SurveyPoint


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


Step = Union[Check, Open, Home, Repeat, Checkpoint, Move, Settle, Confirm, Sweep, Finish]


class SurveyProgress:
    """The progress of a survey, which decides on the remaining steps.

    Attributes:
        last: The trace that was confirmed last; None before the first.
        home_every_axis: Whether every axis must be homed, because the stored traces were measured
            before this process homed the axes.
        repeat_last: Whether an axis was homed since the last trace was confirmed.
    """

    def __init__(self, plan: SurveyPlan) -> None:
        """Begin a survey, or continue one from its folder."""
        resumed = plan.reopened is not None
        self.last = plan.last
        self.home_every_axis = self.repeat_last = resumed
        self._pending = plan.pending
        self._confirmed = 0
        self._awaiting = False

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

    def note_homed(self, any_axis: bool) -> None:
        """Note that the axes are homed.

        Args:
            any_axis: Whether any axis had to be homed.
        """
        self.home_every_axis = False
        self.repeat_last = self.repeat_last or any_axis

    def note_swept(self) -> None:
        """Note that the next point has a sweep, which is not confirmed yet."""
        self._awaiting = True

    def note_confirmed(self, trace: Trace) -> None:
        """Note that the sweep that was not confirmed yet is confirmed now."""
        self._awaiting = False
        self._confirmed += 1
        self.last, self.repeat_last = trace, False

    def note_rejected(self) -> None:
        """Note that the sweep could not be confirmed: its point is the next to measure."""
        self._awaiting = False


def survey_steps(plan: SurveyPlan, progress: SurveyProgress) -> Iterator[Step]:
    """Yield the remaining steps of a survey.

    An interrupted survey is continued by calling this again.

    Args:
        plan: What the survey measures.
        progress: The progress so far. Executing the steps updates it, and what comes next is read
            from it: whether the last point is measured again after the axes are homed, and
            whether a point is measured again because its sweep could not be confirmed.
    """
    yield Check()
    yield Open()
    yield Home(progress.home_every_axis)
    if progress.repeat_last and progress.last is not None:
        yield Repeat(plan.points[progress.last.index])
    while not progress.all_confirmed:
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

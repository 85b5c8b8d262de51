"""The steps of a survey in their order; `engine` executes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Optional, Union

from gpr20_main_control.mid.survey_plan import SurveyPlan
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
    """The survey may be paused here: no sample is being taken."""


@dataclass(frozen=True)
class Move:
    """Move the axes to a point."""

    point: SurveyPoint


@dataclass(frozen=True)
class Measure:
    """Settle, sweep and measure the height at a point."""

    point: SurveyPoint


@dataclass(frozen=True)
class Store:
    """Pass the trace of a point to the storage, which works in the background."""

    point: SurveyPoint


@dataclass(frozen=True)
class Finish:
    """Wait until everything is stored, and close the survey."""


Step = Union[Check, Open, Home, Repeat, Checkpoint, Move, Measure, Store, Finish]


@dataclass
class SurveyProgress:
    """The progress of a survey, which decides on the remaining steps.

    Attributes:
        measured: How many of the plan's pending points are measured.
        last: The trace that was measured last; None before the first.
        home_every_axis: Whether every axis must be homed, because the stored traces were measured
            before this process homed the axes.
        repeat_last: Whether an axis was homed since the last trace was measured.
    """

    measured: int
    last: Optional[Trace]
    home_every_axis: bool
    repeat_last: bool

    @classmethod
    def at_start(cls, plan: SurveyPlan) -> SurveyProgress:
        """Return the progress of a survey that begins or is resumed from its folder."""
        resumed = plan.reopened is not None
        return cls(0, plan.last, home_every_axis=resumed, repeat_last=resumed)

    def note_homed(self, any_axis: bool) -> None:
        """Note that the axes are homed.

        Args:
            any_axis: Whether any axis had to be homed.
        """
        self.home_every_axis = False
        self.repeat_last = self.repeat_last or any_axis

    def note_measured(self, trace: Trace) -> None:
        """Note that the next pending point is measured."""
        self.measured += 1
        self.last, self.repeat_last = trace, False


def survey_steps(plan: SurveyPlan, progress: SurveyProgress) -> Iterator[Step]:
    """Yield the remaining steps of a survey.

    An interrupted survey is continued by calling this again.

    Args:
        plan: What the survey measures.
        progress: The progress so far. Executing the steps updates it; whether the last point is
            measured again is read from it after the axes are homed.
    """
    yield Check()
    yield Open()
    yield Home(progress.home_every_axis)
    if progress.repeat_last and progress.last is not None:
        yield Repeat(plan.points[progress.last.index])
    for point in plan.pending[progress.measured :]:
        yield Checkpoint()
        yield Move(point)
        yield Measure(point)
        yield Store(point)
    yield Finish()

"""One motion of an axis: the request, its report, and what carries it out."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Optional, Protocol, Sequence

from gpr20_axis_driver.low.step_counter import StepCounter
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes.axis_id import ZeroEpoch
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.axes.ramp import Ramp

# Called at every step: whether to end the motion now.
StopRequested = Callable[[], bool]


def never() -> bool:
    """Request no stop."""
    return False


class Until(enum.Enum):
    """What ends a motion before all its steps are made."""

    NOTHING = "nothing"
    PRESSED = "endstop pressed"
    RELEASED = "endstop released"


class Ending(enum.Enum):
    """How a motion ended."""

    COMPLETE = "all steps made"
    UNTIL = "the condition held"
    STOPPED = "stopped on request"
    PRESSED = "the endstop was pressed"
    GAP = "a gap between two pulses"


@dataclass(frozen=True)
class Motion:
    """Steps in one direction.

    Attributes:
        forward: Whether the coordinate increases.
        steps: Most steps to make; 0 only reads the endstop.
        ramp: Pauses of the steps.
        until: What ends the motion early, as a success.
        guarded: Whether a pressed endstop ends the motion at once, as a failure.
    """

    forward: bool
    steps: int
    ramp: Ramp
    until: Until = Until.NOTHING
    guarded: bool = False


@dataclass(frozen=True)
class LateLimits:
    """How late a pulse may be [s of the axis's clock].

    Attributes:
        late_s: Up to here later pulses make up for the delay; beyond it they slow down.
        gap_s: Beyond it a motor that was faster than its slowest speed can lose steps.
    """

    late_s: float
    gap_s: float

    @classmethod
    def of(cls, parameters: AxisParameters) -> LateLimits:
        """Return the limits of the parameters, for a robot that moves in real time."""
        return cls(parameters.late_limit_s, parameters.gap_limit_s)


@dataclass(frozen=True)
class Lateness:
    """How late the pulses of a motion were [s].

    Attributes:
        pulses: How many pulses were timed.
        median_s: Half of the pulses were less late.
        p99_s: 99 of 100 pulses were less late.
        max_s: The latest of all.
        slowed: How many edges were beyond the limit, so that the rest was slowed down.
    """

    pulses: int = 0
    median_s: float = 0.0
    p99_s: float = 0.0
    max_s: float = 0.0
    slowed: int = 0

    @classmethod
    def of(cls, lateness_s: Sequence[float], slowed: int) -> Lateness:
        """Summarize the lateness of each pulse [s]."""
        if not lateness_s:
            return cls(slowed=slowed)
        ordered = sorted(lateness_s)
        last = len(ordered) - 1
        return cls(
            len(ordered), ordered[last // 2], ordered[int(0.99 * last)], ordered[last], slowed
        )


@dataclass(frozen=True)
class MotionReport:
    """The result of a motion.

    Attributes:
        ending: How it ended.
        steps_made: Steps made, in the motion's direction.
        endstop_pressed: Whether the endstop is pressed now.
        duration_s: From the first pulse to the end of the last one [s].
        gap_s: The gap that ended it [s]; 0 otherwise.
        lateness: How late its pulses were.
    """

    ending: Ending
    steps_made: int
    endstop_pressed: bool
    duration_s: float = 0.0
    gap_s: float = 0.0
    lateness: Lateness = field(default_factory=Lateness)


class AxisMotions(Protocol):
    """Carries out the motions of an axis, wherever they are made."""

    @property
    def steps(self) -> int:
        """The position [motor steps from coordinate zero]."""

    @property
    def trusted(self) -> bool:
        """Whether the position is known to be that of the motor, from the zero of the axis."""

    @property
    def failure(self) -> Optional[Message]:
        """Why no motion is possible now; None if one is."""

    @property
    def endstop_pressed(self) -> Optional[bool]:
        """Whether the endstop is pressed; None if that is not known."""

    @property
    def endstop_presses(self) -> int:
        """How many times the endstop has closed, as far as it was read."""

    @property
    def scheduling(self) -> Message:
        """How punctual the pulses are."""

    @property
    def unpunctual(self) -> bool:
        """Whether the pulses are less punctual than they should be."""

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest."""

    @property
    def zero(self) -> ZeroEpoch:
        """The zero that the position refers to, or referred to when it was known."""

    def begin_zero(self, time_us: int) -> None:
        """Begin another epoch of the zero, found or set then [us since 1970]; `place` follows."""

    def place(self, steps: int) -> None:
        """Set the position of the motor, which is at rest [motor steps]."""

    def distrust(self) -> None:
        """Note that the position is no longer known."""

    def revive(self) -> None:
        """Make motions possible again after a failure."""

    def close(self) -> None:
        """End any motion and release the hardware."""


class MotionRunner(Protocol):
    """Makes the pulses of motions, next to the hardware."""

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest."""

    def read_endstop(self) -> None:
        """Note in the step counter whether the endstop is pressed now; the motor is at rest."""

    def close(self) -> None:
        """Leave the step and direction pins low and release the hardware."""


class AxisHardware(Protocol):
    """What an axis is wired to. It is pickled, so the hardware is opened only by `open`."""

    @property
    def description(self) -> Hardware:
        """What it is."""

    @property
    def parameters(self) -> AxisParameters:
        """The axis's parameters."""

    @property
    def clock(self) -> Clock:
        """The clock by which the axis moves."""

    @property
    def realtime(self) -> bool:
        """Whether the pulses need real-time scheduling."""

    @property
    def step_file(self) -> Path:
        """Where the steps are counted."""

    @property
    def first_steps(self) -> Optional[int]:
        """Position of the motor before the first count [motor steps]; None if it is unknown."""

    def open(self, counter: StepCounter) -> MotionRunner:
        """Open the hardware; both pins are low then."""

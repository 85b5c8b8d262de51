"""One motion of an axis: the request, its report, and what carries it out."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Optional, Protocol, Sequence

from gpr20_axis_driver.low.pins import Pins
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes import AxisParameters, Ramp, ZeroEpoch

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
class Lateness:
    """How late the pulses of a motion were [s].

    Attributes:
        median_s: Half of the pulses were less late.
        p99_s: 99 of 100 pulses were less late.
        max_s: The latest of all.
        slowed: How many edges were beyond the limit, so that the rest was slowed down.
    """

    median_s: float = 0.0
    p99_s: float = 0.0
    max_s: float = 0.0
    slowed: int = 0

    @classmethod
    def of(cls, lateness_s: Sequence[float], slowed: int) -> Lateness:
        """Summarize the lateness of each pulse [s]."""
        ordered = sorted(lateness_s) or [0.0]
        last = len(ordered) - 1
        return cls(ordered[last // 2], ordered[int(0.99 * last)], ordered[last], slowed)


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


class AxisHardware(Protocol):
    """What an axis is wired to. It is pickled, so the pins are opened only by `open_pins`."""

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
        """Whether the pulses must be punctual."""

    @property
    def step_file(self) -> Path:
        """Where the steps are counted."""

    @property
    def first_steps(self) -> Optional[int]:
        """Position of the motor before the first count [motor steps]; None if it is unknown."""

    def open_pins(self) -> Pins:
        """Return the pins, or raise an AxisException."""


class AxisMotions(Protocol):
    """Carries out the motions of an axis, wherever they are made."""

    @property
    def hardware(self) -> Hardware:
        """What it is."""

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
        """Whether the endstop is pressed; None if there is none, or it cannot be read now."""

    @property
    def endstop_presses(self) -> int:
        """How many times the endstop has closed, as far as it was read."""

    @property
    def scheduling(self) -> Message:
        """How punctual the pulses are; with a fault, if less than they should be."""

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        """Carry out a motion and return when the motor is at rest."""

    @property
    def zero(self) -> ZeroEpoch:
        """The zero that the position refers to, or referred to when it was known."""

    def begin_zero(self, steps: int, time_us: int) -> None:
        """Begin another epoch of the zero.

        Args:
            steps: Where the motor rests [motor steps]; a controller knows it itself.
            time_us: When the zero was found or set [us since 1970].
        """

    def distrust(self) -> None:
        """Note that the position is no longer known."""

    def revive(self) -> None:
        """Make motions possible again after a failure; raises an AxisException if it cannot."""

    def close(self) -> None:
        """End any motion and release the hardware; nothing else may be called afterwards."""

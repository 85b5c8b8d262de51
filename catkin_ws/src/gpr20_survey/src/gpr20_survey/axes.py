"""The axes: their names, the frames that they move, their zeros, and their parameters."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field, fields
from decimal import Decimal
from pathlib import PurePosixPath
from typing import Any, Dict, Iterator, Literal, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.checks import is_extension, number_between
from gpr20_common.mid.codec import bounded

# `map` -> `base_link` (the origin of the axes on the ground; x along X, y along Y, z up; metres) ->
# `y_carriage_link` -> `x_carriage_link` -> `antenna_link`, which turns about z, and
# `height_sensor_link`. A robot in a namespace has the same names on its own `tf`.
MAP = "map"
BASE_LINK = "base_link"
Y_CARRIAGE_LINK = "y_carriage_link"
X_CARRIAGE_LINK = "x_carriage_link"
ANTENNA_LINK = "antenna_link"
HEIGHT_SENSOR_LINK = "height_sensor_link"
# Prevents a rounding error of the pauses from adding or removing a step.
ROUNDING = 1.0e-9


class AxisId(enum.Enum):
    """The three axes, with the unit of their coordinates."""

    X = "x"
    Y = "y"
    Z = "z"

    @property
    def unit(self) -> str:
        return "deg" if self is AxisId.Z else "mm"


AXES = len(AxisId)


@dataclass(frozen=True)
class ZeroEpoch:
    """One zero of an axis: each homing and each set_zero begins another epoch of its coordinate.

    Coordinates of different zeros are not comparable.

    Attributes:
        number: Grows with each homing and set_zero; 0: not known.
        time_us: When the zero was found or set [us since 1970, UTC], by the axis's computer. An
            axis without endstop turns to its zero in a homing and finds nothing: its time is that
            of the last set_zero.
    """

    number: int = 0
    time_us: int = 0

    @property
    def is_known(self) -> bool:
        """Whether the axis has said which zero it is."""
        return self.number > 0


UNKNOWN_ZERO = ZeroEpoch()
# The zeros of x, y and z; empty: not known, as in traces that were imported.
Zeros = Tuple[ZeroEpoch, ...]
MAX_NUMBER = (1 << 32) - 1
MAX_TIME_US = ((1 << 32) - 1) * 1_000_000


def are_zeros(zeros: Zeros) -> bool:
    """Return whether these can be the zeros of a trace: of each axis, or of none."""
    return len(zeros) in (0, AXES) and all(
        0 < one.number <= MAX_NUMBER and 0 <= one.time_us <= MAX_TIME_US for one in zeros
    )


@dataclass(frozen=True)
class Ramp:
    """Pauses of half a step period, changing by at most `delta_s` from step to step."""

    min_pause_s: float
    max_pause_s: float
    delta_s: float

    def pause_s(self, height: int) -> float:
        """Return the pause [s] so many steps up the ramp; 0 is the slowest."""
        return max(self.min_pause_s, self.max_pause_s - self.delta_s * height)

    def height_after(self, pause_s: float) -> int:
        """Return how high on the ramp the step after one with this pause [s] may be."""
        if pause_s >= self.max_pause_s:
            return 0
        return math.floor((self.max_pause_s - pause_s) / self.delta_s + ROUNDING) + 1

    def braking_steps(self, pause_s: float) -> int:
        """Return how many steps an axis needs to come from a pause to the slowest one."""
        return max(0, math.ceil((self.max_pause_s - pause_s) / self.delta_s - ROUNDING))

    def duration_s(self, steps: int) -> float:
        """Return how long a move takes [s]; each step is two pauses."""
        ramp_steps = min(self.braking_steps(self.min_pause_s), steps // 2)
        ramp_s = sum(self.pause_s(step) for step in range(ramp_steps))
        middle = steps - 2 * ramp_steps
        return 2.0 * (2.0 * ramp_s + middle * self.pause_s(ramp_steps))


# Pins of the 40-pin header that carry a GPIO line, in BOARD numbering (Raspberry Pi 4).
BOARD_PINS = frozenset(
    [3, 5, 7, 8, 10, 11, 12, 13, 15, 16, 18, 19, 21, 22, 23, 24, 26]
    + [27, 28, 29, 31, 32, 33, 35, 36, 37, 38, 40]
)
# A pause shorter than this is below what a DRV8825 accepts as a step pulse (1.9 us high).
MIN_PAUSE_S = 2.0e-6
MAX_PAUSE_S = 1.0
# Finer than any motor; with less an axis would never leave its slowest speed.
MIN_STEP_SIZE = 1.0e-5
MAX_STEP_SIZE = 360.0
MIN_DELTA_S = 1.0e-7
# The most back-offs that homing ever makes in one go, away from a switch that was pressed.
HOMING_BACKOFFS = 5
# A gap of this length is no lateness any more: the process has been halted.
MAX_GAP_S = 10.0
# Shorter, and a busy computer ends moves; longer, and a robot moves that nobody controls.
MIN_LEASE_S, MAX_LEASE_S = 0.5, 10.0
# Real-time priority of the processes that make the pulses: below the kernel's own real-time threads
# (50 and 99), above everything else.
PULSE_PRIORITY = 45

LINEAR, ROTARY = "LIN", "ROT"


class Level(enum.Enum):
    """A level of a pin."""

    LOW = "low"
    HIGH = "high"


class Pull(enum.Enum):
    """The resistor inside the computer that pulls an input."""

    UP = "up"
    DOWN = "down"
    NONE = "none"


@dataclass(frozen=True)
class AxisParameters:
    """The parameters of one axis, named as in the robot's documentation.

    Lengths are in mm on a linear axis and in degrees on a rotary one.

    Attributes:
        dir_pin: Direction pin [BOARD number].
        step_pin: Step pin [BOARD number].
        step_size: Travel per motor step.
        min_step: Shortest pause of half a step period [s]: the top speed.
        max_step: Longest pause of half a step period [s]: the speed of start and stop.
        delta_step: Change of the pause from one step to the next on a ramp [s].
        min_coord: Lower end of the travel.
        max_coord: Upper end of the travel.
        type: LIN or ROT.
        sensor_pin: Endstop's pin [BOARD number]; none on an axis without endstop.
        homing_backoff: Distance from the endstop's switching point to coordinate
            `min_coord`, so that a move to the end does not press the switch.
        homing_margin: Where the position is known, homing goes this far beyond the place where the
            endstop must be; where it is not, homing searches the whole axis.
        endstop_active: Level of the endstop's pin while it is pressed, low or high.
        endstop_pull: Resistor of the computer that pulls the endstop's pin: up, down or none.
        invert_direction: Whether the direction pin is low, instead of high, for increasing
            coordinates.
        enable_pin: Enable pin of the motor driver [BOARD number]; none if its input is wired
            permanently. The driver is enabled before the first step and stays so.
        enable_active: Level at which the motor driver is enabled: low for a DRV8825, or high.
        late_limit_s: A pulse that is later slows the rest of the move down [s]; also what a
            pause can be shorter than its due length.
        gap_limit_s: A pulse that is later ends a move that was faster than the slowest
            speed, and the axis must be homed again [s].
        lease_limit_s: A motion of the main control ends with its ramp when the main control does
            not answer for this long [s].
        memory_file: Where the step count of an axis without endstop outlives the power;
            empty: it outlives the node, but not the power.
        controller: Class outside this software that moves the axis instead of the pins, such as
            my_robot.drive:LineController (docs/extend/axis_controller.md); empty: the pins. The
            simulated robot does not use it.
        controller_options: Arguments of that class, by name.
    """

    dir_pin: int
    step_pin: int
    step_size: float
    min_step: float
    max_step: float
    delta_step: float
    min_coord: float
    max_coord: float
    type: Literal["LIN", "ROT"]
    sensor_pin: Optional[int] = None
    homing_backoff: float = bounded(0.0, 1.0e5, 1.0)
    homing_margin: float = bounded(0.0, 50.0, 10.0)
    endstop_active: Literal["low", "high"] = "low"
    endstop_pull: Literal["up", "down", "none"] = "up"
    invert_direction: bool = False
    enable_pin: Optional[int] = None
    enable_active: Literal["low", "high"] = "low"
    late_limit_s: float = 0.0005
    gap_limit_s: float = 0.05
    lease_limit_s: float = bounded(MIN_LEASE_S, MAX_LEASE_S, 2.0)
    memory_file: str = ""
    controller: str = ""
    # A dict has no hash; two axes that differ in nothing else may have the same one.
    controller_options: Dict[str, Any] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        unit = self.unit
        number_between("step_size", self.step_size, MIN_STEP_SIZE, MAX_STEP_SIZE, unit)
        number_between("delta_step", self.delta_step, MIN_DELTA_S, MAX_PAUSE_S, "s")
        number_between("max_step", self.max_step, MIN_PAUSE_S, MAX_PAUSE_S, "s")
        number_between("min_step", self.min_step, MIN_PAUSE_S, self.max_step, "s")
        number_between("min_coord", self.min_coord, -1.0e5, 1.0e5, unit)
        lowest = self.min_coord + self.step_size
        number_between("max_coord", self.max_coord, lowest, 1.0e5, unit)
        number_between("late_limit_s", self.late_limit_s, MIN_PAUSE_S, self.min_step, "s")
        number_between("gap_limit_s", self.gap_limit_s, self.late_limit_s, MAX_GAP_S, "s")
        for mistake in (*self._mistaken_pins(), *self._mistaken_zero()):
            raise InvalidValueError(mistake, fault=CONFIGURATION)
        # Homing goes back and forth by it, and must stay within the axis.
        longest = (self.max_coord - self.min_coord) / HOMING_BACKOFFS
        if self.sensor_pin is not None:
            number_between("homing_backoff", self.homing_backoff, self.step_size, longest, unit)

    def _mistaken_pins(self) -> Iterator[Message]:
        for name, pin in self.pins.items():
            if pin not in BOARD_PINS:
                yield Message(
                    "{name} is {pin}; it must be the BOARD number of a GPIO pin: {pins}",
                    name=name,
                    pin=pin,
                    pins=", ".join(map(str, sorted(BOARD_PINS))),
                )
        if len(set(self.pins.values())) != len(self.pins):
            listed = ", ".join(f"{name} {pin}" for name, pin in self.pins.items())
            yield Message("{pins}: all pins must be different", pins=listed)
        defaults = {one.name: one.default for one in fields(AxisParameters)}
        for name, pin_name in (
            ("endstop_active", "sensor_pin"),
            ("endstop_pull", "sensor_pin"),
            ("enable_active", "enable_pin"),
        ):
            value = getattr(self, name)
            if getattr(self, pin_name) is None and value != defaults[name]:
                yield Message(
                    "{name} is {value}, but the axis has no {pin}; set the pin, or leave {name} "
                    "out",
                    name=name,
                    value=value,
                    pin=pin_name,
                )

    def _mistaken_zero(self) -> Iterator[Message]:
        if not self.finds_zero and self.type == LINEAR:
            yield Message(
                "sensor_pin is missing; a linear axis needs an endstop to find its zero: set the "
                "pin"
            )
        if self.memory_file and self.sensor_pin is not None:
            yield Message(
                "memory_file is '{file}', but the axis finds its zero with the endstop on "
                "sensor_pin {pin}; set only one of the two",
                file=self.memory_file,
                pin=self.sensor_pin,
            )
        if self.memory_file and not PurePosixPath(self.memory_file).is_absolute():
            yield Message(
                "memory_file is '{file}'; it must be an absolute path", file=self.memory_file
            )
        if self.controller and not is_extension(self.controller):
            yield Message(
                "{key} is {name}; it must have the form {example}",
                key="controller",
                name=repr(self.controller[:200]),
                example="package.module:Class",
            )
        if self.controller_options and not self.controller:
            yield Message("controller_options are given, but no controller; name its class")

    @property
    def pins(self) -> Dict[str, int]:
        """The pins that the axis uses [BOARD numbers], by the names of their parameters."""
        names = ("dir_pin", "step_pin", "sensor_pin", "enable_pin")
        pins = {name: getattr(self, name) for name in names}
        return {name: pin for name, pin in pins.items() if pin is not None}

    @property
    def unit(self) -> str:
        return "mm" if self.type == LINEAR else "deg"

    @property
    def finds_zero(self) -> bool:
        """Whether homing finds the zero, with an endstop or a controller; else people set it."""
        return self.sensor_pin is not None or bool(self.controller)

    def distance_steps(self, distance: float) -> int:
        # Decimal, because 0.29 / 0.01 is 28.999... in binary and would lose a step.
        return round(Decimal(repr(float(distance))) / Decimal(repr(self.step_size)))

    def coordinate_of(self, steps: int) -> float:
        """Return the coordinate of a motor step, exact to the last bit."""
        return float(steps * Decimal(repr(self.step_size)))

    @property
    def travel_steps(self) -> int:
        return self.distance_steps(self.max_coord - self.min_coord)

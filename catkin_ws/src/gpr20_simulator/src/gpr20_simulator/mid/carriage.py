"""The moving part of the simulated robot, as it is wired: pins, motors, hard stops, endstops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Dict, Iterable, Optional, Union

from gpr20_common.low.clock import Clock
from gpr20_common.mid.node_facts import Hardware
from gpr20_simulator.low.shared_state import (
    EndstopFault,
    ScaledClock,
    SharedState,
    open_shared_state,
)
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import AxisMechanics, RobotMechanics
from gpr20_survey.axes import AxisId, AxisParameters, Level


@dataclass(frozen=True)
class Wiring:
    """How one axis is wired; pins are BOARD numbers.

    Attributes:
        dir_pin: Direction pin.
        step_pin: Step pin.
        sensor_pin: The endstop's pin; an axis without endstop has none.
        endstop_active: Level to which the endstop's switch connects its pin when it closes. While
            it is open, the level is that of the pull; without a pull of the computer, that of a
            resistor outside it, which is the other level.
        direction_inverted: Whether the direction pin is low for increasing coordinates.
        enable_pin: Enable pin of the motor driver; without one it is always enabled.
        enable_active: Level at which the motor driver is enabled.
    """

    dir_pin: int
    step_pin: int
    sensor_pin: Optional[int]
    endstop_active: Level = Level.LOW
    direction_inverted: bool = False
    enable_pin: Optional[int] = None
    enable_active: Level = Level.LOW


# As on the robot. A driver that is configured with other pins moves nothing.
WIRING: Dict[AxisId, Wiring] = {
    AxisId.X: Wiring(dir_pin=13, step_pin=15, sensor_pin=16),
    AxisId.Y: Wiring(dir_pin=37, step_pin=38, sensor_pin=40),
    AxisId.Z: Wiring(dir_pin=11, step_pin=12, sensor_pin=None),
}


def mechanics_of(robot: RobotMechanics, axis: AxisId) -> AxisMechanics:
    """Return what the motor of an axis moves."""
    return {AxisId.X: robot.x, AxisId.Y: robot.y, AxisId.Z: robot.z}[axis]


def wiring_of(axis: AxisId, mechanics: AxisMechanics) -> Wiring:
    """Return how an axis is wired."""
    return replace(
        WIRING[axis],
        endstop_active=mechanics.endstop_active,
        direction_inverted=mechanics.direction_inverted,
        enable_pin=mechanics.enable_pin,
        enable_active=mechanics.enable_active,
    )


def start_steps(robot: RobotMechanics) -> Dict[AxisId, int]:
    """Return where each axis is when the robot is switched on [motor steps]."""
    mechanics = {axis: mechanics_of(robot, axis) for axis in AxisId}
    return {axis: _steps(mechanics[axis], mechanics[axis].start) for axis in AxisId}


def carriage_position(state: SharedState, robot: RobotMechanics) -> AntennaPosition:
    """Return where the antennas are now."""
    return AntennaPosition(
        x_mm=state.steps(AxisId.X) * robot.x.size_per_step,
        y_mm=state.steps(AxisId.Y) * robot.y.size_per_step,
        rotation_deg=state.steps(AxisId.Z) * robot.z.size_per_step,
    )


class AxisMotor:
    """One motor with what it moves: the machine behind the pins of one axis."""

    def __init__(self, state: SharedState, axis: AxisId, mechanics: AxisMechanics) -> None:
        self._state = state
        self._axis = axis
        self._lower_steps = _steps(mechanics, mechanics.lower_stop)
        self._upper_steps = _steps(mechanics, mechanics.upper_stop)
        self._has_endstop = mechanics.endstop is not None
        if mechanics.endstop is not None:
            self._endstop_steps = _steps(mechanics, mechanics.endstop)

    def step(self, forward: bool) -> None:
        """Turn the motor by one step; against a hard stop it stalls and the step is lost."""
        steps = self._state.steps(self._axis) + (1 if forward else -1)
        if self._lower_steps <= steps <= self._upper_steps:
            self._state.set_steps(self._axis, steps)

    def note_levels(self, step_high: bool, dir_high: bool) -> None:
        """Take note of the levels of the step and direction pins."""
        self._state.set_pin_levels(self._axis, step_high, dir_high)

    def endstop_closed(self) -> bool:
        """Return whether the endstop's switch is closed."""
        if not self._has_endstop:
            return False
        fault = self._state.endstop_fault(self._axis)
        if fault is not EndstopFault.NONE:
            return fault is EndstopFault.STUCK_CLOSED
        return self._state.steps(self._axis) <= self._endstop_steps


class SimulatedPins:
    """Stands in for the module RPi.GPIO; a rising edge on a step pin turns the motor."""

    BOARD = 10
    OUT = 0
    IN = 1
    LOW = 0
    HIGH = 1
    PUD_OFF = 20
    PUD_DOWN = 21
    PUD_UP = 22

    def __init__(self, motor: AxisMotor, wiring: Wiring) -> None:
        self._motor = motor
        self._wiring = wiring
        self._pulls: Dict[int, int] = {}
        self._directions: Dict[int, int] = {}
        self._levels: Dict[int, int] = {}

    def setmode(self, mode: int) -> None:
        """Choose the numbering of the pins."""
        if mode != self.BOARD:
            raise ValueError(f"pin numbering {mode} is not simulated; use BOARD")

    def setup(
        self,
        channel: int,
        direction: int,
        initial: Optional[int] = None,
        pull_up_down: int = PUD_OFF,
    ) -> None:
        """Make a pin an input or an output."""
        self._directions[channel] = direction
        self._pulls[channel] = pull_up_down
        if direction == self.OUT:
            self._levels[channel] = self.LOW if initial is None else initial
            self._note_levels()

    def output(self, channel: int, level: Union[int, bool]) -> None:
        """Drive an output pin; KeyError: it has not been set up as one."""
        rising = level and not self._levels[channel]
        self._levels[channel] = self.HIGH if level else self.LOW
        self._note_levels()
        if rising and channel == self._wiring.step_pin and self._enabled:
            high = bool(self._levels.get(self._wiring.dir_pin))
            self._motor.step(forward=high != self._wiring.direction_inverted)

    def input(self, channel: int) -> int:
        """Read a pin; KeyError: it has not been set up."""
        if self._directions[channel] == self.OUT:
            return self._levels[channel]
        active = self._level(self._wiring.endstop_active)
        if channel == self._wiring.sensor_pin and self._motor.endstop_closed():
            return active
        pulled = {self.PUD_UP: self.HIGH, self.PUD_DOWN: self.LOW}
        return pulled.get(self._pulls[channel], self.HIGH - active)

    @property
    def _enabled(self) -> bool:
        pin = self._wiring.enable_pin
        # Where nothing drives it, a resistor keeps the motor driver disabled.
        return pin is None or self._levels.get(pin) == self._level(self._wiring.enable_active)

    def _level(self, level: Level) -> int:
        return self.HIGH if level is Level.HIGH else self.LOW

    def cleanup(self, channel: Union[int, Iterable[int], None] = None) -> Any:
        """Make pins inputs again, as they were before setup."""
        if channel is None:
            channels = list(self._directions)
        else:
            channels = [channel] if isinstance(channel, int) else list(channel)
        for one in channels:
            self._directions.pop(one, None)
            self._levels.pop(one, None)
        # The motor driver pulls its inputs down where nothing drives them.
        self._note_levels()

    def _note_levels(self) -> None:
        step = self._levels.get(self._wiring.step_pin)
        direction = self._levels.get(self._wiring.dir_pin)
        self._motor.note_levels(bool(step), bool(direction))


def _steps(mechanics: AxisMechanics, place: float) -> int:
    return round(place / mechanics.size_per_step)


@dataclass(frozen=True)
class SimulatedHardware:
    """Pins whose pulses move the simulated carriage; an `AxisHardware`.

    Attributes:
        parameters: The axis's parameters.
        state_path: The file of the shared state.
        axis: Which axis this is.
        mechanics: What its motor moves.
        time_scale: How many times faster than the real robot it moves.
        first_steps: Where the motor is when the robot is switched on [motor steps].
    """

    parameters: AxisParameters
    state_path: Path
    axis: AxisId
    mechanics: AxisMechanics
    time_scale: float
    first_steps: Optional[int]

    @property
    def description(self) -> Hardware:
        """What it is."""
        return Hardware("simulated DRV8825", simulated=True, time_scale=self.time_scale)

    @property
    def clock(self) -> Clock:
        """The robot's clock."""
        return ScaledClock(self.time_scale)

    @property
    def realtime(self) -> bool:
        """Only a robot as fast as the real one needs punctual pulses."""
        return self.time_scale == 1.0

    @property
    def step_file(self) -> Path:
        """The steps are forgotten with the shared state, whatever file the robot would have."""
        return self.state_path.with_name(f"{self.state_path.name}_{self.axis.value}_steps")

    def open_pins(self) -> SimulatedPins:
        """Open the pins; called in the process that makes the pulses."""
        motor = AxisMotor(open_shared_state(self.state_path, {}), self.axis, self.mechanics)
        return SimulatedPins(motor, wiring_of(self.axis, self.mechanics))

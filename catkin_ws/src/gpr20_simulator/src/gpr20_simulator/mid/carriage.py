"""The moving part of the simulated robot: motors, hard stops and endstops."""

from __future__ import annotations

from dataclasses import replace
from typing import Dict

from gpr20_simulator.low.pins import Wiring
from gpr20_simulator.low.shared_state import EndstopFault, SharedState
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import AxisMechanics, RobotMechanics
from gpr20_survey.axes.axis_id import AxisId

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


def _steps(mechanics: AxisMechanics, place: float) -> int:
    return round(place / mechanics.size_per_step)

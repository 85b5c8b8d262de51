"""The moving part of the simulated robot: motors, hard stops and endstops."""

from __future__ import annotations

from typing import Dict

from gpr20_simulator.low.world import AxisName, EndstopFault, World
from gpr20_simulator.mid.antenna_position import AntennaPosition
from gpr20_simulator.mid.scene import AxisMechanics, RobotMechanics


def mechanics_of(robot: RobotMechanics, axis: AxisName) -> AxisMechanics:
    """Return what the motor of an axis moves."""
    return {AxisName.X: robot.x, AxisName.Y: robot.y, AxisName.Z: robot.z}[axis]


def start_steps(robot: RobotMechanics) -> Dict[AxisName, int]:
    """Return where each axis stands when the robot is switched on [motor steps]."""
    mechanics = {axis: mechanics_of(robot, axis) for axis in AxisName}
    return {axis: _steps(mechanics[axis], mechanics[axis].start) for axis in AxisName}


def carriage_position(world: World, robot: RobotMechanics) -> AntennaPosition:
    """Return where the antennas are now."""
    return AntennaPosition(
        x_mm=world.steps(AxisName.X) * robot.x.size_per_step,
        y_mm=world.steps(AxisName.Y) * robot.y.size_per_step,
        rotation_deg=world.steps(AxisName.Z) * robot.z.size_per_step,
    )


class AxisMotor:
    """One motor with what it moves: the machine behind the pins of one axis."""

    def __init__(self, world: World, axis: AxisName, mechanics: AxisMechanics) -> None:
        self._world = world
        self._axis = axis
        self._lower_steps = _steps(mechanics, mechanics.lower_stop)
        self._upper_steps = _steps(mechanics, mechanics.upper_stop)
        self._has_endstop = mechanics.endstop is not None
        if mechanics.endstop is not None:
            self._endstop_steps = _steps(mechanics, mechanics.endstop)

    def step(self, forward: bool) -> None:
        """Turn the motor by one step; against a hard stop it stalls and the step is lost."""
        steps = self._world.steps(self._axis) + (1 if forward else -1)
        if self._lower_steps <= steps <= self._upper_steps:
            self._world.set_steps(self._axis, steps)

    def note_levels(self, step_high: bool, dir_high: bool) -> None:
        """Take note of the levels of the step and direction pins."""
        self._world.set_pin_levels(self._axis, step_high, dir_high)

    def endstop_closed(self) -> bool:
        """Return whether the endstop's switch is closed."""
        if not self._has_endstop:
            return False
        fault = self._world.endstop_fault(self._axis)
        if fault is not EndstopFault.NONE:
            return fault is EndstopFault.STUCK_CLOSED
        return self._world.steps(self._axis) <= self._endstop_steps


def _steps(mechanics: AxisMechanics, place: float) -> int:
    return round(place / mechanics.size_per_step)

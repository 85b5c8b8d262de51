"""The axis driver on simulated pins."""

from __future__ import annotations

import rospy

from gpr20_axis_driver.high.axis_node import AxisNode, build_pin_axis, run_axis
from gpr20_simulator.high.simulated_robot import open_simulated_part, shared_state_path
from gpr20_simulator.mid.axis_hardware import SimulatedHardware
from gpr20_simulator.mid.carriage import mechanics_of
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters


def main() -> None:
    """Run one axis of the simulated robot; the name of its group, such as x_axis, says which."""
    run_axis(build_simulated_axis)


def build_simulated_axis(axis_id: AxisId, parameters: AxisParameters) -> AxisNode:
    """Build the node of an axis whose pins move the simulated carriage."""
    robot_namespace = rospy.get_namespace().rstrip("/").rsplit("/", 1)[0] + "/"
    part = open_simulated_part(robot_namespace)
    # As on the robot, an axis with an endstop does not know where it is before it is homed.
    first_steps = None if parameters.finds_zero else part.state.steps(axis_id)
    hardware = SimulatedHardware(
        parameters,
        shared_state_path(robot_namespace),
        axis_id,
        mechanics_of(part.scene.robot, axis_id),
        part.clock.factor,
        first_steps,
    )
    return build_pin_axis(axis_id, hardware)

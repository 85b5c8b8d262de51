"""The axis driver on simulated pins."""

from __future__ import annotations

import rospy

from gpr20_axis_driver.high.axis_node import own_axis, run_axis
from gpr20_simulator.high.simulated_robot import open_simulated_part, shared_state_path
from gpr20_simulator.mid.axis_hardware import SimulatedHardware
from gpr20_simulator.mid.carriage import mechanics_of
from gpr20_survey.axes.axis_parameters import AxisParameters


def main() -> None:
    """Run one axis of the simulated robot; the name of its group, such as x_axis, says which."""
    run_axis(simulated_hardware)


def simulated_hardware(parameters: AxisParameters) -> SimulatedHardware:
    """Return pins that move the simulated carriage."""
    robot_namespace = rospy.get_namespace().rstrip("/").rsplit("/", 1)[0] + "/"
    part = open_simulated_part(robot_namespace)
    axis = own_axis()
    return SimulatedHardware(
        parameters,
        shared_state_path(robot_namespace),
        axis,
        mechanics_of(part.scene.robot, axis),
        part.clock.factor,
        part.state.steps(axis),
    )

"""The axis driver on simulated pins."""

from __future__ import annotations

import rospy

from gpr20_axis_driver.high.axis_node import AxisNode, build_axis_node
from gpr20_common.high.node import run_device
from gpr20_simulator.high.simulated_robot import (
    SimulatedPart,
    open_simulated_part,
    shared_state_path,
)
from gpr20_simulator.mid.axis_hardware import SimulatedHardware
from gpr20_simulator.mid.carriage import mechanics_of
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters


def main() -> None:
    """Run one axis of the simulated robot; the name of its group, such as x_axis, says which."""
    run_device("axis_driver", AxisParameters, build_simulated_axis, SimulatedPart.PARAMETERS)


def build_simulated_axis(parameters: AxisParameters) -> AxisNode:
    """Build the real node over pins that move the simulated carriage."""
    group = rospy.get_namespace().rstrip("/")
    axis = AxisId(group.rsplit("/", 1)[-1][:1])
    robot_namespace = group.rsplit("/", 1)[0] + "/"
    part = open_simulated_part(robot_namespace)
    hardware = SimulatedHardware(
        parameters,
        shared_state_path(robot_namespace),
        axis,
        mechanics_of(part.scene.robot, axis),
        part.clock.factor,
        part.state.steps(axis),
    )
    return build_axis_node(hardware)

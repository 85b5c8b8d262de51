"""The programs that drive one axis: over pins, or over another controller."""

from __future__ import annotations

from typing import Callable

import rospy

from gpr20_axis_driver.high.axis_node import AxisNode
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.controllers import controller_driver, open_controller
from gpr20_axis_driver.mid.pulse_client import PulseClient
from gpr20_axis_driver.mid.robot_hardware import RobotHardware
from gpr20_axis_driver.motion import AxisHardware
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.high.node import read_parameters, run_node
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters


def own_axis() -> AxisId:
    """Return the axis of this node: its namespace, such as x_axis, says which.

    Raises:
        InvalidValueError: The namespace is not that of an axis.
    """
    group = rospy.get_namespace().rstrip("/").rsplit("/", 1)[-1]
    for axis_id in AxisId:
        if group == f"{axis_id.value}_axis":
            return axis_id
    raise InvalidValueError(
        Message(
            "the namespace of {node} does not name an axis; start it in x_axis, y_axis or z_axis",
            node=rospy.get_name(),
        ),
        fault=CONFIGURATION,
    )


def run_axis(build: Callable[[AxisId, AxisParameters], AxisNode]) -> None:
    """Run one axis until ROS shuts down.

    Args:
        build: Builds the node of an axis and everything below it.
    """

    def build_own() -> AxisNode:
        axis_id = own_axis()
        return build(axis_id, read_parameters(AxisParameters, f"{axis_id.value}_axis"))

    run_node("axis_driver", build_own)


def build_pin_axis(axis_id: AxisId, hardware: AxisHardware) -> AxisNode:
    """Build the node of an axis whose pulses are made here.

    Raises:
        Gpr20Error: The pulse process cannot be started, or the pins cannot be used.
    """
    pulses = PulseClient(hardware)
    if pulses.unpunctual:
        rospy.logwarn(str(pulses.scheduling))
    parameters = hardware.parameters
    driver = AxisDriver(parameters, pulses)
    return AxisNode(axis_id, parameters, driver, pulses, hardware.description)


def build_robot_axis(axis_id: AxisId, parameters: AxisParameters) -> AxisNode:
    """Build the node of an axis of the real robot.

    Raises:
        Gpr20Error: The pins, or the controller that is configured, cannot be used.
    """
    if not parameters.controller:
        return build_pin_axis(axis_id, RobotHardware(parameters))
    motions = open_controller(parameters)
    driver = controller_driver(parameters, motions)
    return AxisNode(axis_id, parameters, driver, motions, Hardware(motions.name))


def main() -> None:
    """Run one axis of the real robot."""
    run_axis(build_robot_axis)

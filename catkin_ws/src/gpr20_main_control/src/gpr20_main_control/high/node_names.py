"""The nodes without which there is no survey: their names on the graph, and for operators."""

from __future__ import annotations

from typing import Dict

from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import AxisId

HEIGHT_SENSOR = Message("the height sensor")
VNA_DRIVER = Message("the VNA driver")
STORAGE = Message("the storage")


def axis_driver(axis_id: AxisId) -> Message:
    """Return what operators call the driver of an axis."""
    return Message("the {axis} axis driver", axis=axis_id.value)


def plain_names(simulated: bool) -> Dict[str, Message]:
    """Return what operators call each node, by its name relative to the robot's namespace.

    Args:
        simulated: Whether the robot is simulated; if so, the simulator is needed too.
    """
    names = {f"{axis_id.value}_axis/axis_driver": axis_driver(axis_id) for axis_id in AxisId}
    names["height_sensor"] = HEIGHT_SENSOR
    names["vna_acquisition"] = VNA_DRIVER
    names["vna_processing"] = STORAGE
    if simulated:
        names["simulator"] = Message("the simulated robot")
    return names

"""What the nodes and their health are called."""

from __future__ import annotations

from typing import Dict

from gpr20_common.message import Message, verbatim
from gpr20_user_interface.mid.events import HealthLevel
from gpr20_user_interface.mid.robot_health import SENSOR_PREFIX

_LEVELS: Dict[HealthLevel, Message] = {
    HealthLevel.OK: Message("GOOD"),
    HealthLevel.WARN: Message("WARNING"),
    HealthLevel.ERROR: Message("FAULT"),
    HealthLevel.STALE: Message("OFFLINE"),
}

_NODES: Dict[str, Message] = {
    "main_control": Message("Main control"),
    "vna_acquisition": Message("VNA driver"),
    "vna_processing": Message("Storage"),
    "imaging": Message("Imaging"),
    "x_axis/axis_driver": Message("X axis"),
    "y_axis/axis_driver": Message("Y axis"),
    "z_axis/axis_driver": Message("Z axis"),
    "height_sensor": Message("Height sensor"),
    "simulator": Message("Simulator"),
}


def level_title(level: HealthLevel) -> Message:
    """Return the health of a node in one word."""
    return _LEVELS[level]


def node_title(name: str) -> Message:
    """Return what the operator calls a node; one without a title keeps its name."""
    if name.startswith(SENSOR_PREFIX):
        return Message("Sensor {name}", name=name[len(SENSOR_PREFIX) :])
    return _NODES.get(name) or verbatim(name)

"""Health of the nodes of a robot, as they report it."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Mapping

from gpr20_common.message import Message
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import ANALYZER, HEIGHT_SENSOR, STORAGE

MAIN_CONTROL = "main_control"
IMAGING = "imaging"


def axis_node(axis_id: AxisId) -> str:
    """Return the name of the driver of an axis."""
    return f"{axis_id.value}_axis/axis_driver"


# In the order in which they are listed.
EXPECTED_NODES = (
    MAIN_CONTROL,
    ANALYZER,
    STORAGE,
    IMAGING,
    *map(axis_node, AxisId),
    HEIGHT_SENSOR,
)


# Other sensors beside the radar report below this name, and are listed once they have.
SENSOR_PREFIX = "sensors/"
MAX_SENSORS = 32


class HealthLevel(enum.IntEnum):
    """Health of a part of the robot; the values are those of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class NodeHealth:
    """What a node reports about itself on /diagnostics, once a second."""

    name: str
    level: HealthLevel
    message: Message
    values: Mapping[str, str]

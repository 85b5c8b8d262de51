"""The nodes of a robot: what they are called, and their health, as they report it."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Dict, Mapping, Optional

from gpr20_common.message import Message, verbatim
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import ANALYZER, HEIGHT_SENSOR, SIMULATOR, STORAGE

MAIN_CONTROL = "main_control"
IMAGING = "imaging"
WEB = "web"
VISUALIZATION = "visualization"


def axis_node(axis_id: AxisId) -> str:
    """Return the name of the driver of an axis."""
    return f"{axis_id.value}_axis/axis_driver"


# In the order in which they are listed.
EXPECTED_NODES = (MAIN_CONTROL, ANALYZER, STORAGE, IMAGING, *map(axis_node, AxisId), HEIGHT_SENSOR)
# Not every robot has them: they are listed, and missed, once they have reported; by the doctor also
# if they were launched.
OPTIONAL_NODES = (SIMULATOR, WEB, VISUALIZATION)
# Other sensors beside the radar report below this name, and are listed once they have.
SENSOR_PREFIX = "sensors/"
MAX_SENSORS = 32


# What drives the hardware, on a computer of its own if there are two.
DRIVERS = (*map(axis_node, AxisId), HEIGHT_SENSOR)
_TITLES: Dict[str, Message] = {
    MAIN_CONTROL: Message("Main control"),
    ANALYZER: Message("VNA driver"),
    STORAGE: Message("Storage"),
    IMAGING: Message("Imaging"),
    "x_axis/axis_driver": Message("X axis"),
    "y_axis/axis_driver": Message("Y axis"),
    "z_axis/axis_driver": Message("Z axis"),
    HEIGHT_SENSOR: Message("Height sensor"),
    SIMULATOR: Message("Simulator"),
    WEB: Message("Web page"),
    VISUALIZATION: Message("Visualization"),
}


def node_title(name: str) -> Message:
    """Return what the operator calls a node; one without a title keeps its name."""
    if name.startswith(SENSOR_PREFIX):
        return Message("Sensor {name}", name=name[len(SENSOR_PREFIX) :])
    return _TITLES.get(name) or verbatim(name)


class HealthLevel(enum.IntEnum):
    """Health of a part of the robot; the values are those of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


def level_title(level: HealthLevel) -> Message:
    """Return the health of a node in one word."""
    return (Message("GOOD"), Message("WARNING"), Message("FAULT"), Message("OFFLINE"))[level]


@dataclass(frozen=True)
class ReportedValues:
    """The values that only the diagnostics hold and that something depends on.

    Attributes:
        free_disk_mb: Space for recordings [MB]; None: not reported.
        identity: What the VNA says it is; empty: not reported.
        calibration: Name of its calibration status; empty: not reported.
    """

    free_disk_mb: Optional[float]
    identity: str
    calibration: str


@dataclass(frozen=True)
class NodeHealth:
    """What a node reports about itself on /diagnostics, once a second.

    Attributes:
        name: Of the node.
        level: Its own judgement.
        message: What it says, with the fault.
        values: As they are shown to people; programs use `reported`.
    """

    name: str
    level: HealthLevel
    message: Message
    values: Mapping[str, str]

    @property
    def reported(self) -> ReportedValues:
        """The values that something depends on."""
        return ReportedValues(
            free_disk_mb=_size(self.values.get("free disk [MB]", "")),
            identity=self.values.get("identity", ""),
            calibration=self.values.get("calibration", ""),
        )


def _size(text: str) -> Optional[float]:
    try:
        size = float(text)
    except ValueError:
        return None
    return size if math.isfinite(size) and size >= 0.0 else None

"""The nodes of a robot: what they are called, and their health, as they report it."""

from __future__ import annotations

import enum
from collections import deque
from dataclasses import dataclass, field, replace
from typing import Deque, Dict, List, Mapping, Optional, Tuple

from gpr20_common.faults import INTERNAL, PART_SILENT
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, Severity, in_a_row, verbatim
from gpr20_doctor.mid.finding import Level
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import NOT_HOMED
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
# Not every robot has them: they are listed, and missed, once they have reported.
OPTIONAL_NODES = (SIMULATOR, WEB, VISUALIZATION)
# Other sensors beside the radar report below this name, and are listed once they have.
SENSOR_PREFIX = "sensors/"
MAX_SENSORS = 32
# Nodes report once a second; a node whose report is older than this [s] hangs or has ended.
STALE_S = 4.0
# Not what a survey needs: the state says how the main control is, and images and page can wait.
NOT_NEEDED = (MAIN_CONTROL, IMAGING, WEB, VISUALIZATION)
# Of the clock offsets in so many reports the smallest has the least delay in it.
OFFSETS = 5


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


@dataclass(frozen=True)
class NodeHealth:
    """What a node reports about itself on /diagnostics, once a second.

    Attributes:
        name: Of the node.
        level: Its own judgement.
        message: What it says, with the fault.
        values: As they are shown to people.
        clock_offset_s: How far the clock of its computer is behind this one [s], with the delay.
    """

    name: str
    level: HealthLevel
    message: Message
    values: Mapping[str, str]
    clock_offset_s: float = field(default=0.0, compare=False)

    @property
    def rating(self) -> Level:
        """How the doctor, the window and the page judge it alike."""
        if self.level is HealthLevel.WARN:
            cause = self.message.cause
            # The next survey homes by itself.
            homes = NOT_HOMED.as_warning()
            is_note = cause is not None and (cause.severity is Severity.NOTE or cause == homes)
            return Level.NOTE if is_note else Level.WARNING
        return Level.OK if self.level is HealthLevel.OK else Level.FAULT


@dataclass(frozen=True)
class HealthReport:
    """Health of every node, in the order to be shown; one that does not report is STALE.

    Attributes:
        settled: Whether each node had the time to report once.
    """

    nodes: Tuple[NodeHealth, ...] = ()
    settled: bool = True

    @property
    def reported(self) -> Tuple[NodeHealth, ...]:
        """The nodes without those that have not had the time to report."""
        if self.settled:
            return self.nodes
        return tuple(one for one in self.nodes if one.level is not HealthLevel.STALE)

    @property
    def trouble(self) -> Optional[Message]:
        """What keeps a survey from running: parts that have failed or do not report; else None."""
        needed = [
            one
            for one in self.reported
            if one.name not in NOT_NEEDED and not one.name.startswith(SENSOR_PREFIX)
        ]
        found = [
            Message("{name}: {state}", name=node_title(one.name), state=one.message).with_fault(
                INTERNAL
            )
            for one in needed
            if one.level is HealthLevel.ERROR
        ]
        silent = tuple(node_title(one.name) for one in needed if one.level is HealthLevel.STALE)
        if silent:
            found.append(Message("No report: {parts}", parts=silent).with_fault(PART_SILENT))
        if len(found) > 1:
            return in_a_row(found)
        return found[0] if found else None


class HealthTracker:
    """Remembers the last reports of each node; the clock measures how old they are."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._begun_s = clock.now_s()
        # The last reports of each node, and when the last one came [s].
        self._reports: Dict[str, Tuple[Deque[NodeHealth], float]] = {}

    def note(self, health: NodeHealth) -> bool:
        """Take a report; return whether its node is one of a robot's."""
        name = health.name
        known = name in self._reports or len(self._sensors()) < MAX_SENSORS
        if name not in (*EXPECTED_NODES, *OPTIONAL_NODES) and not (
            name.startswith(SENSOR_PREFIX) and known
        ):
            return False
        few, _received_s = self._reports.get(name, (deque(maxlen=OFFSETS), 0.0))
        few.append(health)
        self._reports[name] = few, self._clock.now_s()
        return True

    def report(self) -> HealthReport:
        """Return the health of every node now."""
        more = [one for one in OPTIONAL_NODES if one in self._reports]
        names = (*EXPECTED_NODES, *more, *self._sensors())
        settled = self._clock.now_s() - self._begun_s > STALE_S
        return HealthReport(tuple(self._node(name) for name in names), settled)

    @property
    def silent(self) -> List[str]:
        """The nodes that should have reported and never have."""
        return [name for name in EXPECTED_NODES if name not in self._reports]

    def _sensors(self) -> List[str]:
        return sorted(name for name in self._reports if name.startswith(SENSOR_PREFIX))

    def _node(self, name: str) -> NodeHealth:
        if name not in self._reports:
            return NodeHealth(name, HealthLevel.STALE, verbatim(""), {})
        few, received_s = self._reports[name]
        offset_s = min((one.clock_offset_s for one in few), key=abs)
        level = HealthLevel.STALE if self._clock.now_s() - received_s > STALE_S else few[-1].level
        return replace(few[-1], level=level, clock_offset_s=offset_s)

"""Health of the nodes, and the alarms."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.node_health import (
    EXPECTED_NODES,
    MAX_SENSORS,
    SENSOR_PREFIX,
    HealthLevel,
    NodeHealth,
)
from gpr20_operator import faults

# Nodes report once a second; a node whose report is older than this [s] hangs or has ended.
STALE_S = 4.0
# Listed once it has reported.
SIMULATOR = "simulator"
ANALYZER = "vna_acquisition"
STORAGE = "vna_processing"


@dataclass(frozen=True)
class HealthReport:
    """Health of every node.

    Attributes:
        nodes: In the order to be shown; a node that does not report is STALE.
    """

    nodes: Tuple[NodeHealth, ...] = ()

    def node(self, name: str) -> Optional[NodeHealth]:
        """Return the health of a node; None if it is not listed."""
        return next((node for node in self.nodes if node.name == name), None)

    @property
    def analyzer_fault(self) -> Optional[Message]:
        """The fault that the VNA driver reports; None if there is none."""
        analyzer = self.node(ANALYZER)
        if analyzer is None or analyzer.level is not HealthLevel.ERROR:
            return None
        return analyzer.message

    @property
    def free_disk_mb(self) -> Optional[float]:
        """Space for recordings [MB]; None if it is not known now."""
        storage = self._reporting(STORAGE)
        return None if storage is None else storage.reported.free_disk_mb

    @property
    def calibration(self) -> str:
        """Calibration of the VNA when it was last read; empty if that is not known now."""
        analyzer = self._reporting(ANALYZER)
        return "" if analyzer is None else analyzer.reported.calibration

    def _reporting(self, name: str) -> Optional[NodeHealth]:
        node = self.node(name)
        return None if node is None or node.level is HealthLevel.STALE else node


class HealthTracker:
    """Remembers the last report of each node."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._reports: Dict[str, Tuple[NodeHealth, float]] = {}

    def note(self, health: NodeHealth) -> None:
        """Take a report; those of nodes that are not listed are ignored."""
        if health.name in EXPECTED_NODES or health.name == SIMULATOR or self._is_sensor(health):
            self._reports[health.name] = health, self._clock.now_s()

    def report(self) -> HealthReport:
        """Return the health of every node now."""
        more = [SIMULATOR] if SIMULATOR in self._reports else []
        names = (*EXPECTED_NODES, *more, *self._sensors())
        return HealthReport(tuple(self._node(name) for name in names))

    def _sensors(self) -> List[str]:
        return sorted(name for name in self._reports if name.startswith(SENSOR_PREFIX))

    def _is_sensor(self, health: NodeHealth) -> bool:
        known = health.name in self._reports or len(self._sensors()) < MAX_SENSORS
        return health.name.startswith(SENSOR_PREFIX) and known

    def _node(self, name: str) -> NodeHealth:
        if name not in self._reports:
            return NodeHealth(name, HealthLevel.STALE, verbatim(""), {})
        health, received_s = self._reports[name]
        if self._clock.now_s() - received_s <= STALE_S:
            return health
        return NodeHealth(name, HealthLevel.STALE, health.message, health.values)


class AlarmKind(enum.Enum):
    """What keeps the window from the robot, or the robot from the survey."""

    MASTER_GONE = "master gone"
    NO_CONTROL = "no control"
    CONTROL_LOST = "control lost"
    SURVEY_INTERRUPTED = "survey interrupted"
    ANALYZER_FAULT = "analyzer fault"


@dataclass(frozen=True)
class Alarm:
    """An alarm.

    Attributes:
        kind: What is wrong.
        silent_s: Time without contact with the main control [s]; 0 for other alarms.
        reason: The fault that a node reports; None for other alarms.
    """

    kind: AlarmKind
    silent_s: float = 0.0
    reason: Optional[Message] = None

    @property
    def message(self) -> Message:
        """The alarm in a sentence."""
        if self.kind is AlarmKind.CONTROL_LOST:
            return Message(
                "No contact with the main control for {seconds} s: the robot may still move. "
                "Waiting for it.",
                seconds=int(self.silent_s),
            ).with_fault(faults.CONTROL_LOST)
        if self.kind is AlarmKind.ANALYZER_FAULT and self.reason is not None:
            return Message("VNA fault: {reason}", reason=self.reason)
        return _ALARMS[self.kind]


_ALARMS: Dict[AlarmKind, Message] = {
    AlarmKind.MASTER_GONE: Message(
        "The ROS master does not answer: the robot may still move. Waiting for it."
    ).with_fault(faults.MASTER_LOST),
    AlarmKind.NO_CONTROL: Message(
        "No contact with the main control. Start it with: roslaunch gpr20 survey.launch"
    ).with_fault(faults.NO_CONTROL),
    AlarmKind.SURVEY_INTERRUPTED: Message(
        "The main control was restarted: the survey is INTERRUPTED. Resume it on SURVEYS."
    ).with_fault(faults.CONTROL_RESTARTED),
    AlarmKind.ANALYZER_FAULT: Message("VNA fault"),
}

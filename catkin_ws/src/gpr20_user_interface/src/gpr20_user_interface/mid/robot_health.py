"""How the parts of the robot are, and what the operator must know before anything else."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_user_interface.mid.events import HealthLevel, NodeHealth

# Nodes report once a second; a report that is this old [s] tells of a node that hangs or is gone.
STALE_S = 4.0
# In the order in which the window lists them.
EXPECTED_NODES = (
    "main_control",
    "vna_acquisition",
    "vna_processing",
    "x_axis/axis_driver",
    "y_axis/axis_driver",
    "z_axis/axis_driver",
    "height_sensor",
)
# Listed while it is heard.
SIMULATOR = "simulator"
ANALYZER = "vna_acquisition"
STORAGE = "vna_processing"
# Names of values in the nodes' reports.
FREE_DISK = "free disk [MB]"
CALIBRATION = "calibration"


@dataclass(frozen=True)
class HealthReport:
    """How every node is.

    Attributes:
        nodes: In the order to be shown; a node that is not heard is STALE.
    """

    nodes: Tuple[NodeHealth, ...] = ()

    def node(self, name: str) -> Optional[NodeHealth]:
        """Return what is known of a node; None if nobody expects it."""
        return next((node for node in self.nodes if node.name == name), None)

    @property
    def analyzer_trouble(self) -> str:
        """What the VNA's node says is wrong, in its words; empty if nothing."""
        analyzer = self.node(ANALYZER)
        if analyzer is None or analyzer.level is not HealthLevel.ERROR:
            return ""
        return analyzer.message

    @property
    def free_disk_mb(self) -> Optional[float]:
        """Space for recordings [MB]; None if it is not known now."""
        try:
            return float(self._value(STORAGE, FREE_DISK))
        except ValueError:
            return None

    @property
    def calibration(self) -> str:
        """Calibration of the VNA when it was last asked; empty if that is not known now."""
        return self._value(ANALYZER, CALIBRATION)

    def _value(self, name: str, key: str) -> str:
        node = self.node(name)
        if node is None or node.level is HealthLevel.STALE:
            return ""
        return node.values.get(key, "")


class HealthBook:
    """Keeps the last report of each node."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._heard: Dict[str, Tuple[NodeHealth, float]] = {}

    def note(self, health: NodeHealth) -> None:
        """Take note of a report; clients of the robot are no parts of it."""
        if health.name in EXPECTED_NODES or health.name == SIMULATOR:
            self._heard[health.name] = health, self._clock.now_s()

    def report(self) -> HealthReport:
        """Return how every node is now."""
        simulator = [SIMULATOR] if SIMULATOR in self._heard else []
        return HealthReport(tuple(self._node(name) for name in (*EXPECTED_NODES, *simulator)))

    def _node(self, name: str) -> NodeHealth:
        if name not in self._heard:
            return NodeHealth(name, HealthLevel.STALE, "", {})
        health, heard_s = self._heard[name]
        if self._clock.now_s() - heard_s <= STALE_S:
            return health
        return NodeHealth(name, HealthLevel.STALE, health.message, health.values)


class AlarmKind(enum.Enum):
    """What is wrong with the way to the robot."""

    MASTER_GONE = "master gone"
    CONTROL_NEVER_HEARD = "control never heard"
    CONTROL_SILENT = "control silent"
    SURVEY_INTERRUPTED = "survey interrupted"
    ANALYZER_GONE = "analyzer gone"


@dataclass(frozen=True)
class Alarm:
    """An alarm, with what is known about it.

    Attributes:
        kind: What is wrong.
        silent_s: For how long nothing has been heard [s]; 0 if that says nothing.
        detail: What the robot itself says, in its own words.
    """

    kind: AlarmKind
    silent_s: float = 0.0
    detail: str = ""

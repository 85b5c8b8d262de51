"""Health of the parts of the robot, as they report it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

from gpr20_common.faults import INTERNAL, PART_SILENT
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row, verbatim
from gpr20_doctor.mid.node_health import (
    EXPECTED_NODES,
    IMAGING,
    MAIN_CONTROL,
    MAX_SENSORS,
    OPTIONAL_NODES,
    SENSOR_PREFIX,
    VISUALIZATION,
    WEB,
    HealthLevel,
    NodeHealth,
    node_title,
)

# Nodes report once a second; a node whose report is older than this [s] hangs or has ended.
STALE_S = 4.0
# Not what a survey needs: the state says how the main control is, and images and page can wait.
NOT_NEEDED = (MAIN_CONTROL, IMAGING, WEB, VISUALIZATION)


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

    def node(self, name: str) -> Optional[NodeHealth]:
        """Return the health of a node; None if it is not listed."""
        return next((node for node in self.nodes if node.name == name), None)

    @property
    def trouble(self) -> Optional[Message]:
        """What keeps a survey from running: parts that have failed or do not report; else None."""
        needed = [
            one
            for one in self.nodes
            if one.name not in NOT_NEEDED and not one.name.startswith(SENSOR_PREFIX)
        ]
        found = [
            Message("{name}: {state}", name=node_title(one.name), state=one.message).with_fault(
                INTERNAL
            )
            for one in needed
            if one.level is HealthLevel.ERROR
        ]
        silent = tuple(
            node_title(one.name)
            for one in needed
            if one.level is HealthLevel.STALE and self.settled
        )
        if silent:
            found.append(Message("No report: {parts}", parts=silent).with_fault(PART_SILENT))
        if len(found) > 1:
            return in_a_row(found)
        return found[0] if found else None


class HealthTracker:
    """Remembers the last report of each node."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._begun_s = clock.now_s()
        self._reports: Dict[str, Tuple[NodeHealth, float]] = {}

    def note(self, health: NodeHealth) -> None:
        """Take a report; those of nodes that are not listed are ignored."""
        listed = health.name in (*EXPECTED_NODES, *OPTIONAL_NODES)
        if listed or self._is_sensor(health):
            self._reports[health.name] = health, self._clock.now_s()

    def report(self) -> HealthReport:
        """Return the health of every node now."""
        more = [name for name in OPTIONAL_NODES if name in self._reports]
        names = (*EXPECTED_NODES, *more, *self._sensors())
        settled = self._clock.now_s() - self._begun_s > STALE_S
        return HealthReport(tuple(self._node(name) for name in names), settled)

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

"""Collects what the nodes of a robot report until it is enough to judge them."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from typing import Dict, Iterable, List, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_doctor.low.masters import MasterState
from gpr20_doctor.mid.node_health import (
    EXPECTED_NODES,
    MAX_SENSORS,
    SENSOR_PREFIX,
    HealthLevel,
    NodeHealth,
)
from gpr20_doctor.mid.robot_facts import AxisPosition, EndstopSeen, Evidence, RobotFacts
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import SIMULATOR, NodeDescription
from gpr20_survey.results.analyzer_test import AnalyzerTest

# Endstops are watched and clocks compared for so long at least [s].
WATCH_S = 1.5
POLL_S = 0.05


class Listener:
    """Takes reports from any thread, and gives the facts that follow from them."""

    def __init__(self, clock: Clock, master: str) -> None:
        """Begin with no report.

        Args:
            clock: Measures how long was listened.
            master: Address of the master.
        """
        self._clock = clock
        self._master = master
        self._begun_s = clock.now_s()
        self._lock = threading.Lock()
        self._nodes: Dict[str, NodeHealth] = {}
        self._offsets_s: Dict[str, float] = {}
        self._endstops: Dict[AxisId, EndstopSeen] = {}
        self._axes: Dict[AxisId, AxisPosition] = {}
        self._height_m = math.nan
        self._descriptions: Mapping[str, NodeDescription] = {}
        self._configured = False
        self._reports: Dict[str, int] = {}
        self._simulated = False
        self._problem: Optional[Message] = None
        self._surveying: Optional[bool] = None

    def note_node(self, health: NodeHealth, offset_s: float) -> None:
        """Take a node's report, and how far its clock is behind this one [s]."""
        with self._lock:
            if health.name in EXPECTED_NODES or self._is_listed(health.name):
                self._nodes[health.name] = health
                self._reports[health.name] = self._reports.get(health.name, 0) + 1
                known_s = self._offsets_s.get(health.name, math.inf)
                self._offsets_s[health.name] = min(known_s, offset_s, key=abs)

    def note_endstop(self, axis: AxisId, pressed: bool) -> None:
        """Take the state of an endstop."""
        with self._lock:
            seen = self._endstops.get(axis, EndstopSeen(pressed))
            changed = int(seen.pressed != pressed)
            self._endstops[axis] = EndstopSeen(pressed, seen.changes + changed)

    def note_axis(self, axis: AxisId, position: AxisPosition) -> None:
        """Take the state of an axis."""
        with self._lock:
            self._axes[axis] = position

    def note_height(self, height_m: float) -> None:
        """Take a height of the antennas [m]; not finite: it could not be measured."""
        with self._lock:
            self._height_m = height_m

    def note_configuration(
        self, problem: Optional[Message], simulated: bool, nodes: Mapping[str, NodeDescription]
    ) -> None:
        """Take what the nodes say they are.

        Args:
            problem: Why no survey is possible; None: nothing is wrong.
            simulated: Whether the robot is simulated.
            nodes: What each node says.
        """
        with self._lock:
            self._configured = problem is None
            self._problem, self._simulated, self._descriptions = problem, simulated, nodes

    def note_status(self, surveying: bool) -> None:
        """Take whether a survey is running or paused."""
        with self._lock:
            self._surveying = surveying

    @property
    def descriptions(self) -> Mapping[str, NodeDescription]:
        """What the nodes say they are."""
        return self._descriptions

    def wait_for_next(self, names: Iterable[str], limit_s: float) -> None:
        """Return when nodes have reported what they know now, or after a limit [s]."""
        # A report that is under way may be older.
        wanted = {name: self._reports.get(name, 0) + 2 for name in names if name in self._nodes}
        deadline_s = self._clock.now_s() + limit_s
        never = threading.Event()
        while self._clock.now_s() < deadline_s and any(
            self._reports[name] < number for name, number in wanted.items()
        ):
            self._clock.wait_s(never, POLL_S)

    def wait(self, limit_s: float) -> None:
        """Return when every node has reported and endstops were watched, or after a limit [s]."""
        deadline_s = self._begun_s + limit_s
        never = threading.Event()
        while self._clock.now_s() < deadline_s and not self._is_complete():
            self._clock.wait_s(never, POLL_S)

    def facts(self, analyzer: Optional[AnalyzerTest] = None) -> RobotFacts:
        """Return what is known now.

        Args:
            analyzer: Result of a test of the VNA; None: it was not tested.
        """
        with self._lock:
            further = sorted(name for name in self._nodes if name not in EXPECTED_NODES)
            names: List[str] = [*EXPECTED_NODES, *further]
            silent = NodeHealth("", HealthLevel.STALE, verbatim(""), {})
            return RobotFacts(
                master_alive=True,
                control_alive=self._surveying is not None,
                configured=self._configured,
                simulated=self._simulated,
                surveying=bool(self._surveying),
                nodes=tuple(self._nodes.get(name, replace(silent, name=name)) for name in names),
                master=self._master,
                configuration_problem=self._problem,
                clock_offsets_s=dict(self._offsets_s),
                software={name: one.software for name, one in self._descriptions.items()},
                endstops=dict(self._endstops),
                axes=dict(self._axes),
                height_m=self._height_m,
                analyzer=analyzer,
            )

    def silent(self) -> List[str]:
        """Return the names of the nodes that should have reported and have not."""
        with self._lock:
            return [name for name in EXPECTED_NODES if name not in self._nodes]

    def _is_listed(self, name: str) -> bool:
        sensors = sum(one.startswith(SENSOR_PREFIX) for one in self._nodes)
        known = name in self._nodes or sensors < MAX_SENSORS
        return name == SIMULATOR or (name.startswith(SENSOR_PREFIX) and known)

    def _is_complete(self) -> bool:
        with self._lock:
            watched = self._clock.now_s() - self._begun_s >= WATCH_S
            reported = all(name in self._nodes for name in EXPECTED_NODES)
            return watched and reported and self._configured and self._surveying is not None


def unheard(master: str, evidence: Evidence) -> RobotFacts:
    """Return what is known about a robot of which nothing is heard."""
    return RobotFacts(
        master_alive=evidence.master is MasterState.ANSWERS,
        control_alive=False,
        configured=False,
        simulated=False,
        surveying=False,
        nodes=(),
        master=master,
        evidence=evidence,
    )

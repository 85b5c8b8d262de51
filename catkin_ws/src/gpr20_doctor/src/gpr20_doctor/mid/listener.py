"""Collects what the nodes of a robot report until it is enough to judge them."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from typing import Any, Dict, Iterable, List, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_doctor.low.masters import MasterState
from gpr20_doctor.mid.node_health import (
    EXPECTED_NODES,
    MAX_SENSORS,
    OPTIONAL_NODES,
    SENSOR_PREFIX,
    HealthLevel,
    NodeHealth,
)
from gpr20_doctor.mid.robot_facts import AxisPosition, EndstopSeen, Evidence, RobotFacts
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.analyzer_test import AnalyzerTest

# Endstops are watched and clocks compared for so long at least [s].
WATCH_S = 1.5
POLL_S = 0.05


class Listener:
    """Takes reports from any thread, and gives the facts that follow from them."""

    def __init__(self, clock: Clock, master: str, launched: Iterable[str] = ()) -> None:
        """Begin with no report.

        Args:
            clock: Measures how long was listened.
            master: Address of the master.
            launched: Names of nodes that were launched.
        """
        self._expected = (*EXPECTED_NODES, *{*OPTIONAL_NODES}.intersection(launched))
        self._clock = clock
        self._begun_s = clock.now_s()
        self._lock = threading.Lock()
        self._known = unheard(master, Evidence(MasterState.ANSWERS))
        self._nodes: Dict[str, NodeHealth] = {}
        self._reports: Dict[str, int] = {}
        self._descriptions: Mapping[str, NodeDescription] = {}

    def note_node(self, health: NodeHealth, offset_s: float) -> None:
        """Take a node's report, and how far its clock is behind this one [s]."""
        name = health.name
        with self._lock:
            if name in EXPECTED_NODES or self._is_listed(name):
                self._nodes[name] = health
                self._reports[name] = self._reports.get(name, 0) + 1
                offsets_s = self._known.clock_offsets_s
                least_s = min(offsets_s.get(name, math.inf), offset_s, key=abs)
                self._note(clock_offsets_s={**offsets_s, name: least_s})

    def note_endstop(self, axis: AxisId, pressed: bool) -> None:
        """Take the state of an endstop."""
        with self._lock:
            seen = self._known.endstops.get(axis, EndstopSeen(pressed))
            now = EndstopSeen(pressed, seen.changes + int(seen.pressed != pressed))
            self._note(endstops={**self._known.endstops, axis: now})

    def note_axis(self, axis: AxisId, position: AxisPosition) -> None:
        """Take the state of an axis."""
        with self._lock:
            self._note(axes={**self._known.axes, axis: position})

    def note_height(self, height_m: float) -> None:
        """Take a height of the antennas [m]; not finite: it could not be measured."""
        with self._lock:
            self._note(height_m=height_m)

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
            self._descriptions = nodes
            self._note(
                configured=problem is None,
                configuration_problem=problem,
                simulated=simulated,
                software={name: one.software for name, one in nodes.items()},
            )

    def note_status(self, surveying: bool) -> None:
        """Take whether a survey is running or paused."""
        with self._lock:
            self._note(control_alive=True, surveying=surveying)

    def _note(self, **changes: Any) -> None:
        self._known = replace(self._known, **changes)

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
            further = sorted(name for name in self._nodes if name not in self._expected)
            names: List[str] = [*self._expected, *further]
            silent = NodeHealth("", HealthLevel.STALE, verbatim(""), {})
            nodes = tuple(self._nodes.get(name, replace(silent, name=name)) for name in names)
            return replace(self._known, nodes=nodes, analyzer=analyzer)

    def silent(self) -> List[str]:
        """Return the names of the nodes that should have reported and have not."""
        with self._lock:
            return [name for name in self._expected if name not in self._nodes]

    def _is_listed(self, name: str) -> bool:
        sensors = sum(one.startswith(SENSOR_PREFIX) for one in self._nodes)
        known = name in self._nodes or sensors < MAX_SENSORS
        return name in OPTIONAL_NODES or (name.startswith(SENSOR_PREFIX) and known)

    def _is_complete(self) -> bool:
        with self._lock:
            watched = self._clock.now_s() - self._begun_s >= WATCH_S
            reported = all(name in self._nodes for name in self._expected)
            return watched and reported and self._known.configured and self._known.control_alive


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

"""Collects what the nodes of a robot report until it is enough to judge them."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any, Dict, Iterable, List, Mapping, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.low.masters import MasterState
from gpr20_doctor.mid.node_health import HealthTracker, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisReport, Endstop, Evidence, RobotFacts
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
        self._clock = clock
        self._begun_s = clock.now_s()
        self._lock = threading.Lock()
        self._known = unheard(master, Evidence(MasterState.ANSWERS))
        self._health = HealthTracker(clock, launched)
        self._reports: Dict[str, int] = {}
        self._descriptions: Mapping[str, NodeDescription] = {}

    def note_node(self, health: NodeHealth) -> None:
        """Take a node's report."""
        with self._lock:
            if self._health.note(health):
                self._reports[health.name] = self._reports.get(health.name, 0) + 1

    def note_endstop(self, endstop: Endstop) -> None:
        """Take the state of an endstop."""
        with self._lock:
            now = endstop.after(self._known.endstops.get(endstop.axis), self._clock.now_s())
            self._note(endstops={**self._known.endstops, endstop.axis: now})

    def note_axis(self, report: AxisReport) -> None:
        """Take the state of an axis."""
        with self._lock:
            self._note(axes={**self._known.axes, report.axis: report})

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
        wanted = {name: self._reports[name] + 2 for name in names if name in self._reports}
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
            nodes = self._health.report().nodes
            return replace(self._known, nodes=nodes, analyzer=analyzer)

    def silent(self) -> List[str]:
        """Return the names of the nodes that should have reported and have not."""
        with self._lock:
            return self._health.silent

    def _is_complete(self) -> bool:
        with self._lock:
            watched = self._clock.now_s() - self._begun_s >= WATCH_S
            heard = not self._health.silent
            return watched and heard and self._known.configured and self._known.control_alive


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

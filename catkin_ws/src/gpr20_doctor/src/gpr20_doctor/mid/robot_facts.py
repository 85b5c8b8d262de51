"""What is known about the robot from its nodes, and what collects it."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass, field, replace
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low.masters import MasterState, NodeState
from gpr20_doctor.mid.node_health import HealthLevel, HealthTracker, NodeHealth, ReportedValues
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.analyzer_test import AnalyzerTest


@dataclass(frozen=True)
class Endstop:
    """One message of an axis's `endstop`, and what was seen of it while it was watched.

    Attributes:
        changes: How often it was pressed or released.
        heard_s: When it was heard last [s].
        pressed_s: When it was pressed last [s].
    """

    axis: AxisId
    pressed: bool
    changes: int = 0
    heard_s: float = -math.inf
    pressed_s: float = -math.inf

    def after(self, former: Optional[Endstop], now_s: float) -> Endstop:
        """Return it with what was seen before it."""
        changes, pressed_s = 0, -math.inf
        if former is not None:
            changes = former.changes + int(former.pressed != self.pressed)
            pressed_s = former.pressed_s
        pressed_s = now_s if self.pressed else pressed_s
        return Endstop(self.axis, self.pressed, changes, now_s, pressed_s)


@dataclass(frozen=True)
class AxisReport:
    """One message of an axis's `current_coord`.

    Attributes:
        coordinate: Where it is [mm or deg]; meaningful only if homed.
        owner: Full name of the node that holds it; empty: nobody, or it is not known.
        received_s: When it came [s].
        silent: Whether none came for longer than usual.
    """

    axis: AxisId
    coordinate: float
    homed: bool
    moving: bool
    owner: str = ""
    received_s: float = math.inf
    silent: bool = False


@dataclass(frozen=True)
class Evidence:
    """What was found out about a robot, or about parts of it, that cannot be heard.

    Attributes:
        master: What was found at the address of the master.
        namespace: Where the robot was looked for, with a slash in front.
        robots: Namespaces of the robots on the same master.
        elsewhere: (master, namespace) of the robots on other masters.
        local_nodes: Number of nodes whose processes run on this computer.
        nodes: What the silent nodes say when they are asked.
    """

    master: MasterState = MasterState.NOT_THERE
    namespace: str = "/"
    robots: Tuple[str, ...] = ()
    elsewhere: Tuple[Tuple[str, str], ...] = ()
    local_nodes: int = 0
    nodes: Mapping[str, NodeState] = field(default_factory=dict)


@dataclass(frozen=True)
class RobotFacts:
    """What is known about the robot.

    Attributes:
        master_alive: Whether the ROS master answers.
        control_alive: Whether the main control reports.
        configured: Whether limits and settings of the robot are known.
        simulated: Whether the robot is simulated.
        surveying: Whether a survey is running or paused.
        nodes: Health of each expected node; one that does not report is STALE.
        master: Address of the master; empty: not known.
        configuration_problem: Why the robot's configuration is not known; None if it is.
        listening_s: How long the robot was listened to [s].
        software: Software of each node that has described itself.
        endstops: State of the endstops; one that is not known is missing.
        axes: State of the axes; one that is not known is missing.
        height_m: The last height of the antennas [m]; not finite: there was none.
        analyzer: Result of a test of the VNA; None: not tested.
        evidence: What was found out about what cannot be heard.
    """

    master_alive: bool
    control_alive: bool
    configured: bool
    simulated: bool
    surveying: bool
    nodes: Tuple[NodeHealth, ...]
    master: str = ""
    configuration_problem: Optional[Message] = None
    listening_s: float = math.inf
    software: Mapping[str, NodeSoftware] = field(default_factory=dict)
    endstops: Mapping[AxisId, Endstop] = field(default_factory=dict)
    axes: Mapping[AxisId, AxisReport] = field(default_factory=dict)
    height_m: float = math.nan
    analyzer: Optional[AnalyzerTest] = None
    evidence: Evidence = field(default_factory=Evidence)

    @property
    def unheard(self) -> bool:
        """Whether nothing at all is known about the robot."""
        return not self.control_alive and not self.nodes

    @property
    def clock_offsets_s(self) -> Mapping[str, float]:
        """How far the clock of each node's computer is behind this one [s]."""
        heard = (one for one in self.nodes if one.level is not HealthLevel.STALE)
        return {one.name: one.clock_offset_s for one in heard}

    def node(self, name: str) -> Optional[NodeHealth]:
        """Return the health of a node that reports; None if it does not."""
        found = next((node for node in self.nodes if node.name == name), None)
        return None if found is None or found.level is HealthLevel.STALE else found

    def reported(self, name: str) -> Optional[ReportedValues]:
        """Return the values of a node's report; None if it does not report now."""
        node = self.node(name)
        return None if node is None else node.reported


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

    def note(self, **facts: Any) -> None:
        """Take other facts, by their names in `RobotFacts`."""
        with self._lock:
            self._note(**facts)

    def note_configuration(
        self, problem: Optional[Message], simulated: bool, nodes: Mapping[str, NodeDescription]
    ) -> None:
        """Take what the nodes say they are, and why no survey is possible; None: it is."""
        with self._lock:
            self._descriptions = nodes
            self._note(
                configured=problem is None,
                configuration_problem=problem,
                simulated=simulated,
                software={name: one.software for name, one in nodes.items()},
            )

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
        """Return what is known now, with the result of a test of the VNA, if it was tested."""
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

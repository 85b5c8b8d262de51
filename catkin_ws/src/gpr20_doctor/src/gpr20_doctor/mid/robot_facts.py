"""What is known about the robot from its nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Mapping, Optional, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low.masters import MasterState
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_survey.axes import AxisId
from gpr20_survey.results.answers import AnalyzerTest


@dataclass(frozen=True)
class Endstop:
    """One message of an axis's `endstop`, and what was seen of it while it was watched.

    Attributes:
        heard_s: When it was heard last [s].
        pressed_s: When it was pressed last [s].
    """

    axis: AxisId
    pressed: bool
    heard_s: float = -math.inf
    pressed_s: float = -math.inf

    def after(self, former: Optional[Endstop], now_s: float) -> Endstop:
        """Return it with what was seen before it."""
        pressed_s = -math.inf if former is None else former.pressed_s
        return Endstop(self.axis, self.pressed, now_s, now_s if self.pressed else pressed_s)


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
        elsewhere: Other masters of nodes whose processes run on this computer.
        local_nodes: Number of nodes whose processes run on this computer.
    """

    master: MasterState = MasterState.NOT_THERE
    namespace: str = "/"
    robots: Tuple[str, ...] = ()
    elsewhere: Tuple[str, ...] = ()
    local_nodes: int = 0


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
        analyzer: Result of a test of the VNA; None: not tested.
        evidence: What was found out about what cannot be heard.
    """

    master_alive: bool
    control_alive: bool = False
    configured: bool = False
    simulated: bool = False
    surveying: bool = False
    nodes: Tuple[NodeHealth, ...] = ()
    master: str = ""
    configuration_problem: Optional[Message] = None
    listening_s: float = math.inf
    software: Mapping[str, NodeSoftware] = field(default_factory=dict)
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


def unheard(master: str, evidence: Evidence) -> RobotFacts:
    """Return what is known about a robot of which nothing is heard."""
    alive = evidence.master is MasterState.ANSWERS
    return RobotFacts(alive, master=master, evidence=evidence)

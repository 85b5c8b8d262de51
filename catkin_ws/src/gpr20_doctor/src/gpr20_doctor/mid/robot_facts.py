"""What is known about the robot from its nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Mapping, Optional, Tuple

from gpr20_common.message import Message
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low.masters import MasterState, NodeState
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth, ReportedValues
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.results.analyzer_test import AnalyzerTest


@dataclass(frozen=True)
class EndstopSeen:
    """An endstop while it was watched.

    Attributes:
        pressed: Whether it is pressed now.
        changes: How often that changed.
    """

    pressed: bool
    changes: int = 0


@dataclass(frozen=True)
class AxisPosition:
    """The state of an axis, as its `current_coord` says.

    Attributes:
        coordinate: Where it is [mm or deg]; meaningful only if homed.
        homed: Whether its zero is known.
        moving: Whether it moves.
    """

    coordinate: float
    homed: bool
    moving: bool


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
        clock_offsets_s: How far the clock of each node's computer is behind this one [s].
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
    clock_offsets_s: Mapping[str, float] = field(default_factory=dict)
    listening_s: float = math.inf
    software: Mapping[str, NodeSoftware] = field(default_factory=dict)
    endstops: Mapping[AxisId, EndstopSeen] = field(default_factory=dict)
    axes: Mapping[AxisId, AxisPosition] = field(default_factory=dict)
    height_m: float = math.nan
    analyzer: Optional[AnalyzerTest] = None
    evidence: Evidence = field(default_factory=Evidence)

    @property
    def unheard(self) -> bool:
        """Whether nothing at all is known about the robot."""
        return not self.control_alive and not self.nodes

    def node(self, name: str) -> Optional[NodeHealth]:
        """Return the health of a node that reports; None if it does not."""
        found = next((node for node in self.nodes if node.name == name), None)
        return None if found is None or found.level is HealthLevel.STALE else found

    def reported(self, name: str) -> Optional[ReportedValues]:
        """Return the values of a node's report; None if it does not report now."""
        node = self.node(name)
        return None if node is None else node.reported

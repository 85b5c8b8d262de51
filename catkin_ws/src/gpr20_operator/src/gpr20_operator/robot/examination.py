"""What ROBOT lists: findings about the robot and about the window's computer."""

from __future__ import annotations

import math
from collections import deque
from functools import singledispatchmethod
from typing import Deque, Dict, Mapping, Optional, Protocol, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.robot_facts import AxisPosition, EndstopSeen, RobotFacts
from gpr20_operator.robot.events import AxisLimits, MeasuredHeight
from gpr20_operator.robot.service_events import (
    AxisMeasured,
    ClockOffset,
    EndstopState,
    HeightTested,
    MachineExamined,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.analyzer_test import AnalyzerTest

# The smallest of this many offsets has the least delay in it.
OFFSETS = 5
# A test of the VNA is listed for so long [s]; then it may no longer be true.
TEST_AGE_S = 120.0


class ExaminationRequests(Protocol):
    """Requests for an examination, without waiting; the answers come as events."""

    def examine(
        self, nodes: Mapping[str, NodeDescription], surveying: bool, thorough: bool
    ) -> None:
        """Ask what is known about the window's computer."""

    def measure_height(self) -> None:
        """Ask for one height."""

    def test_analyzer(self) -> None:
        """Ask for a test of the VNA."""


class RobotExamination:
    """Takes events, gives findings. Belongs to one thread."""

    def __init__(self, requests: ExaminationRequests, clock: Clock) -> None:
        self._requests = requests
        self._clock = clock
        self._begun_s = clock.now_s()
        self._offsets_s: Dict[str, Deque[float]] = {}
        self._endstops: Dict[AxisId, EndstopSeen] = {}
        self._axes: Dict[AxisId, AxisPosition] = {}
        self._height_m = math.nan
        self._problem: Optional[Message] = None
        self._nodes: Mapping[str, NodeDescription] = {}
        self._machine: Optional[MachineFacts] = None
        self._analyzer: Optional[AnalyzerTest] = None
        self._analyzer_s = 0.0
        self._awaited = 0

    @property
    def in_progress(self) -> bool:
        """Whether answers of an examination are awaited."""
        return self._awaited > 0

    @singledispatchmethod
    def take(self, _event: object) -> None:
        """Take an event; most are about something else."""

    @take.register
    def _(self, event: EndstopState) -> None:
        seen = self._endstops.get(event.axis, EndstopSeen(event.pressed))
        changes = seen.changes + int(seen.pressed != event.pressed)
        self._endstops[event.axis] = EndstopSeen(event.pressed, changes)

    @take.register
    def _(self, event: AxisMeasured) -> None:
        self._axes[event.axis] = event.position

    @take.register
    def _(self, event: MeasuredHeight) -> None:
        self._height_m = event.height_m

    @take.register
    def _(self, event: ClockOffset) -> None:
        offsets_s = self._offsets_s.setdefault(event.node, deque(maxlen=OFFSETS))
        offsets_s.append(event.offset_s)

    @take.register
    def _(self, event: AxisLimits) -> None:
        if event.master_alive:
            self._problem, self._nodes = event.reason, event.nodes

    @take.register
    def _(self, event: MachineExamined) -> None:
        self._note_answer()
        self._machine = event.machine

    @take.register
    def _(self, event: AnalyzerTest) -> None:
        self._note_answer()
        self._analyzer, self._analyzer_s = event, self._clock.now_s()

    @take.register
    def _(self, _event: HeightTested) -> None:
        self._note_answer()

    def begin(self, surveying: bool) -> None:
        """Begin to watch; look at what can be seen at once."""
        self._endstops.clear()
        self._requests.examine(self._nodes, surveying, False)

    def end(self) -> None:
        """End watching."""
        self._offsets_s.clear()
        self._endstops.clear()
        self._axes.clear()
        self._awaited = 0

    def check_everything(self, surveying: bool, can_test: bool) -> None:
        """Look at everything, also at what takes longer.

        Args:
            surveying: Whether a survey is running or paused.
            can_test: Whether nobody else uses the instruments.
        """
        if self.in_progress:
            return
        self._awaited = 3 if can_test else 1
        self._requests.examine(self._nodes, surveying, True)
        if can_test:
            self._requests.measure_height()
            self._requests.test_analyzer()

    def findings(self, snapshot: Snapshot) -> Tuple[Finding, ...]:
        """Return what is wrong with the robot, the worst first."""
        tested = not snapshot.running and self._clock.now_s() - self._analyzer_s < TEST_AGE_S
        robot = RobotFacts(
            master_alive=snapshot.master_alive,
            control_alive=snapshot.control_alive,
            configured=snapshot.travel is not None,
            simulated=snapshot.simulated,
            surveying=snapshot.running,
            nodes=snapshot.health.nodes,
            configuration_problem=self._problem,
            clock_offsets_s={node: min(few, key=abs) for node, few in self._offsets_s.items()},
            listening_s=self._clock.now_s() - self._begun_s,
            software={name: one.software for name, one in self._nodes.items()},
            endstops=dict(self._endstops),
            axes=dict(self._axes),
            height_m=self._height_m,
            analyzer=self._analyzer if tested else None,
        )
        return findings(robot, self._machine)

    def _note_answer(self) -> None:
        self._awaited = max(0, self._awaited - 1)

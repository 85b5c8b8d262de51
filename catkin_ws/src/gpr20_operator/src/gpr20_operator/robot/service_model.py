"""The service of the robot: whether it is possible, what was asked for, and what was found."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from functools import singledispatchmethod
from typing import Deque, Dict, Mapping, Optional, Protocol, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_facts import MachineFacts
from gpr20_doctor.mid.robot_facts import AxisPosition, EndstopSeen, RobotFacts
from gpr20_operator.robot.events import AxisLimits, MeasuredHeight, Request
from gpr20_operator.robot.service_events import (
    PARTS,
    AxisAction,
    AxisMeasured,
    AxisMoved,
    AxisState,
    CheckStepTaken,
    ClockOffset,
    DailyCheckState,
    EndstopState,
    HeightTested,
    MachineExamined,
    ServiceState,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.results.daily_check import Part

# Service ends by itself when nothing was touched for this long [s].
IDLE_LIMIT_S = 120.0
# The states of axis and endstop are published 10 times a second; older ones [s] are not shown.
AXIS_LIMIT_S = 1.0
# A touch of the switch in a homing lasts milliseconds; its lamp shines for this long [s].
LAMP_S = 0.5
STEPS = (1, 10, 100)
# The smallest of this many offsets has the least delay in it.
OFFSETS = 5
# A test of the VNA is listed for so long [s]; then it may no longer be true.
TEST_AGE_S = 120.0


class ServiceRequests(Protocol):
    """Requests for ROBOT, without waiting; the answers come as events."""

    def set_watched(self, watched: bool) -> None:
        """Follow endstops and clocks, or no longer."""

    def examine(
        self, nodes: Mapping[str, NodeDescription], surveying: bool, thorough: bool
    ) -> None:
        """Ask what is known about the window's computer."""

    def move(self, axis: AxisId, action: AxisAction, distance: float) -> None:
        """Ask to home or to jog an axis [mm or deg], or to set its zero."""

    def measure_height(self) -> None:
        """Ask for one height."""

    def test_analyzer(self) -> None:
        """Ask for a test of the VNA."""

    def check_daily(self, part: Part) -> None:
        """Ask to measure a part of the daily check."""


@dataclass(frozen=True)
class _Endstop:
    """An endstop, when it was heard last, and when it was pressed last [s]."""

    seen: EndstopSeen
    heard_s: float
    pressed_s: float = -math.inf


class ServiceModel:
    """Takes events and touches, gives states and findings. Belongs to one thread."""

    def __init__(self, requests: ServiceRequests, clock: Clock) -> None:
        self._requests = requests
        self._clock = clock
        self._begun_s = clock.now_s()
        self._snapshot: Optional[Snapshot] = None
        self._entered = False
        self._touched_s = 0.0
        self._pending = False
        # How many answers of an examination are awaited.
        self._awaited = 0
        self._answer: Optional[AxisMoved] = None
        self._tested: Optional[HeightTested] = None
        # The test that is shown, and the one that is judged with its time [s].
        self._analyzer: Optional[AnalyzerTest] = None
        self._judged: Tuple[Optional[AnalyzerTest], float] = (None, 0.0)
        self._daily_check = DailyCheckState()
        self._endstops: Dict[AxisId, _Endstop] = {}
        self._axes: Dict[AxisId, Tuple[AxisPosition, float]] = {}
        self._offsets_s: Dict[str, Deque[float]] = {}
        self._height_m = math.nan
        self._limits = AxisLimits(None)
        self._machine: Optional[MachineFacts] = None

    @singledispatchmethod
    def on_event(self, _event: object) -> None:
        """Take an event; most are about something else."""

    @on_event.register
    def _(self, event: EndstopState) -> None:
        now_s, known = self._clock.now_s(), self._endstops.get(event.axis)
        changes, pressed_s = 0, -math.inf
        if known is not None:
            changes = known.seen.changes + int(known.seen.pressed != event.pressed)
            pressed_s = known.pressed_s
        seen = EndstopSeen(event.pressed, changes)
        pressed_s = now_s if event.pressed else pressed_s
        self._endstops[event.axis] = _Endstop(seen, now_s, pressed_s)

    @on_event.register
    def _(self, event: AxisMeasured) -> None:
        self._axes[event.axis] = event.position, self._clock.now_s()

    @on_event.register
    def _(self, event: MeasuredHeight) -> None:
        self._height_m = event.height_m

    @on_event.register
    def _(self, event: ClockOffset) -> None:
        self._offsets_s.setdefault(event.node, deque(maxlen=OFFSETS)).append(event.offset_s)

    @on_event.register
    def _(self, event: AxisLimits) -> None:
        if event.master_alive:
            self._limits = event

    @on_event.register
    def _(self, event: MachineExamined) -> None:
        self._note_answer()
        self._machine = event.machine

    @on_event.register
    def _(self, event: AxisMoved) -> None:
        self._pending, self._answer = False, event

    @on_event.register
    def _(self, event: HeightTested) -> None:
        self._note_answer()
        self._pending, self._tested = False, event

    @on_event.register
    def _(self, event: AnalyzerTest) -> None:
        self._note_answer()
        self._pending, self._analyzer = False, event
        self._judged = event, self._clock.now_s()

    @on_event.register
    def _(self, event: CheckStepTaken) -> None:
        self._pending, self._daily_check = False, self._daily_check.after(event)

    def _note_answer(self) -> None:
        self._awaited = max(0, self._awaited - 1)

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now; end the service if it must end."""
        self._snapshot = snapshot
        if self._busy:
            self._touched_s = self._clock.now_s()
        idle_s = self._clock.now_s() - self._touched_s
        if self._entered and (self.obstacle is not None or idle_s > IDLE_LIMIT_S):
            self.leave()

    @property
    def obstacle(self) -> Optional[Message]:
        """Why the robot cannot be serviced now; None: it can."""
        shown = self._snapshot
        if shown is None or not shown.control_alive or not shown.master_alive:
            return Message("There is no contact with the robot.")
        if shown.replay is not None:
            return Message("A replay is shown: there is no robot.")
        if shown.running or {Request.START, Request.RESUME} & shown.pending:
            return Message("Service is not possible while a survey is running or paused.")
        return None

    @property
    def state(self) -> ServiceState:
        """What to show now."""
        activity = None if self._snapshot is None else self._snapshot.service
        answer, outcome = self._answer, None
        failed = activity is None and answer is not None and not answer.success
        if activity is not None:
            outcome = Message("In progress: {activity}", activity=activity)
        elif answer is not None:
            reason = answer.message
            outcome = Message("Not done: {reason}", reason=reason) if failed else reason
        return ServiceState(
            entered=self._entered,
            obstacle=self.obstacle,
            busy=self._busy,
            outcome=outcome,
            failed=failed,
            axes=tuple(self._axis(axis) for axis in AxisId),
            height=self._tested,
            analyzer=self._analyzer,
            examining=self._awaited > 0,
            daily_check=self._daily_check,
        )

    def findings(self) -> Tuple[Finding, ...]:
        """Return what is wrong with the robot, the worst first."""
        shown = self._snapshot
        if shown is None or shown.replay is not None:
            return ()  # what was wrong with the robot of a recording is in its survey
        now_s = self._clock.now_s()
        analyzer, tested_s = self._judged
        nodes = self._limits.nodes
        robot = RobotFacts(
            master_alive=shown.master_alive,
            control_alive=shown.control_alive,
            configured=shown.travel is not None,
            simulated=shown.simulated,
            surveying=shown.running,
            nodes=shown.health.nodes,
            configuration_problem=self._limits.reason,
            clock_offsets_s={node: min(few, key=abs) for node, few in self._offsets_s.items()},
            listening_s=now_s - self._begun_s,
            software={name: one.software for name, one in nodes.items()},
            endstops={axis: one.seen for axis, one in self._endstops.items()},
            axes={axis: position for axis, (position, _heard_s) in self._axes.items()},
            height_m=self._height_m,
            analyzer=None if shown.running or now_s - tested_s >= TEST_AGE_S else analyzer,
        )
        return findings(robot, self._machine)

    def check_everything(self) -> None:
        """Look at everything, also at what takes longer; instruments only outside a survey."""
        if self._awaited:
            return
        can_test = self.obstacle is None and not self._busy
        self._awaited = 3 if can_test else 1
        self._requests.examine(self._limits.nodes, self._surveying, True)
        if can_test:
            self._requests.measure_height()
            self._requests.test_analyzer()

    def set_watched(self, watched: bool) -> None:
        """Note whether ROBOT is in front; service ends when it is not."""
        self._requests.set_watched(watched)
        self._endstops.clear()
        if watched:
            self._requests.examine(self._limits.nodes, self._surveying, False)
            return
        self.leave()
        self._offsets_s.clear()
        self._axes.clear()
        self._awaited = 0

    def enter(self) -> None:
        """Begin the service, unless there is an obstacle."""
        self._entered = self.obstacle is None
        self._answer = None
        self.touch()

    def leave(self) -> None:
        """End the service; a motion in progress is not stopped."""
        self._entered = False

    def touch(self) -> None:
        """Note that the operator is there."""
        self._touched_s = self._clock.now_s()

    def move(self, axis: AxisId, action: AxisAction, distance: float = 0.0) -> None:
        """Ask to home or to jog an axis [mm or deg], or to set its zero."""
        if self._take_turn():
            self._requests.move(axis, action, distance)

    def measure_height(self) -> None:
        """Ask for one height."""
        if self._take_turn():
            self._tested = None
            self._requests.measure_height()

    def test_analyzer(self) -> None:
        """Ask for a test of the VNA."""
        if self._take_turn():
            self._analyzer = None
            self._requests.test_analyzer()

    def check_daily(self) -> None:
        """Begin the daily check; once it has begun, measure its next part."""
        part = self._daily_check.part
        if part is None:
            self.touch()
            self._daily_check = DailyCheckState(PARTS[0])
        elif self._take_turn():
            self._daily_check = DailyCheckState(part, measuring=True)
            self._requests.check_daily(part)

    @property
    def _busy(self) -> bool:
        in_service = self._snapshot is not None and self._snapshot.service is not None
        return self._pending or in_service

    def _take_turn(self) -> bool:
        """Return whether a request may be sent now; one at a time."""
        if not self._entered or self._busy:
            return False
        self.touch()
        self._pending = True
        self._answer = None
        return True

    @property
    def _surveying(self) -> bool:
        return self._snapshot is not None and self._snapshot.running

    def _axis(self, axis: AxisId) -> AxisState:
        known, now_s = AxisState(axis, None, None, None), self._clock.now_s()
        endstop = self._endstops.get(axis)
        if endstop is not None and now_s - endstop.heard_s <= AXIS_LIMIT_S:
            pressed = endstop.seen.pressed or now_s - endstop.pressed_s < LAMP_S
            known = replace(known, pressed=pressed)
        position, heard_s = self._axes.get(axis, (None, 0.0))
        if position is not None and now_s - heard_s <= AXIS_LIMIT_S:
            known = replace(known, homed=position.homed)
        current = None if self._snapshot is None else self._snapshot.current
        if current is not None:
            places = {AxisId.X: current.x_mm, AxisId.Y: current.y_mm, AxisId.Z: current.z_deg}
            known = replace(known, coordinate=places[axis])
        return known

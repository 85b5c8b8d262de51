"""SERVICE: whether the robot may be serviced, what was asked for, and what came back."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import singledispatchmethod
from typing import Dict, Optional, Protocol, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_operator.robot.events import Position, Request
from gpr20_operator.robot.examination import ExaminationRequests, RobotExamination
from gpr20_operator.robot.service_events import (
    AxisAction,
    AxisMeasured,
    AxisMoved,
    CheckStepTaken,
    EndstopState,
    HeightTested,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.results.daily_check import Part

PARTS = tuple(Part)


@dataclass(frozen=True)
class DailyCheckState:
    """Where the daily check is.

    Attributes:
        part: What is to be measured next, or is measured now; None: no check is in progress.
        answer: The verdict, or why the last step failed; None: there is neither.
        measuring: Whether a step is in progress.
    """

    part: Optional[Part] = None
    answer: Optional[CheckStepTaken] = None
    measuring: bool = False

    def after(self, answer: CheckStepTaken) -> DailyCheckState:
        """Return where the check is after the answer to a step."""
        if not answer.success:
            # A step that failed is repeated, unless the robot has forgotten those before it.
            forgotten = answer.message.fault_code == CHECK_ORDER.code
            return DailyCheckState(None if forgotten else self.part, answer)
        if self.part is None or self.part is PARTS[-1]:
            return DailyCheckState(None, answer)
        return DailyCheckState(PARTS[PARTS.index(self.part) + 1])


# Service ends by itself when nothing was touched for this long [s].
IDLE_LIMIT_S = 120.0
# The states of axis and endstop are published 10 times a second; older ones [s] are not shown.
AXIS_LIMIT_S = 1.0
# A touch of the switch in a homing lasts milliseconds; its lamp shines for this long [s].
LAMP_S = 0.5
STEPS = (1, 10, 100)


class ServiceRequests(ExaminationRequests, Protocol):
    """Requests for SERVICE, without waiting; the answers come as events."""

    def set_watched(self, watched: bool) -> None:
        """Follow endstops and clocks, or no longer."""

    def move(self, axis: AxisId, action: AxisAction, distance: float) -> None:
        """Ask to home or to jog an axis [mm or deg], or to set its zero."""

    def check_daily(self, part: Part) -> None:
        """Ask to measure a part of the daily check."""


@dataclass(frozen=True)
class AxisState:
    """What is known about an axis.

    Attributes:
        axis: Which axis.
        coordinate: Where it is [mm or deg]; None: not known.
        homed: Whether its zero is known; None: not known now.
        pressed: Whether its endstop is pressed; None: not known now, or there is none.
    """

    axis: AxisId
    coordinate: Optional[float]
    homed: Optional[bool]
    pressed: Optional[bool]


@dataclass(frozen=True)
class ServiceState:
    """What SERVICE shows.

    Attributes:
        entered: Whether the axes may be moved.
        obstacle: Why the robot cannot be serviced now; None: it can.
        busy: Whether a request is in progress.
        outcome: The last answer about an axis, or what is done now; None: there was none.
        failed: Whether the last answer was a failure.
        axes: X, Y and Z.
        height: The last height; None: none was measured.
        analyzer: The last test of the VNA; None: there was none.
        examining: Whether everything is being checked.
        daily_check: Where the daily check is.
    """

    entered: bool
    obstacle: Optional[Message]
    busy: bool
    outcome: Optional[Message]
    failed: bool
    axes: Tuple[AxisState, ...]
    height: Optional[HeightTested]
    analyzer: Optional[AnalyzerTest]
    examining: bool = False
    daily_check: DailyCheckState = field(default_factory=DailyCheckState)


class ServiceModel:
    """Takes events and touches, gives states. Belongs to one thread."""

    def __init__(self, requests: ServiceRequests, clock: Clock) -> None:
        self._requests = requests
        self._clock = clock
        self._snapshot: Optional[Snapshot] = None
        self._entered = False
        self._touched_s = 0.0
        self._pending = False
        self._answer: Optional[AxisMoved] = None
        self._height: Optional[HeightTested] = None
        self._analyzer: Optional[AnalyzerTest] = None
        self._daily_check = DailyCheckState()
        self._endstops: Dict[AxisId, _Lamp] = {}
        # Whether each axis is homed, and when that was reported [s].
        self._homed: Dict[AxisId, Tuple[bool, float]] = {}
        self._examination = RobotExamination(requests, clock)

    def on_event(self, event: object) -> None:
        """Take an event."""
        self._examination.take(event)
        self._take(event)

    @singledispatchmethod
    def _take(self, _event: object) -> None:
        """Take an event; most are about something else."""

    @_take.register
    def _(self, event: EndstopState) -> None:
        self._endstops.setdefault(event.axis, _Lamp(self._clock)).note(event.pressed)

    @_take.register
    def _(self, event: AxisMeasured) -> None:
        self._homed[event.axis] = event.position.homed, self._clock.now_s()

    @_take.register
    def _(self, event: AxisMoved) -> None:
        self._pending, self._answer = False, event

    @_take.register
    def _(self, event: HeightTested) -> None:
        self._pending, self._height = False, event

    @_take.register
    def _(self, event: AnalyzerTest) -> None:
        self._pending, self._analyzer = False, event

    @_take.register
    def _(self, event: CheckStepTaken) -> None:
        self._pending, self._daily_check = False, self._daily_check.after(event)

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
            height=self._height,
            analyzer=self._analyzer,
            examining=self._examination.in_progress,
            daily_check=self._daily_check,
        )

    def findings(self) -> Tuple[Finding, ...]:
        """Return what is wrong with the robot, the worst first."""
        if self._snapshot is None:
            return ()
        return self._examination.findings(self._snapshot)

    def check_everything(self) -> None:
        """Check everything, also what takes longer; instruments only outside a survey."""
        running = self._snapshot is not None and self._snapshot.running
        self._examination.check_everything(running, self.obstacle is None and not self._busy)

    def set_watched(self, watched: bool) -> None:
        """Note whether SERVICE is in front; service ends when it is not."""
        self._requests.set_watched(watched)
        if watched:
            self._examination.begin(self._snapshot is not None and self._snapshot.running)
        else:
            self.leave()
            self._examination.end()

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
            self._height = None
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

    def _axis(self, axis: AxisId) -> AxisState:
        lamp = self._endstops.get(axis)
        pressed = None if lamp is None else lamp.pressed
        if self._snapshot is None:
            return AxisState(axis, None, None, pressed)
        known, noted_s = self._homed.get(axis, (None, 0.0))
        homed = known if self._clock.now_s() - noted_s <= AXIS_LIMIT_S else None
        return AxisState(axis, _coordinate(self._snapshot.current, axis), homed, pressed)


class _Lamp:
    """The state of an endstop as a lamp shows it."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._pressed = False
        self._noted_s = 0.0
        self._pressed_s: Optional[float] = None

    def note(self, pressed: bool) -> None:
        self._pressed, self._noted_s = pressed, self._clock.now_s()
        if pressed:
            self._pressed_s = self._noted_s

    @property
    def pressed(self) -> Optional[bool]:
        now_s = self._clock.now_s()
        if now_s - self._noted_s > AXIS_LIMIT_S:
            return None
        shining = self._pressed_s is not None and now_s - self._pressed_s < LAMP_S
        return self._pressed or shining


def _coordinate(position: Optional[Position], axis: AxisId) -> Optional[float]:
    if position is None:
        return None
    places = {AxisId.X: position.x_mm, AxisId.Y: position.y_mm, AxisId.Z: position.z_deg}
    return places[axis]

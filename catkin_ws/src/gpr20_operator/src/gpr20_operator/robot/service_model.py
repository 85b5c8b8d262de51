"""The service of the robot: whether it is possible, what was asked for, and what was found."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine import MachineReport
from gpr20_doctor.mid.robot_facts import AxisReport, Endstop, RobotFacts
from gpr20_operator.jobs.job import Job, Requests, Service
from gpr20_operator.robot.events import Request, RobotDescribed
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.answers import AnalyzerTest, Part

# Service ends by itself when nothing was touched for this long [s].
IDLE_LIMIT_S = 120.0
# The state of an endstop is published 10 times a second; an older one [s] is not shown.
ENDSTOP_LIMIT_S = 1.0
# A touch of the switch in a homing lasts milliseconds; its lamp shines for this long [s].
LAMP_S = 0.5
STEPS = (1, 10, 100)
Examine = Callable[[Mapping[str, NodeDescription], bool], None]
# A test of the VNA is listed for so long [s]; then it may no longer be true.
TEST_AGE_S = 120.0


PARTS = tuple(Part)


class AxisAction(enum.IntEnum):
    """What an axis can be asked for; the values are those of gpr20_msgs/ServiceMove."""

    HOME = 0
    JOG = 1
    SET_ZERO = 2


@dataclass(frozen=True)
class HeightTested:
    """One height of the height sensor.

    Attributes:
        height_m: Antennas over the ground [m]; not finite if there is a failure.
        spread_m: Of its readings [m].
        voltage_v: Of the sensor [V]; not finite if it could not be read.
        failure: Why there is no height; None if there is one.
    """

    height_m: float
    spread_m: float
    voltage_v: float
    failure: Optional[Message] = None


class ServiceModel:
    """Takes events and touches, gives states and findings. Belongs to one thread.

    Args:
        requests: Calls the services of the robot.
        examine: Finds out about this computer in the background; its report is an event.
        clock: Measures ages, and how long nothing was touched.

    Attributes:
        entered: Whether the axes may be moved.
        daily: A step of the daily check; the result is the verdict.
    """

    def __init__(self, requests: Requests, examine: Examine, clock: Clock) -> None:
        self._now_s = now_s = clock.now_s
        self._begun_s = now_s()
        self._snapshot: Optional[Snapshot] = None
        self.entered = False
        self._touched_s = 0.0
        self.moving: Job[Message] = Job(requests, Service.MOVE, now_s)
        self.height: Job[HeightTested] = Job(requests, Service.HEIGHT, now_s)
        self.analyzer: Job[AnalyzerTest] = Job(requests, Service.ANALYZER, now_s)
        self.daily: Job[Message] = Job(requests, Service.DAILY, now_s, self._take_step)
        self._examine = examine
        # Whether a report of the computer is awaited.
        self._examining = False
        # Whether everything is being checked.
        self._checking = False
        # What is to be measured next.
        self._part: Optional[Part] = None
        self._endstops: Dict[AxisId, Endstop] = {}
        self._described = RobotDescribed()
        self._machine: Optional[MachineReport] = None

    def on_event(self, event: object) -> None:
        """Take an event; most are about something else."""
        if isinstance(event, Endstop):
            former = self._endstops.get(event.axis)
            self._endstops[event.axis] = event.after(former, self._now_s())
        elif isinstance(event, RobotDescribed):
            self._described = event
        elif isinstance(event, MachineReport):
            self._machine, self._examining = event, False

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known of the robot now; end the service if it must end."""
        self._snapshot = snapshot
        if self.busy:
            self._touched_s = self._now_s()
        idle_s = self._now_s() - self._touched_s
        if self.entered and (self.obstacle is not None or idle_s > IDLE_LIMIT_S):
            self.leave()

    @property
    def obstacle(self) -> Optional[Message]:
        """Why the robot cannot be serviced now; None: it can."""
        shown = self._snapshot
        if shown is None or not shown.control_alive or not shown.master_alive:
            return Message("There is no contact with the robot.")
        if shown.running or {Request.START, Request.RESUME} & shown.pending:
            return Message("Service is not possible while a survey is running or paused.")
        return None

    @property
    def busy(self) -> bool:
        """Whether a request is in progress, of this window or of another one."""
        asked = any(one.running for one in (self.moving, self.height, self.analyzer, self.daily))
        return asked or (self._snapshot is not None and self._snapshot.service is not None)

    @property
    def examining(self) -> bool:
        """Whether everything is being checked."""
        awaited = self._examining or self.height.running or self.analyzer.running
        return self._checking and awaited

    @property
    def failed(self) -> bool:
        """Whether the outcome is a failure."""
        return self._activity is None and self.moving.problem is not None

    @property
    def outcome(self) -> Optional[Message]:
        """What is done now, or the last answer about an axis; None: there was none."""
        if self._activity is not None:
            return Message("In progress: {activity}", activity=self._activity)
        if self.moving.problem is not None:
            return Message("Not done: {reason}", reason=self.moving.problem)
        return self.moving.result

    def axis(self, axis: AxisId) -> Optional[AxisReport]:
        """Return what an axis has just reported; None: not known now."""
        reports = () if self._snapshot is None else self._snapshot.axes
        return next((one for one in reports if one.axis is axis and not one.silent), None)

    def pressed(self, axis: AxisId) -> Optional[bool]:
        """Return whether an endstop is pressed, or was just now; None: not known now."""
        endstop, now_s = self._endstops.get(axis), self._now_s()
        if endstop is None or now_s - endstop.heard_s > ENDSTOP_LIMIT_S:
            return None
        return endstop.pressed or now_s - endstop.pressed_s < LAMP_S

    @property
    def part(self) -> Optional[Part]:
        """What the daily check measures now or next; None: no check is in progress."""
        problem = self.daily.problem
        # A step that failed is repeated, unless the robot has forgotten those before it.
        forgotten = problem is not None and problem.fault_code == CHECK_ORDER.code
        return None if forgotten else self._part

    @property
    def tested(self) -> Optional[AnalyzerTest]:
        """The last test of the VNA; None: there was none, or it is in progress."""
        problem = self.analyzer.problem
        return self.analyzer.result if problem is None else AnalyzerTest("", failure=problem)

    def findings(self) -> Tuple[Finding, ...]:
        """Return what is wrong with the robot, the worst first."""
        shown = self._snapshot
        if shown is None:
            return ()
        now_s = self._now_s()
        old = now_s - self.analyzer.changed_s >= TEST_AGE_S
        nodes = self._described.nodes
        robot = RobotFacts(
            master_alive=shown.master_alive,
            control_alive=shown.control_alive,
            configured=shown.robot is not None,
            simulated=shown.simulated,
            surveying=shown.running,
            nodes=shown.health.nodes,
            configuration_problem=self._described.reason,
            listening_s=now_s - self._begun_s,
            software={name: one.software for name, one in nodes.items()},
            analyzer=None if shown.running or old else self.tested,
        )
        return findings(robot, self._machine)

    def check_everything(self) -> None:
        """Look at everything, also at what takes longer; instruments only outside a survey."""
        if self.examining:
            return
        can_test = self.obstacle is None and not self.busy
        self._checking = True
        self._look(thorough=True)
        if can_test:
            self.height.ask()
            self.analyzer.ask()

    def set_watched(self, watched: bool) -> None:
        """Note whether ROBOT is in front; service ends when it is not."""
        self._endstops.clear()
        if watched:
            self._begun_s = self._now_s()
            self._look(thorough=False)
            return
        self.leave()
        self._checking = False

    def enter(self) -> None:
        """Begin the service, unless there is an obstacle."""
        self.entered = self.obstacle is None
        if not self.moving.running:
            self.moving.end()
        self.touch()

    def leave(self) -> None:
        """End the service; a motion in progress is not stopped."""
        self.entered = False

    def touch(self) -> None:
        """Note that the operator is there."""
        self._touched_s = self._now_s()

    def move(self, axis: AxisId, action: AxisAction, distance: float = 0.0) -> None:
        """Ask to home or to jog an axis [mm or deg], or to set its zero."""
        self.ask(self.moving, axis=axis.value, action=int(action), distance=distance)

    def check_daily(self) -> None:
        """Begin the daily check; once it has begun, measure its next part."""
        if self.part is not None:
            self.ask(self.daily, step=PARTS.index(self.part))
        elif not self.daily.running:
            self.touch()
            self._part = PARTS[0]
            self.daily.end()

    def ask(self, job: Job[Any], **fields: Any) -> None:
        """Send a request, if the operator may; one at a time."""
        if self.entered and not self.busy:
            self.touch()
            self.moving.end()
            job.ask(**fields)

    def _take_step(self, _verdict: Message) -> None:
        if self._part is None or self._part is PARTS[-1]:
            self._part = None
            return
        self._part = PARTS[PARTS.index(self._part) + 1]
        # Only the last part has a verdict.
        self.daily.end()

    def _look(self, thorough: bool) -> None:
        self._examining = True
        self._examine(self._described.nodes, thorough)

    @property
    def _activity(self) -> Optional[Message]:
        return None if self._snapshot is None else self._snapshot.service

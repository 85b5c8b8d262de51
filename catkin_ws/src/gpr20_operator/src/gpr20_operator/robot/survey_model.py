"""The state of the survey as a window shows it: what is known and what may be pressed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Dict, FrozenSet, Generic, Optional, Set, Tuple, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import NodeHealth
from gpr20_operator.robot.events import (
    Answer,
    AxisLimits,
    AxisReport,
    ControlParameters,
    ControlState,
    CurrentPosition,
    MeasuredHeight,
    Progress,
    Request,
    RobotDefaults,
    RobotFigures,
    TargetPosition,
)
from gpr20_operator.robot.health import (
    SIMULATOR,
    Alarm,
    AlarmKind,
    HealthReport,
    HealthTracker,
)
from gpr20_operator.robot.replay import ReplayView
from gpr20_operator.robot.service_events import AxisMeasured, ServiceActivity
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

BEGINNING = (SurveyState.CHECKING, SurveyState.HOMING)
NOT_BEGUN = (SurveyState.FAILED, SurveyState.PAUSED)


class RequestOutcome:
    """Detects that the checks after the acceptance fail.

    The main control answers before it checks the robot and homes the axes: only its status shows
    what fails then.
    """

    def __init__(self) -> None:
        self._request: Optional[Request] = None
        self._begun = False

    def asked(self, request: Request) -> None:
        """Note what the operator asks for."""
        self._request = request if request in (Request.START, Request.RESUME) else None
        self._begun = False

    def answered(self, answer: Answer) -> None:
        """Take an answer; a request that was refused has no outcome."""
        if answer.request is self._request and not answer.success:
            self._request = None

    def failed_request(self, state: ControlState) -> Optional[Request]:
        """Return the request that failed with this state, once; else None."""
        if self._request is None:
            return None
        if state.code in BEGINNING:
            self._begun = True
            return None
        # Until then the states are those from before the request.
        if not self._begun:
            return None
        request, self._request = self._request, None
        return request if state.code in NOT_BEGUN else None


# The main control publishes at 2 Hz; over a link that loses packets, it may be late by seconds.
CONTROL_SILENCE_S = 5.0
# A coordinate or height that is older than this [s] is not shown.
STALE_S = 3.0


@dataclass(frozen=True)
class Refusal:
    """A request that was refused or failed, and why.

    Attributes:
        request: What was asked for.
        reason: Why it was refused.
        other_analyzer: Identity of another analyzer with which the survey can be resumed; empty
            if the operator has nothing to accept.
    """

    request: Request
    reason: Message
    other_analyzer: str = ""


@dataclass(frozen=True)
class Snapshot:
    """Everything that the window shows at one moment; None: not known now."""

    control_alive: bool
    control_silent_s: Optional[float]
    state: Optional[ControlState]
    progress: Optional[Progress]
    current: Optional[CurrentPosition]
    target: Optional[TargetPosition]
    height_m: Optional[float]
    pending: FrozenSet[Request]
    travel: Optional[RobotTravel]
    # The parameters of the survey that runs, also of one that another client started.
    survey_parameters: Optional[SurveyParameters] = None
    # Those of the survey that runs or ran last.
    job_parameters: Optional[SurveyParameters] = None
    figures: Optional[RobotFigures] = None
    defaults: Optional[RobotDefaults] = None
    health: HealthReport = field(default_factory=HealthReport)
    alarm: Optional[Alarm] = None
    master_alive: bool = True
    # What is done for maintenance, outside a survey.
    service: Optional[Message] = None
    # The last report of each axis that was heard.
    axes: Tuple[AxisReport, ...] = ()
    # What is shown is a replay, not a robot.
    replay: Optional[ReplayView] = None

    @property
    def running(self) -> bool:
        """Whether, by the last status, a survey exists that has not ended."""
        return self.state is not None and self.state.code in RUNNING

    @property
    def running_survey(self) -> str:
        """The id of the survey that has not ended; empty: there is none."""
        return self.state.survey_id if self.state is not None and self.running else ""

    @property
    def simulated(self) -> bool:
        """Whether the robot is simulated, or the survey that is replayed is of a simulated one."""
        if self.replay is not None and self.health.node(SIMULATOR) is not None:
            return True  # a recording of an earlier version may come without its status
        return self.state is not None and self.state.simulated

    @property
    def fields_locked(self) -> bool:
        """Whether the parameters are those of a survey in progress."""
        if self.replay is not None:
            return True
        return self.running or Request.START in self.pending

    @property
    def can_start(self) -> bool:
        """Whether START makes sense, if the parameters are right."""
        return self.control_alive and not self.fields_locked and self.service is None

    @property
    def moving(self) -> Tuple[AxisReport, ...]:
        """The axes that move by their last report, also if they are silent since."""
        return tuple(one for one in self.axes if one.moving)

    @property
    def paused(self) -> bool:
        """Whether the survey is paused."""
        return self.state is not None and self.state.code is SurveyState.PAUSED

    @property
    def can_pause(self) -> bool:
        """Whether a survey is measuring and no request is pending."""
        measuring = self.state is not None and self.state.code is SurveyState.SURVEYING
        return measuring and self.control_alive and not self.pending and self.replay is None

    @property
    def can_resume(self) -> bool:
        """Whether a survey is paused that can continue, and no request is pending."""
        if self.state is None or not self.state.message.can_continue:
            return False
        return self.paused and self.control_alive and not self.pending and self.replay is None


Value = TypeVar("Value")


class _Latest(Generic[Value]):
    """The last value of something that goes stale."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._value: Optional[Value] = None
        self._received_s = -math.inf

    def set(self, value: Value) -> None:
        self._value = value
        self._received_s = self._clock.now_s()

    def fresh(self) -> Optional[Value]:
        return self._value if self._clock.now_s() - self._received_s <= STALE_S else None


class SurveyModel:
    """Takes events, gives snapshots. Belongs to one thread."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._received_s: Optional[float] = None
        self._state: Optional[ControlState] = None
        self._progress: Optional[Progress] = None
        self._current: _Latest[CurrentPosition] = _Latest(clock)
        self._target: _Latest[TargetPosition] = _Latest(clock)
        self._height: _Latest[MeasuredHeight] = _Latest(clock)
        self._pending: Set[Request] = set()
        self._limits = AxisLimits(None)
        self._parameters: Optional[SurveyParameters] = None
        self._service: Optional[Message] = None
        self._axes: Dict[AxisId, AxisReport] = {}
        self._health = HealthTracker(clock)
        self._started_id = ""
        self._started_s = -math.inf
        self._interrupted = False
        self._outcome = RequestOutcome()

    def request_sent(self, request: Request) -> None:
        """Note that a request was sent to the main control and is not answered yet."""
        self._pending.add(request)
        self._outcome.asked(request)

    def handle(self, event: object) -> Optional[Refusal]:
        """Take an event; return the request that it shows to have failed."""
        if isinstance(event, (ControlState, Progress)):
            self._received_s = self._clock.now_s()
        if isinstance(event, ControlState):
            self._note_state(event)
            failed = self._outcome.failed_request(event)
            return None if failed is None else Refusal(failed, event.message)
        if isinstance(event, Answer):
            self._answered(event)
            # StopConfirmation says what became of a STOP.
            if event.success or event.request is Request.STOP:
                return None
            return Refusal(event.request, event.message, event.other_analyzer)
        self._note(event)
        return None

    def _note(self, event: object) -> None:
        if isinstance(event, Progress):
            self._progress = event
        elif isinstance(event, CurrentPosition):
            self._current.set(event)
        elif isinstance(event, TargetPosition):
            self._target.set(event)
        elif isinstance(event, MeasuredHeight):
            self._height.set(event)
        elif isinstance(event, AxisLimits):
            self._note_limits(event)
        elif isinstance(event, ControlParameters):
            self._parameters = event.parameters
        elif isinstance(event, ServiceActivity):
            self._service = event.activity
        elif isinstance(event, AxisMeasured):
            moving, now_s = event.position.moving, self._clock.now_s()
            self._axes[event.axis] = AxisReport(event.axis, moving, event.owner, now_s)
        elif isinstance(event, NodeHealth):
            self._health.note(event)

    def snapshot(self) -> Snapshot:
        """Return what is known now."""
        silent_s = None if self._received_s is None else self._clock.now_s() - self._received_s
        health = self._health.report()
        return Snapshot(
            control_alive=silent_s is not None and silent_s <= CONTROL_SILENCE_S,
            control_silent_s=silent_s,
            state=self._state,
            progress=self._progress,
            current=self._current.fresh(),
            target=self._known_target(),
            height_m=self._known_height_m(),
            pending=frozenset(self._pending | self._beginning()),
            travel=self._limits.travel,
            survey_parameters=self._parameters_in(RUNNING),
            job_parameters=self._parameters_in(RUNNING | ENDED),
            figures=self._limits.figures,
            defaults=self._limits.defaults,
            health=health,
            service=self._service,
            axes=tuple(self._axes.values()),
            master_alive=self._limits.master_alive,
            alarm=self._worst_alarm(silent_s, health),
        )

    def _worst_alarm(self, silent_s: Optional[float], health: HealthReport) -> Optional[Alarm]:
        """Return the alarm that explains the others; None if all is well."""
        if not self._limits.master_alive:
            return Alarm(AlarmKind.MASTER_GONE, silent_s or 0.0)
        if silent_s is None:
            return Alarm(AlarmKind.NO_CONTROL)
        if silent_s > CONTROL_SILENCE_S:
            return Alarm(AlarmKind.CONTROL_LOST, silent_s)
        if self._interrupted:
            return Alarm(AlarmKind.SURVEY_INTERRUPTED)
        if health.analyzer_fault is not None:
            return Alarm(AlarmKind.ANALYZER_FAULT, reason=health.analyzer_fault)
        return None

    def _note_state(self, state: ControlState) -> None:
        if state.code in RUNNING:
            self._interrupted = False
        elif self._state is not None and self._state.code in RUNNING and state.code not in ENDED:
            # No survey leads back to IDLE: the main control was restarted and has none.
            self._interrupted = True
        self._state = state

    def _note_limits(self, limits: AxisLimits) -> None:
        # What was known remains true while the master is away.
        self._limits = limits if limits.master_alive else replace(self._limits, master_alive=False)

    def _parameters_in(self, codes: FrozenSet[SurveyState]) -> Optional[SurveyParameters]:
        return self._parameters if self._state and self._state.code in codes else None

    def _answered(self, answer: Answer) -> None:
        self._pending.discard(answer.request)
        self._outcome.answered(answer)
        if answer.request is Request.START and answer.success:
            self._started_id = answer.survey_id
            self._started_s = self._clock.now_s()

    def _beginning(self) -> Set[Request]:
        # The answer to START may come before the first status of its survey: START stays
        # locked until then, but not without a limit.
        recent = self._clock.now_s() - self._started_s <= CONTROL_SILENCE_S
        known = self._state is not None and self._state.survey_id == self._started_id
        return {Request.START} if recent and not known else set()

    def _known_target(self) -> Optional[TargetPosition]:
        target = self._target.fresh()
        return None if target is None or target.is_none else target

    def _known_height_m(self) -> Optional[float]:
        height = self._height.fresh()
        return height.height_m if height is not None and math.isfinite(height.height_m) else None

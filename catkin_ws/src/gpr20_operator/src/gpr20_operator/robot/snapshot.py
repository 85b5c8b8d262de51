"""What is known of the robot and its survey at one moment, as events tell it."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, replace
from typing import Any, Dict, FrozenSet, Optional, Set, Tuple, Type, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import HealthReport, HealthTracker, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.events import (
    Answer,
    Configured,
    ControlState,
    CurrentPosition,
    MasterAnswered,
    Progress,
    Replay,
    Request,
    RobotDescribed,
    ServiceActivity,
    TargetPosition,
)
from gpr20_operator.words import size_text
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

# The main control publishes at 2 Hz; over a link that loses packets, it may be late by seconds.
CONTROL_SILENCE_S = 5.0
# A coordinate that is older than this [s] is not shown.
STALE_S = 3.0


@dataclass(frozen=True)
class Snapshot:
    """What a client shows; None: not known now."""

    control_alive: bool
    control_silent_s: Optional[float] = None
    state: Optional[ControlState] = None
    progress: Optional[Progress] = None
    current: Optional[CurrentPosition] = None
    target: Optional[TargetPosition] = None
    pending: FrozenSet[Request] = frozenset()
    robot: Optional[Configured] = None
    # The parameters of the survey that runs or ran last, whoever started it.
    job_parameters: Optional[SurveyParameters] = None
    health: HealthReport = field(default_factory=HealthReport)
    master_alive: bool = True
    # A survey ran, and the main control does not know it any more.
    interrupted: bool = False
    # How long ago the state changed [s].
    state_s: float = math.inf
    # For how long no axis moved, no trace was counted and the state stayed the same [s].
    still_s: float = 0.0
    # What is done for maintenance, outside a survey.
    service: Optional[Message] = None
    # The last report of each axis that was heard.
    axes: Tuple[AxisReport, ...] = ()
    # What is shown was recorded; None: there is a robot.
    replay: Optional[Replay] = None

    @property
    def code(self) -> Optional[SurveyState]:
        """The last state of the main control."""
        return None if self.state is None else self.state.code

    @property
    def running(self) -> bool:
        """Whether, by the last status, a survey exists that has not ended."""
        return self.code is not None and self.code.running

    @property
    def running_survey(self) -> str:
        """The id of the survey that has not ended; empty: there is none."""
        return self.state.survey_id if self.state is not None and self.running else ""

    @property
    def simulated(self) -> bool:
        """Whether the robot is simulated, or the survey that is replayed is of a simulated one."""
        return self.state is not None and self.state.simulated

    @property
    def fields_locked(self) -> bool:
        """Whether the parameters are those of a survey in progress."""
        return self.replay is not None or self.running or Request.START in self.pending

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
        return self.code is SurveyState.PAUSED

    @property
    def can_pause(self) -> bool:
        """Whether a survey is measuring and no request is pending."""
        return self.code is SurveyState.SURVEYING and self._takes_requests

    @property
    def can_resume(self) -> bool:
        """Whether a survey is paused that can continue, and no request is pending."""
        if self.state is None or not self.state.message.can_continue:
            return False
        return self.paused and self._takes_requests

    @property
    def _takes_requests(self) -> bool:
        return self.control_alive and not self.pending and not self.replay


def percent_of(snapshot: Snapshot) -> Optional[int]:
    """Return how much is stored, rounded down; None: there is no survey, or it is not known."""
    progress = progress_of(snapshot)
    return None if progress is None else math.floor(progress.completion_percent)


def progress_of(snapshot: Snapshot) -> Optional[Progress]:
    """Return how far the survey of the state is; None: there is no survey, or it is not known."""
    state, progress = snapshot.state, snapshot.progress
    if state is None or progress is None or not progress.total_points:
        return None
    if progress.survey_id != state.survey_id:
        return None
    return progress if snapshot.running or state.shown in ENDED else None


def line_of(snapshot: Snapshot) -> Optional[Message]:
    """Return the line of the area that is measured, and how many there are; None: none is."""
    parameters, target = snapshot.job_parameters, snapshot.target
    if parameters is None or target is None or not snapshot.running:
        return None
    span_mm = parameters.y_stop_mm - parameters.y_start_mm
    part = 0.0 if span_mm == 0.0 else (target.y_mm - parameters.y_start_mm) / span_mm
    line = min(max(round(part * (parameters.y_points - 1)), 0), parameters.y_points - 1)
    return Message("line {number} of {count}", number=line + 1, count=parameters.y_points)


def area_of(parameters: SurveyParameters) -> Message:
    """Return the size of a survey's area."""
    p = parameters
    return size_text(abs(p.x_stop_mm - p.x_start_mm), abs(p.y_stop_mm - p.y_start_mm))


def survey_name(description: str) -> Tuple[str, str]:
    """Return id, and name or site, of a survey.json; empty what it does not have."""
    try:
        values = json.loads(description)
        annotation = values.get("annotation") or {}
        name = annotation.get("name") or annotation.get("site") or ""
        return str(values.get("survey_id", "")), str(name)
    except (ValueError, AttributeError):
        # Who reads the plan from the same text reports what is wrong with it.
        return "", ""


Event = TypeVar("Event")
# Events of which the last one is known.
_KEPT = (
    *(ControlState, Progress, CurrentPosition, TargetPosition),
    *(MasterAnswered, RobotDescribed, SurveyParameters, ServiceActivity),
)


class SurveyModel:
    """Takes events, gives snapshots. Belongs to one thread.

    Args:
        clock: Says how old everything is.
        replay: Whether a recording is played: it says nothing of the health of nodes.
    """

    def __init__(self, clock: Clock, replay: bool = False) -> None:
        self._clock, self._replay = clock, Replay() if replay else None
        # When the main control was heard, the state changed and something went on [s].
        self._received_s: Optional[float] = None
        self._changed_s = self._progressed_s = clock.now_s()
        # The last event of each kind, and when it came [s].
        self._latest: Dict[type, Tuple[Any, float]] = {}
        self._axes: Dict[AxisId, AxisReport] = {}
        self._health = None if replay else HealthTracker(clock)
        self._pending: Set[Request] = set()
        self._started_id, self._started_s = "", -math.inf
        self._interrupted = False

    def request_sent(self, request: Request) -> None:
        """Note that a request was sent to the main control and is not answered yet."""
        self._pending.add(request)

    def set_followed(self, followed: bool) -> None:
        """Note whether axes and health are followed from now on: what was known of them is old."""
        if followed != (self._health is not None):
            self._health = HealthTracker(self._clock) if followed else None
            self._axes.clear()

    def handle(self, event: object) -> Optional[Answer]:
        """Take an event; return the answer to a request that was refused or failed."""
        now_s = self._clock.now_s()
        if isinstance(event, Answer):
            return self._take_answer(event, now_s)
        if isinstance(event, AxisReport):
            if event.moving:
                self._progressed_s = now_s
            self._axes[event.axis] = replace(event, received_s=now_s)
        elif isinstance(event, NodeHealth) and self._health is not None:
            self._health.note(event)
        elif isinstance(event, Replay):
            self._replay = self._replay and event
        elif isinstance(event, _KEPT):
            if isinstance(event, (ControlState, Progress)):
                self._received_s = now_s
                self._note_course(event, now_s)
            self._latest[type(event)] = event, now_s
        return None

    def _take_answer(self, answer: Answer, now_s: float) -> Optional[Answer]:
        self._pending.discard(answer.request)
        if answer.request is Request.START and answer.success:
            self._started_id, self._started_s = answer.survey_id, now_s
        # StopConfirmation says what became of a STOP.
        return None if answer.success or answer.request is Request.STOP else answer

    def _note_course(self, event: Any, now_s: float) -> None:
        """Note when the survey went on last, and whether it was interrupted."""
        former = self._last(type(event))
        if isinstance(event, Progress):
            if former is None or event.visited_points != former.visited_points:
                self._progressed_s = now_s
            return
        before = None if former is None else former.code
        if event.code is not before:
            self._changed_s = self._progressed_s = now_s
        if event.code in RUNNING:
            self._interrupted = False
        elif before in RUNNING and event.shown not in ENDED:
            # No survey leads back to IDLE: the main control was restarted and has none.
            self._interrupted = True

    def state(self) -> Snapshot:
        """Return what is known now."""
        now_s = self._clock.now_s()
        silent_s = None if self._received_s is None else now_s - self._received_s
        state, parameters = self._last(ControlState), self._last(SurveyParameters)
        master, described = self._last(MasterAnswered), self._last(RobotDescribed)
        service = self._last(ServiceActivity)
        return Snapshot(
            control_alive=silent_s is not None and silent_s <= CONTROL_SILENCE_S,
            control_silent_s=silent_s,
            state=state,
            progress=self._last(Progress),
            current=self._last(CurrentPosition, STALE_S),
            target=self._last(TargetPosition, STALE_S),
            pending=frozenset(self._pending | self._beginning(state)),
            robot=described.robot if described else None,
            job_parameters=parameters if state and state.code in RUNNING | ENDED else None,
            health=HealthReport() if self._health is None else self._health.report(),
            master_alive=master is None or master.alive,
            interrupted=self._interrupted,
            state_s=now_s - self._changed_s,
            still_s=now_s - self._progressed_s,
            service=service.activity if service else None,
            replay=self._replay,
            axes=tuple(
                replace(one, silent=now_s - one.received_s > STALE_S) for one in self._axes.values()
            ),
        )

    def _beginning(self, state: Optional[ControlState]) -> Set[Request]:
        # The answer to START may come before the first status of its survey: START stays
        # locked until then, but not without a limit.
        recent = self._clock.now_s() - self._started_s <= CONTROL_SILENCE_S
        known = state is not None and state.survey_id == self._started_id
        return {Request.START} if recent and not known else set()

    def _last(self, kind: Type[Event], age_s: float = math.inf) -> Optional[Event]:
        """Return the last event of a kind; None if it is older [s], or there was none."""
        event, received_s = self._latest.get(kind, (None, -math.inf))
        return event if self._clock.now_s() - received_s <= age_s else None

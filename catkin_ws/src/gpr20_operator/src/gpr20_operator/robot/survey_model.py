"""The robot and its survey as events tell them: what is known and what may be pressed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import singledispatchmethod
from typing import Any, Dict, FrozenSet, Optional, Set, Tuple, Type, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, HealthTracker, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.events import (
    Answer,
    ControlState,
    CurrentPosition,
    MasterAnswered,
    MeasuredHeight,
    PlayerLink,
    Progress,
    Replay,
    Request,
    RobotDescribed,
    SenderIgnored,
    ServiceActivity,
    TargetPosition,
)
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, STALE_S, Snapshot
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_state import ENDED, RUNNING, SurveyState

BEGINNING = (SurveyState.CHECKING, SurveyState.HOMING)
NOT_BEGUN = (SurveyState.FAILED, SurveyState.PAUSED)
NOT_FOLLOWED = HealthReport(settled=False)


@dataclass(frozen=True)
class Refusal:
    """A request that was refused or failed, and why.

    Attributes:
        other_analyzer: Identity of another analyzer with which the survey can be resumed; empty
            if the operator has nothing to accept.
    """

    request: Request
    reason: Message
    other_analyzer: str = ""


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


Event = TypeVar("Event")


class SurveyModel:
    """Takes events, gives snapshots. Belongs to one thread."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._received_s: Optional[float] = None
        self._changed_s = self._progressed_s = clock.now_s()
        self._state: Optional[ControlState] = None
        self._progress: Optional[Progress] = None
        # What goes stale, and when it came [s].
        self._latest: Dict[type, Tuple[Any, float]] = {}
        self._pending: Set[Request] = set()
        self._master_alive = True
        self._described = RobotDescribed()
        self._parameters: Optional[SurveyParameters] = None
        self._service: Optional[Message] = None
        self._axes: Dict[AxisId, AxisReport] = {}
        self._health: Optional[HealthTracker] = HealthTracker(clock)
        self._started_id = ""
        self._started_s = -math.inf
        self._interrupted = False
        self._outcome = RequestOutcome()

    def request_sent(self, request: Request) -> None:
        """Note that a request was sent to the main control and is not answered yet."""
        self._pending.add(request)
        self._outcome.asked(request)

    def set_followed(self, followed: bool) -> None:
        """Note whether axes and health are followed from now on: what was known of them is old."""
        if followed != (self._health is not None):
            self._health = HealthTracker(self._clock) if followed else None
            self._axes.clear()

    @singledispatchmethod
    def handle(self, _event: object) -> Optional[Refusal]:
        """Take an event; return the request that it shows to have failed."""
        return None

    @handle.register
    def _(self, event: ControlState) -> Optional[Refusal]:
        now_s = self._received_s = self._clock.now_s()
        before = None if self._state is None else self._state.code
        if event.code is not before:
            self._changed_s = self._progressed_s = now_s
        if event.code in RUNNING:
            self._interrupted = False
        elif before in RUNNING and event.shown not in ENDED:
            # No survey leads back to IDLE: the main control was restarted and has none.
            self._interrupted = True
        self._state = event
        failed = self._outcome.failed_request(event)
        return None if failed is None else Refusal(failed, event.message)

    @handle.register
    def _(self, event: Answer) -> Optional[Refusal]:
        self._pending.discard(event.request)
        self._outcome.answered(event)
        if event.request is Request.START and event.success:
            self._started_id = event.survey_id
            self._started_s = self._clock.now_s()
        # StopConfirmation says what became of a STOP.
        if event.success or event.request is Request.STOP:
            return None
        return Refusal(event.request, event.message, event.other_analyzer)

    @handle.register
    def _(self, event: Progress) -> None:
        now_s = self._received_s = self._clock.now_s()
        if self._progress is None or event.visited_points != self._progress.visited_points:
            self._progressed_s = now_s
        self._progress = event

    @handle.register(CurrentPosition)
    @handle.register(TargetPosition)
    @handle.register(MeasuredHeight)
    @handle.register(SenderIgnored)
    def _(self, event: object) -> None:
        self._latest[type(event)] = event, self._clock.now_s()

    @handle.register
    def _(self, event: MasterAnswered) -> None:
        self._master_alive = event.alive

    @handle.register
    def _(self, event: RobotDescribed) -> None:
        self._described = event

    @handle.register
    def _(self, event: SurveyParameters) -> None:
        self._parameters = event

    @handle.register
    def _(self, event: ServiceActivity) -> None:
        self._service = event.activity

    @handle.register
    def _(self, event: AxisReport) -> None:
        now_s = self._clock.now_s()
        if event.moving:
            self._progressed_s = now_s
        self._axes[event.axis] = replace(event, received_s=now_s)

    @handle.register
    def _(self, event: NodeHealth) -> None:
        if self._health is not None:
            self._health.note(event)

    def snapshot(self) -> Snapshot:
        """Return what is known now."""
        now_s, ignored = self._clock.now_s(), self._fresh(SenderIgnored)
        silent_s = None if self._received_s is None else now_s - self._received_s
        return Snapshot(
            control_alive=silent_s is not None and silent_s <= CONTROL_SILENCE_S,
            control_silent_s=silent_s,
            state=self._state,
            progress=self._progress,
            current=self._fresh(CurrentPosition),
            target=self._known_target(),
            height_m=self._known_height_m(),
            pending=frozenset(self._pending | self._beginning()),
            robot=self._described.robot,
            survey_parameters=self._parameters_in(RUNNING),
            job_parameters=self._parameters_in(RUNNING | ENDED),
            health=NOT_FOLLOWED if self._health is None else self._health.report(),
            master_alive=self._master_alive,
            interrupted=self._interrupted,
            state_s=now_s - self._changed_s,
            still_s=now_s - self._progressed_s,
            service=self._service,
            ignored_sender="" if ignored is None else ignored.sender,
            axes=tuple(
                replace(one, silent=now_s - one.received_s > STALE_S) for one in self._axes.values()
            ),
        )

    def _parameters_in(self, codes: FrozenSet[SurveyState]) -> Optional[SurveyParameters]:
        return self._parameters if self._state and self._state.code in codes else None

    def _beginning(self) -> Set[Request]:
        # The answer to START may come before the first status of its survey: START stays
        # locked until then, but not without a limit.
        recent = self._clock.now_s() - self._started_s <= CONTROL_SILENCE_S
        known = self._state is not None and self._state.survey_id == self._started_id
        return {Request.START} if recent and not known else set()

    def _fresh(self, kind: Type[Event]) -> Optional[Event]:
        """Return the last event of a kind; None if it is too old, or there was none."""
        event, received_s = self._latest.get(kind, (None, -math.inf))
        return event if self._clock.now_s() - received_s <= STALE_S else None

    def _known_target(self) -> Optional[TargetPosition]:
        target = self._fresh(TargetPosition)
        return None if target is None or target.is_none else target

    def _known_height_m(self) -> Optional[float]:
        height = self._fresh(MeasuredHeight)
        return height.height_m if height is not None and math.isfinite(height.height_m) else None


class StoppedClock(Clock):
    """Time that does not pass: nothing that was recorded goes stale."""

    def now_s(self) -> float:
        """Return the only moment [s]."""
        return 0.0


class ReplayModel:
    """Takes what a player sends, gives snapshots of a replay. Belongs to one thread."""

    def __init__(self) -> None:
        self._survey_id = ""
        self._recorded = SurveyModel(StoppedClock())
        self._replay = Replay(connected=None)

    def request_sent(self, _request: Request) -> None:
        """Take no request: there is nobody to ask."""

    def handle(self, event: object) -> None:
        """Take an event; another survey begins another replay."""
        if isinstance(event, PlayerLink):
            self._replay = replace(self._replay, connected=event.connected)
            return
        if isinstance(event, (Replay, ControlState, Progress)):
            self._note_survey(event.survey_id)
        if isinstance(event, Replay):
            self._replay = replace(event, connected=self._replay.connected)
        self._recorded.handle(event)

    def snapshot(self) -> Snapshot:
        """Return what is known now."""
        shown = self._recorded.snapshot()
        # Nodes that the recording says nothing about are not offline.
        nodes = tuple(node for node in shown.health.nodes if node.level is not HealthLevel.STALE)
        view = replace(self._replay, state=shown.code)
        return replace(shown, replay=view, health=HealthReport(nodes))

    def _note_survey(self, survey_id: str) -> None:
        # What was in flight when the player ended does not begin its replay again.
        connected = self._replay.connected is not False
        if survey_id and self._survey_id not in ("", survey_id):
            self._recorded, self._replay = SurveyModel(StoppedClock()), Replay()
            connected = True
        self._survey_id = survey_id or self._survey_id
        self._replay = replace(self._replay, connected=connected)

"""The robot and its survey as events tell them: what is known and what may be pressed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Dict, Optional, Set, Tuple, Type, TypeVar

from gpr20_common.low.clock import Clock
from gpr20_doctor.mid.node_health import HealthReport, HealthTracker, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.events import (
    Answer,
    ControlState,
    CurrentPosition,
    MasterAnswered,
    MeasuredHeight,
    Progress,
    Replay,
    Request,
    RobotDescribed,
    ServiceActivity,
    TargetPosition,
)
from gpr20_operator.robot.snapshot import CONTROL_SILENCE_S, STALE_S, Snapshot
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_state import ENDED, RUNNING

Event = TypeVar("Event")
# Events of which the last one is known.
_KEPT = (
    *(ControlState, Progress, CurrentPosition, TargetPosition, MeasuredHeight),
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

    def snapshot(self) -> Snapshot:
        """Return what is known now."""
        now_s = self._clock.now_s()
        silent_s = None if self._received_s is None else now_s - self._received_s
        state, parameters = self._last(ControlState), self._last(SurveyParameters)
        master, described = self._last(MasterAnswered), self._last(RobotDescribed)
        service, height = self._last(ServiceActivity), self._last(MeasuredHeight, STALE_S)
        return Snapshot(
            control_alive=silent_s is not None and silent_s <= CONTROL_SILENCE_S,
            control_silent_s=silent_s,
            state=state,
            progress=self._last(Progress),
            current=self._last(CurrentPosition, STALE_S),
            target=self._last(TargetPosition, STALE_S),
            height_m=height.height_m if height and math.isfinite(height.height_m) else None,
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

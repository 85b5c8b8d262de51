"""Whether a STOP is confirmed; until then the operator may have to switch off the motors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import singledispatchmethod
from typing import Dict, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_operator.robot.notices import Notice, stop_notice
from gpr20_operator.robot.snapshot import STALE_S, Snapshot
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import ENDED, SurveyState

# An axis that works answers sooner [s].
ANSWER_S = 0.2
# From its top speed an axis comes to rest in 0.3 s, and reports it 10 times a second [s].
REST_S = 1.0
# A stop request ends every motion within this time [s]; as in the main control.
EFFECT_S = 0.2


@dataclass(frozen=True)
class StopWarning:
    """What is shown over everything until a STOP is confirmed."""

    title: Message
    text: Message


class StopConfirmation:
    """Follows a STOP from the press until each axis has said that it rests.

    Belongs to one thread. An answer proves only that the request has arrived: an axis rests when
    it reports so itself, after the press.

    Attributes:
        outcome: What the operator should read about a STOP after which everything rests; None:
            nothing. Who shows it clears it.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._pressed_s: Optional[float] = None
        self._state_at_press: Optional[SurveyState] = None
        # Whether an axis was silent before the press: nobody need wait to say so.
        self._silent = False
        self._axes: Dict[AxisId, bool] = {}
        self._control: Optional[Answer] = None
        self._answered_s = 0.0
        self.outcome: Optional[Notice] = None

    @property
    def is_open(self) -> bool:
        """Whether a STOP is not confirmed yet."""
        return self._pressed_s is not None

    def press(self, snapshot: Snapshot) -> None:
        """Note that STOP was pressed."""
        now_s = self._pressed_s = self._clock.now_s()
        self._state_at_press = None if snapshot.state is None else snapshot.state.code
        heard = [one.axis for one in snapshot.axes if now_s - one.received_s <= STALE_S]
        self._silent = len(heard) < len(AxisId)
        self._axes, self._control, self.outcome = {}, None, None

    @singledispatchmethod
    def on_event(self, _event: object) -> None:
        """Take an event; most are about something else."""

    @on_event.register
    def _(self, event: AxisStopAnswer) -> None:
        self._axes[event.axis] = event.answered
        self._answered_s = self._clock.now_s()

    @on_event.register
    def _(self, event: Answer) -> None:
        if event.request is Request.STOP:
            self._control = event
            self._answered_s = self._clock.now_s()

    def close(self) -> None:
        """Note that the operator has read the warning, or that it is over."""
        self._pressed_s = None

    def warning(self, snapshot: Snapshot) -> Optional[StopWarning]:
        """Return what is shown now; None: STOP was not pressed, or every axis rests."""
        if self._pressed_s is None:
            return None
        reports = {one.axis: one for one in snapshot.axes}
        if self._is_said_by_control(snapshot) or self._is_over(reports):
            self.close()
            return None
        if not any(self._is_late(axis, reports.get(axis)) for axis in AxisId):
            return None
        return StopWarning(Message("SWITCH OFF THE MOTORS' POWER"), self._known(reports))

    def _is_late(self, axis: AxisId, report: Optional[AxisReport]) -> bool:
        """Return whether an axis should have said by now that it rests."""
        assert self._pressed_s is not None
        if self._rests(report, self._pressed_s):
            return False
        limit_s = REST_S if self._axes.get(axis) else ANSWER_S
        return self._silent or self._clock.now_s() - self._pressed_s >= limit_s

    def _is_over(self, reports: Dict[AxisId, AxisReport]) -> bool:
        """Return whether all have answered, and no axis has moved after that."""
        control = self._control
        if control is None or len(self._axes) < len(AxisId):
            return False
        # A main control that was slow may have begun another move before it answered.
        since_s = self._answered_s + EFFECT_S
        if not all(self._rests(reports.get(axis), since_s) for axis in AxisId):
            return False
        if not control.success:
            self.outcome = stop_notice(control, self._known(reports))
        return True

    def _is_said_by_control(self, snapshot: Snapshot) -> bool:
        """Return whether the main control has seen every axis rest."""
        state = snapshot.state
        if state is None or not snapshot.control_alive or state.code is self._state_at_press:
            return False
        reported = any(one.moving for one in snapshot.axes)
        return state.code in ENDED and not state.axis_may_move and not reported

    @staticmethod
    def _rests(report: Optional[AxisReport], since_s: float) -> bool:
        return report is not None and not report.moving and report.received_s > since_s

    def _known(self, reports: Dict[AxisId, AxisReport]) -> Message:
        axes = [self._state_of(axis, reports.get(axis)) for axis in AxisId]
        return in_a_row([*axes, self._state_of_control()])

    def _state_of_control(self) -> Message:
        if self._control is None:
            return Message("main control: no answer yet")
        if not self._control.contact:
            return Message("main control does NOT answer")
        return Message("main control: {answer}", answer=self._control.message)

    def _state_of(self, axis: AxisId, report: Optional[AxisReport]) -> Message:
        if self._pressed_s is not None and self._rests(report, self._pressed_s):
            return Message("{axis} axis: at rest", axis=axis.value)
        answered = self._axes.get(axis)
        if answered is False:
            return Message("{axis} axis does NOT answer", axis=axis.value)
        if report is not None and report.moving:
            return Message("{axis} axis: MOVES", axis=axis.value)
        if answered:
            return Message("{axis} axis: stopping", axis=axis.value)
        return Message("{axis} axis: no answer yet", axis=axis.value)

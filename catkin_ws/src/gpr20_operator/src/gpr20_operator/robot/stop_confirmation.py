"""Whether a STOP is confirmed; until then the operator may have to switch off the motors."""

from __future__ import annotations

from typing import Dict, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request
from gpr20_operator.robot.notices import Notice, stop_notice
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes.axis_id import AxisId

# An axis that works answers sooner [s].
ANSWER_S = 0.2
# From its top speed an axis comes to rest in 0.3 s, and reports it 10 times a second [s].
REST_S = 1.0
# A stop request ends every motion within this time [s]; as in the main control.
EFFECT_S = 0.2
# Shown over everything until a STOP is confirmed.
MOTORS_OFF = Message("SWITCH OFF THE MOTORS' POWER")


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
        self._axes: Dict[AxisId, bool] = {}
        self._control: Optional[Answer] = None
        self._answered_s = 0.0
        self.outcome: Optional[Notice] = None

    @property
    def is_open(self) -> bool:
        """Whether a STOP is not confirmed yet."""
        return self._pressed_s is not None

    def press(self) -> None:
        """Note that STOP was pressed."""
        self._pressed_s = self._clock.now_s()
        self._axes, self._control, self.outcome = {}, None, None

    def on_event(self, event: object) -> None:
        """Take an answer; other events are about something else."""
        if isinstance(event, AxisStopAnswer):
            self._axes[event.axis] = event.answered
        elif isinstance(event, Answer) and event.request is Request.STOP:
            self._control = event
        else:
            return
        self._answered_s = self._clock.now_s()

    def close(self) -> None:
        """Note that the operator has read the warning, or that it is over."""
        self._pressed_s = None

    def warning(self, snapshot: Snapshot) -> Optional[Message]:
        """Return what is known while the motors have to be switched off.

        None: STOP was not pressed, every axis rests, or none is late yet.
        """
        if self._pressed_s is None:
            return None
        reports = {one.axis: one for one in snapshot.axes}
        known = in_a_row(
            [*(self._state_of(axis, reports.get(axis)) for axis in AxisId), self._of_control()]
        )
        control = self._control
        # A main control that was slow may have begun another move before it answered.
        over = len(self._axes) == len(AxisId) and all(
            _rests(reports.get(axis), self._answered_s + EFFECT_S) for axis in AxisId
        )
        if control is not None and over:
            self.close()
            if not control.success:
                self.outcome = stop_notice(control, known)
            return None
        if not any(self._is_late(axis, reports.get(axis), self._pressed_s) for axis in AxisId):
            return None
        return known

    def _is_late(self, axis: AxisId, report: Optional[AxisReport], pressed_s: float) -> bool:
        """Return whether an axis should have said by now that it rests."""
        if _rests(report, pressed_s):
            return False
        limit_s = REST_S if self._axes.get(axis) else ANSWER_S
        # Nobody need wait to say that it was silent before the press.
        silent = report is None or report.silent
        return silent or self._clock.now_s() - pressed_s >= limit_s

    def _of_control(self) -> Message:
        if self._control is None:
            return Message("main control: no answer yet")
        if not self._control.contact:
            return Message("main control does NOT answer")
        return Message("main control: {answer}", answer=self._control.message)

    def _state_of(self, axis: AxisId, report: Optional[AxisReport]) -> Message:
        if self._pressed_s is not None and _rests(report, self._pressed_s):
            return Message("{axis} axis: at rest", axis=axis.value)
        answered = self._axes.get(axis)
        if answered is False:
            return Message("{axis} axis does NOT answer", axis=axis.value)
        if report is not None and report.moving:
            return Message("{axis} axis: MOVES", axis=axis.value)
        if answered:
            return Message("{axis} axis: stopping", axis=axis.value)
        return Message("{axis} axis: no answer yet", axis=axis.value)


def _rests(report: Optional[AxisReport], since_s: float) -> bool:
    return report is not None and not report.moving and report.received_s > since_s

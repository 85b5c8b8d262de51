"""What the dialogs say: what happened, what to do next, and whether a STOP is confirmed."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Dict, List, Optional, Set, Tuple

from gpr20_common.faults import LOOK
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import printable
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth, node_title
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.robot.condition import Condition, condition_of, first_step, lost, urgent
from gpr20_operator.robot.events import Answer, AxisStopAnswer, ControlState, Request
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import SurveyState


@dataclass(frozen=True)
class Notice:
    """The texts of a dialog; the details are technical lines that are not translated."""

    title: Message
    text: Message
    first: Optional[Message] = None
    then: Optional[Message] = None
    details: Tuple[str, ...] = ()
    resumable: bool = False


class Refused(enum.Enum):
    """What did not succeed, and what to do when its cause is gone."""

    START = Message("The survey was not started."), Message("Then start the survey again.")
    PAUSE = (
        Message("The survey was not paused."),
        Message("STOP ends the survey at once; it can be resumed later."),
    )
    RESUME = Message("The survey was not resumed."), Message("Then resume the survey again.")
    NOTES = (
        Message("The notes of the survey cannot be read or stored."),
        Message("Then press SAVE again."),
    )
    PLAN = (
        Message("The values of the last survey are not remembered."),
        Message("Next: check all values on SURVEY before START."),
    )
    MARKER = (
        Message("The markers of the survey were not changed."),
        Message("Next: remove the cause, then set or remove the marker again."),
    )
    FINER = (
        Message("This place cannot be measured more finely."),
        Message("Next: choose another place."),
    )


_FAULTS = {
    SurveyState.PAUSED: Message("The survey is PAUSED by a fault."),
    SurveyState.FAILED: Message("The survey has FAILED."),
    SurveyState.STOPPED: Message("The survey was stopped, with a fault."),
}
_RESUME_NEXT = Message("Then press RESUME. STOP ends the survey; what is stored is kept.")
_STOP_NEXT = Message("Then press STOP: it ends the survey; what is stored is kept.")
_START_NEXT = Message("Then start the survey again, or resume it in SURVEYS.")


def refusal_notice(refused: Refused, reason: Message) -> Notice:
    """Return what a dialog says about something that did not succeed."""
    title, then = refused.value
    final = refused is Refused.RESUME and not reason.can_continue
    return Notice(title, reason, remedy(reason), None if final else then, _details(reason))


def stop_notice(answer: Answer, known: Message) -> Notice:
    """Return what a dialog says after a STOP that stopped no survey; every axis rests."""
    if answer.contact:
        return Notice(Message("Every axis rests."), known, details=_details(answer.message))
    return Notice(
        Message("Every axis rests. The main control does not answer."),
        known,
        remedy(answer.message),
        Message("If the robot moves, press STOP again or switch off the motors' power."),
        _details(answer.message),
    )


def fault_notice(state: ControlState) -> Notice:
    """Return the card of a fault that paused or ended a survey."""
    reason, paused = state.reason, state.code is SurveyState.PAUSED
    resumable, then = paused and state.message.can_continue, None
    if state.message.can_continue:
        then = _RESUME_NEXT if paused else _START_NEXT
    elif paused:
        then = _STOP_NEXT
    details = _details(reason)
    return Notice(_FAULTS[state.code], reason, remedy(reason), then, details, resumable)


def remedy(reason: Message) -> Message:
    """Return what to do first about a fault, whatever it is."""
    return first_step(reason) or LOOK


def band_notice(snapshot: Snapshot) -> Notice:
    """Return all that the band says, and what to do first."""
    state = snapshot.state
    if urgent(snapshot) is None and state is not None and state.is_fault:
        return fault_notice(state)
    return _notice_of(condition_of(snapshot))


def _notice_of(shown: Condition) -> Notice:
    return Notice(shown.title, shown.message, shown.remedy, details=_details(shown.message))


class CardWatch:
    """Returns the card of each fault once, and says for how long it is true."""

    def __init__(self) -> None:
        self._known: Set[object] = set()

    def note(self, snapshot: Snapshot) -> Optional[Notice]:
        """Take what is known now; return the card that a person must see, if it is new."""
        cards = self._cards(snapshot)
        new = [card for key, card in cards if key not in self._known]
        self._known = {key for key, _card in cards}
        return new[0] if new else None

    @property
    def is_over(self) -> bool:
        """Whether every fault is over."""
        return not self._known

    @staticmethod
    def _cards(snapshot: Snapshot) -> List[Tuple[object, Notice]]:
        """Return what must be seen at once, with what is the same while its numbers change."""
        if snapshot.replay:
            return []
        found: List[Tuple[object, Notice]] = []
        state = snapshot.state
        if state is not None and state.is_fault:
            # Without the warnings around it, which may come and go.
            reason = state.reason
            card, said = fault_notice(state), reason.fault_code or reason
            found.append(((state.code, state.survey_id, said, card.first), card))
        gone = lost(snapshot)
        if gone is not None and (snapshot.running or snapshot.interrupted or snapshot.moving):
            found.insert(0, (gone.message.fault_code, _notice_of(gone)))
        return found


def node_notice(node: NodeHealth) -> Notice:
    """Return everything that a node reports about itself."""
    silent = node.level is HealthLevel.STALE
    level = Message("OFFLINE") if silent else node.rating.title
    title = Message("{name}: {level}", name=node_title(node.name), level=level)
    first_of = {HealthLevel.WARN: first_step, HealthLevel.ERROR: remedy}.get(node.level)
    values = (f"{name}: {value}" for name, value in node.values.items())
    details = (*_details(node.message), f"node: {node.name}", *values)
    text = Message("no report") if silent else node.message
    return Notice(title, text, first_of and first_of(node.message), details=details)


def _details(message: Message) -> Tuple[str, ...]:
    """Return the code of the fault, which a person on the telephone can say, and the details."""
    found = (message.fault_code, *message.all_details)
    return tuple(printable(one) for one in found if one)


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
        """Note that STOP was pressed; again before it is confirmed, nothing is late later."""
        if self._pressed_s is None:
            self._pressed_s, self._axes = self._clock.now_s(), {}
        self._control = self.outcome = None

    def on_event(self, event: object) -> None:
        """Take an answer; other events are about something else."""
        if isinstance(event, AxisStopAnswer):
            is_first = not self._axes.get(event.axis)
            self._axes[event.axis] = event.answered
        elif isinstance(event, Answer) and event.request is Request.STOP:
            is_first = self._control is None or not self._control.contact
            self._control = event
        else:
            return
        if is_first:  # who has heard of it begins no other move
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

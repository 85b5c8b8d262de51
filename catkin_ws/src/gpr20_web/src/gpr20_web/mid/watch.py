"""Paused, fault, finished, no contact: each is news once, for who is not looking."""

from __future__ import annotations

import enum
from typing import Callable, FrozenSet, Hashable, Optional, Tuple

from gpr20_operator.robot.condition import condition_of, lost
from gpr20_operator.robot.events import ControlState
from gpr20_operator.robot.notices import fault_notice
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.low.notifier import News


class Occasion(enum.Enum):
    """What happened, as notices call it; the most urgent first."""

    NO_CONTACT = enum.auto()
    FAULT = enum.auto()
    PAUSED = enum.auto()
    FINISHED = enum.auto()


KINDS = {Occasion.PAUSED: "warning", Occasion.FINISHED: "success"}
# What happened, with what stays the same while its numbers change.
Key = Tuple[Occasion, Hashable]


class Watch:
    """Finds out what is new by the codes of snapshots.

    What was so before the first report is not new, except a fault. No notice says what was found
    in the ground: it passes through the networks of others.

    Args:
        send: Takes each notice; it does not wait.
    """

    def __init__(self, send: Callable[[News], None]) -> None:
        self._send = send
        self._known: Optional[FrozenSet[Key]] = None

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known now, and send what is new."""
        state = snapshot.state
        if state is None:
            return
        key = _key_of(snapshot, state)
        found = frozenset() if key is None else frozenset([key])
        is_first, known = self._known is None, self._known or frozenset()
        is_lost = key is not None and key[0] is Occasion.NO_CONTACT
        # What was so before the contact was lost is not new after it.
        self._known = found | known if is_lost else found
        if key is None or key in known or (is_first and key[0] is not Occasion.FAULT):
            return
        self._send(_news(key[0], snapshot, state))


def _news(occasion: Occasion, snapshot: Snapshot, state: ControlState) -> News:
    kind = KINDS.get(occasion, "failure")
    if occasion is Occasion.FAULT:
        card = fault_notice(state)
        return News(kind, card.title, card.text, card.first)
    shown = lost(snapshot) if occasion is Occasion.NO_CONTACT else None
    shown = shown or condition_of(snapshot)
    return News(kind, shown.title, shown.message, shown.remedy)


def _key_of(snapshot: Snapshot, state: ControlState) -> Optional[Key]:
    """Return what somebody must learn now, the most urgent; None: nothing."""
    # A robot that rests may be switched off.
    counts = snapshot.running or snapshot.interrupted or bool(snapshot.moving)
    if counts and lost(snapshot) is not None:
        return Occasion.NO_CONTACT, snapshot.interrupted
    if state.is_fault:
        reason = (state.code, state.survey_id, state.reason.fault_code, fault_notice(state).first)
        return Occasion.FAULT, reason
    if state.code is SurveyState.PAUSED:
        return Occasion.PAUSED, state.survey_id
    if state.shown is SurveyState.FINISHED:
        return Occasion.FINISHED, state.survey_id
    return None

"""Paused, fault, finished, no contact: each is news once, for who is not looking."""

from __future__ import annotations

from typing import Any, Callable, FrozenSet, Hashable, Mapping, Optional, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.condition import condition_of, lost
from gpr20_operator.robot.events import ControlState
from gpr20_operator.robot.notices import fault_notice
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.low.notifier import News, Occasion
from gpr20_web.mid.now_page import sentence
from gpr20_web.mid.web_page import WebPage

# What happened, with what stays the same while its numbers change.
Key = Tuple[Occasion, Hashable]


class Watch(WebPage):
    """Finds out what is new by the codes of snapshots.

    What was so before the first report is not new, except a fault. No notice says what was found
    in the ground: it passes through the networks of others.

    Args:
        send: Takes each notice for those who have no page open; it does not wait.
    """

    words: Mapping[str, Message] = {
        "allow": Message("Notify me on this device"),
        "allowed": Message("This device notifies you."),
        "denied": Message("This browser does not allow notifications."),
    }

    def __init__(self, clock: Clock, send: Callable[[News], None]) -> None:
        self._clock, self._send = clock, send
        self._known: Optional[FrozenSet[Key]] = None
        self._last: Optional[News] = None
        self._last_key: Optional[Key] = None

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known now, and send what is new."""
        state = snapshot.state
        if snapshot.replay is not None or state is None:
            return
        key = _key_of(snapshot, state)
        found = frozenset() if key is None else frozenset([key])
        is_first, known = self._known is None, self._known or frozenset()
        is_lost = key is not None and key[0] is Occasion.NO_CONTACT
        # What was so before the contact was lost is not new after it.
        self._known = found | known if is_lost else found
        if key != self._last_key:
            self._last = None  # it is over: who opens the page later need not learn it
        if key is None or key in known or (is_first and key[0] is not Occasion.FAULT):
            return
        self._last, self._last_key = self._news(key[0], snapshot, state), key
        self._send(self._last)

    def live(self, text: Callable[[Message], str]) -> Mapping[str, Any]:
        """Return the last notice, as long as it is true."""
        news = self._last
        if news is None:
            return {"notice": None}
        return {
            "notice": {
                "id": news.number,
                "title": sentence(text, news.title),
                "text": sentence(text, news.text),
                "remedy": sentence(text, news.remedy),
            }
        }

    def _news(self, occasion: Occasion, snapshot: Snapshot, state: ControlState) -> News:
        number = self._clock.time_of_day_us()
        if occasion is Occasion.FAULT:
            card = fault_notice(state)
            return News(number, occasion, card.title, card.text, card.first)
        shown = lost(snapshot) if occasion is Occasion.NO_CONTACT else None
        shown = shown or condition_of(snapshot)
        return News(number, occasion, shown.title, shown.message, shown.remedy)


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

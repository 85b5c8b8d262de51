"""Paused, fault, finished, no contact: each is news once, for who is not looking."""

from __future__ import annotations

from typing import Any, Callable, Dict, Hashable, Mapping, Optional, Set, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.condition import condition_of, lost
from gpr20_operator.robot.notices import fault_notice
from gpr20_operator.robot.snapshot import Snapshot, percent_of
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.low.notifier import News, Occasion
from gpr20_web.mid.now_page import sentence
from gpr20_web.mid.web_page import WebPage

Key = Tuple[Hashable, ...]


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
        self._known: Optional[Set[Key]] = None
        self._last: Optional[News] = None
        self._last_key: Key = ()

    def refresh(self, snapshot: Snapshot) -> None:
        """Take what is known now; give at most one notice, the others with the next snapshots."""
        if snapshot.replay is not None or snapshot.state is None:
            return
        found = _found(snapshot)
        if self._known is None:
            self._known = {key for key, one in found.items() if one is not Occasion.FAULT}
        self._known &= set(found)
        if self._last_key not in found:
            self._last = None  # it is over: who opens the page later need not learn it
        for key, occasion in found.items():
            if key not in self._known:
                self._known.add(key)
                self._last, self._last_key = self._news(occasion, snapshot), key
                self._send(self._last)
                return

    def live(self, text: Callable[[Message], str]) -> Mapping[str, Any]:
        """Return the last notice, as long as it is true."""
        news = self._last
        if news is None:
            return {"notice": None}
        return {
            "notice": {
                "id": news.number,
                "level": news.occasion.value,
                "title": sentence(text, news.title),
                "text": sentence(text, news.text),
                "remedy": sentence(text, news.remedy),
            }
        }

    def _news(self, occasion: Occasion, snapshot: Snapshot) -> News:
        shown = condition_of(snapshot)
        title, said, first = shown.title, shown.message, shown.remedy
        gone = lost(snapshot)
        if occasion is Occasion.NO_CONTACT and gone is not None:
            title, said, first = gone.title, gone.message, gone.remedy
        elif occasion is Occasion.FAULT and snapshot.state is not None:
            card = fault_notice(snapshot.state)
            title, said, first = card.title, card.text, card.first
        number = self._clock.time_of_day_us()
        return News(number, occasion, title, said, first, percent_of(snapshot))


def _found(snapshot: Snapshot) -> Dict[Key, Occasion]:
    """Return what is so now, with what stays the same while its numbers change."""
    found: Dict[Key, Occasion] = {}
    state = snapshot.state
    gone = lost(snapshot)
    # A robot that rests may be switched off.
    if gone is not None and (snapshot.running or snapshot.interrupted or snapshot.moving):
        found[("lost", snapshot.interrupted)] = Occasion.NO_CONTACT
    if state is None:
        return found
    if state.is_fault:
        code, first = state.reason.fault_code, fault_notice(state).first
        found[(state.code, state.survey_id, code, first)] = Occasion.FAULT
    elif state.code is SurveyState.PAUSED:
        found[(state.code, state.survey_id)] = Occasion.PAUSED
    elif state.shown is SurveyState.FINISHED:
        found[(state.shown, state.survey_id)] = Occasion.FINISHED
    return found

"""Paused, fault, finished, no contact: each once per occurrence, and nothing that was so before."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Dict, FrozenSet, List, Optional, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_views import ASKED, SILENT, ManualClock, state_of, view

from gpr20_common.message import Fault, Message
from gpr20_operator.robot.events import ControlState, Progress
from gpr20_operator.robot.replay import ReplayMark, ReplayView
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState as S
from gpr20_web.mid.watch import Watch
from gpr20_web.news import News, Occasion

OTHER = Fault("axis.stuck", Message("Look at the axis."))
PAUSED, FAULT = Occasion.PAUSED, Occasion.FAULT
FINISHED, NO_CONTACT = Occasion.FINISHED, Occasion.NO_CONTACT
# State, fault, contact, and what somebody must learn who is not looking.
TABLE: Dict[str, Tuple[S, Optional[Fault], bool, FrozenSet[Occasion]]] = {
    "it rests": (S.IDLE, ASKED, True, frozenset()),
    "it measures": (S.SURVEYING, ASKED, True, frozenset()),
    "somebody has paused it": (S.PAUSED, ASKED, True, frozenset([PAUSED])),
    "a fault has paused it": (S.PAUSED, SILENT, True, frozenset([FAULT])),
    "another fault has paused it": (S.PAUSED, OTHER, True, frozenset([FAULT])),
    "it has failed": (S.FAILED, SILENT, True, frozenset([FAULT])),
    "somebody has stopped it": (S.STOPPED, ASKED, True, frozenset()),
    "it was stopped, with a fault": (S.STOPPED, SILENT, True, frozenset([FAULT])),
    "it has finished": (S.FINISHED, ASKED, True, frozenset([FINISHED])),
    "no contact while it measures": (S.SURVEYING, ASKED, False, frozenset([NO_CONTACT])),
    "no contact while it is paused": (S.PAUSED, ASKED, False, frozenset([NO_CONTACT, PAUSED])),
    "it is switched off at rest": (S.IDLE, ASKED, False, frozenset()),
    "it is switched off when done": (S.FINISHED, ASKED, False, frozenset([FINISHED])),
}
REPLAY = ReplayView(ReplayMark())


def _snapshot(name: str, survey: str, number: int) -> Snapshot:
    code, fault, alive, _expected = TABLE[name]
    silent_s = 0.1 if alive else 6.0 + number
    return view(state_of(code, fault, survey, number), alive, control_silent_s=silent_s)


class Out:
    """Collects what is sent."""

    def __init__(self, **options: Any) -> None:
        self.sent: List[News] = []
        self.clock = ManualClock()
        self.watch = Watch(self.clock, self.sent.append, **options)

    def show(self, *snapshots: Snapshot) -> List[Occasion]:
        """Show snapshots; return what was sent since."""
        self.sent.clear()
        for one in snapshots:
            self.clock.time_s += 0.2
            self.watch.refresh(one)
        return [one.occasion for one in self.sent]


STEPS = st.lists(st.tuples(st.sampled_from(sorted(TABLE)), st.sampled_from("ab")), max_size=12)


@given(STEPS, st.integers(0, 9))
def test_each_occurrence_is_sent_once_whatever_comes_after_what(
    steps: List[Tuple[str, str]], number: int
) -> None:
    out = Out()
    before: Any = None
    for name, survey in steps:
        code, fault, _alive, occasions = TABLE[name]
        # The same one: of the same survey, and the same fault in the same state.
        which = {
            FAULT: (code, survey, fault),
            PAUSED: survey,
            FINISHED: survey,
            NO_CONTACT: None,
        }
        now = {(one, which[one]) for one in occasions}
        new = {one for one in now if one[0] is FAULT} if before is None else now - before
        several = [_snapshot(name, survey, number + more) for more in range(4)]
        assert sorted(one.value for one in out.show(*several)) == sorted(
            one.value for one, _key in new
        )
        before = now


def test_a_replay_and_a_robot_that_said_nothing_yet_are_no_occasion() -> None:
    out = Out()
    failed = _snapshot("it has failed", "a", 0)
    measuring = _snapshot("it measures", "a", 0)
    assert out.show(view(None), view(None, alive=False), replace(failed, replay=REPLAY)) == []
    assert out.show(measuring, failed) == [FAULT]
    assert out.show(replace(measuring, replay=REPLAY), failed) == []


def test_a_main_control_that_lost_a_survey_is_an_occasion() -> None:
    out = Out()
    out.show(_snapshot("it measures", "a", 0))
    assert out.show(view(state_of(S.IDLE), interrupted=True)) == [NO_CONTACT]
    assert "restarted" in str(out.sent[0].text)


def test_a_notice_has_reason_remedy_percent_and_picture() -> None:
    out = Out(picture=lambda: b"png")
    progress = Progress("a", 34.9, 100, 34, 60.0)
    out.show(_snapshot("it measures", "a", 0))
    out.show(replace(_snapshot("a fault has paused it", "a", 7), progress=progress))
    (news,) = out.sent
    assert "7 times" in str(news.text)
    assert str(news.remedy) == "Check the cable of the VNA."
    assert (news.percent, news.picture) == (34, b"png")


def test_browsers_are_sent_the_last_notice_while_it_is_true() -> None:
    out = Out()
    out.show(_snapshot("it measures", "a", 0))
    assert out.watch.live(str) == {"notice": None}
    out.show(_snapshot("a fault has paused it", "a", 0))
    first = out.watch.live(str)["notice"]
    assert (first["level"], first["remedy"]) == ("fault", "Check the cable of the VNA.")
    out.show(_snapshot("another fault has paused it", "a", 0))
    assert out.watch.live(str)["notice"]["id"] > first["id"]
    out.show(_snapshot("it measures", "a", 0))
    assert out.watch.live(str)["notice"] is None


@pytest.mark.parametrize("occasion", Occasion)
def test_every_occasion_is_in_the_table(occasion: Occasion) -> None:
    assert any(occasion in news for *_state, news in TABLE.values())


def test_a_state_without_a_code_is_judged_by_its_fault_alone() -> None:
    out = Out()
    plain = ControlState(S.PAUSED, Message("paused, says an older version"), "a", True)
    assert out.show(_snapshot("it measures", "a", 0), view(plain), view(plain)) == [FAULT]

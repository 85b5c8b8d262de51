"""Who is in control: one browser at a time; and who pressed what, which nobody waits for."""

from __future__ import annotations

import contextlib
from typing import Any, List, Set, Tuple

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from result_kit import Requests
from web_kit import ManualClock

from gpr20_common.message import Message
from gpr20_survey.folder.log_record import Kind
from gpr20_web.calls import Person, Role
from gpr20_web.faults import NotAllowedError
from gpr20_web.mid.presses import ABSENT_S, NOTE_LIMIT_S, RETRY_S, AuditNotes, Lease

ANA, BEN = (Person(name, Role.CONTROL, f"session of {name}", "") for name in "ab")
TWIN = Person(ANA.name, ANA.role, "other session", "")
ACTS = st.sampled_from(["take", "release", "leave", "come"])
STEPS = st.one_of(
    st.tuples(ACTS, st.sampled_from([ANA, BEN, TWIN])),
    st.tuples(st.just("wait"), st.floats(0.0, 50.0)),
    st.tuples(st.just("allow"), st.booleans()),
)


@given(st.lists(STEPS, min_size=20, max_size=40))
def test_control_passes_to_another_only_by_leaving_or_when_it_was_not_allowed(
    steps: List[Tuple[str, Any]],
) -> None:
    clock, allowed, was_open = ManualClock(), True, True
    present: Set[str] = {one.session for one in (ANA, BEN, TWIN)}
    lease = Lease(clock, lambda session: session in present)
    for what, argument in steps:
        before = lease.holder
        if what == "wait":
            clock.time_s += argument
        elif what == "allow":
            allowed = argument
        elif what == "leave":
            present.discard(argument.session)
        elif what == "come":
            present.add(argument.session)
        elif what == "release":
            lease.release(argument)
            assert lease.holder is None or lease.holder is before
        else:
            may_take = was_open or before is argument
            with contextlib.nullcontext() if may_take else pytest.raises(NotAllowedError):
                lease.take(argument, allowed)
            assert (lease.holder is argument) is may_take
        lease.refresh(allowed)
        after = lease.holder
        if before is not None and after is not before and not was_open:
            assert (what, argument) == ("release", before) or before.session not in present
        # Allowed when it was taken, and since.
        was_open = after is None or not allowed or (was_open and what != "take")
        for one in (ANA, BEN, TWIN):
            assert lease.has(one) is (one is after)


def test_a_tab_that_is_closed_or_a_link_that_is_lost_gives_control_up() -> None:
    clock, present = ManualClock(), {ANA.session}
    lease = Lease(clock, lambda session: session in present)
    lease.take(ANA, True)
    clock.time_s += 10 * ABSENT_S
    lease.refresh(True)
    present.clear()
    for wait_s, is_held in ((ABSENT_S, True), (0.1, False)):
        clock.time_s += wait_s
        lease.refresh(True)
        assert lease.has(ANA) is is_held


# Longer than an answer takes.
STEP_S = RETRY_S / 4


class Log:
    """Notes on their way to a storage, which answers one step later.

    Attributes:
        taken: The surveys whose notes the storage has taken, in that order.
    """

    def __init__(self, *surveys: str) -> None:
        self.clock, self.requests = ManualClock(), Requests()
        self.notes = AuditNotes(self.requests, self.clock.now_s, lambda _problem: None)
        self.taken: List[str] = []
        for one in surveys:
            self.notes.add(one, {"command": "stop", "survey": one})

    def run(self, duration_s: float, refused: str = "") -> List[float]:
        """Let time pass; return when notes were answered."""
        sent_s = []
        for _step in range(round(duration_s / STEP_S)):
            waiting = self.requests.asked
            assert len(waiting) <= 1  # one at a time
            self.clock.time_s += STEP_S
            for _service, ticket, fields in [*waiting]:
                waiting.clear()
                sent_s.append(self.clock.now_s())
                assert fields["kind"] is Kind.AUDIT
                assert fields["values"] == {"command": "stop", "survey": fields["survey"]}
                if fields["survey"] in refused.split():
                    ticket.fail(Message("the storage does not answer"))
                else:
                    self.taken.append(fields["survey"])
                    ticket.done(Message("noted"))
            self.notes.refresh()
        return sent_s


@each_case("away_s", [0.0, RETRY_S, 7 * RETRY_S, NOTE_LIMIT_S - 3 * RETRY_S])
def test_each_is_noted_once_when_the_storage_is_there_and_one_without_a_survey_given_up(
    away_s: float,
) -> None:
    log = Log("gone", "a", "b", "c")
    sent_s = log.run(away_s, refused="gone a b c")
    assert all(later - one >= RETRY_S for one, later in zip(sent_s, sent_s[1:]))
    assert log.taken == [] and (log.notes.problem is not None) is (away_s > 0)
    log.run(6 * RETRY_S, refused="gone")
    assert sorted(log.taken) == ["a", "b", "c"]
    log.run(NOTE_LIMIT_S, refused="gone")
    assert "does not answer" in str(log.notes.problem)
    assert log.run(4 * RETRY_S) == []


@each_case("refused", ["", "b", "a b c"])
def test_at_the_end_each_that_waits_is_sent_once_more_and_what_is_lost_is_known(
    refused: str,
) -> None:
    log = Log("a", "b", "c")
    log.run(2 * RETRY_S, refused="a b c")
    ended: List[bool] = []
    log.notes.finish(lambda: ended.append(True))
    sent_s = log.run(4 * STEP_S, refused=refused)
    # Without a pause, and no more often than once.
    assert len(sent_s) == 3 and ended
    assert sorted(fact["survey"] for _until_s, fact in log.notes.waiting) == refused.split()
    assert sorted([*log.taken, *refused.split()]) == ["a", "b", "c"]

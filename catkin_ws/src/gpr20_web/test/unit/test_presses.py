"""The notes of who pressed what: each reaches the log of its survey, and nobody waits for it."""

from __future__ import annotations

from typing import List

from case_kit import each_case
from result_kit import Requests
from web_kit import ManualClock

from gpr20_common.message import Message
from gpr20_survey.folder.log_record import Kind
from gpr20_web.mid.presses import NOTE_LIMIT_S, RETRY_S, AuditNotes

# Longer than an answer takes.
STEP_S = RETRY_S / 4


class Log:
    """Notes on their way to a storage, which answers one step later.

    Attributes:
        taken: The surveys whose notes the storage has taken, in that order.
    """

    def __init__(self, *surveys: str) -> None:
        self.clock, self.requests = ManualClock(), Requests()
        self.reported: List[Message] = []
        self.notes = AuditNotes(self.requests, self.clock.now_s, self.reported.append)
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
def test_each_is_noted_once_whenever_the_storage_is_there_again(away_s: float) -> None:
    log = Log("a", "b", "c")
    sent_s = log.run(away_s, refused="a b c")
    assert all(later - one >= RETRY_S for one, later in zip(sent_s, sent_s[1:]))
    assert log.taken == [] and (log.notes.problem is not None) is (away_s > 0)
    log.run(5 * RETRY_S)
    assert sorted(log.taken) == ["a", "b", "c"]
    # One outage is one report.
    expected = ["web.not_noted"] if away_s else []
    assert [one.fault_code for one in log.reported] == expected
    assert log.notes.problem is None


def test_one_that_is_always_refused_holds_up_no_other_and_is_given_up() -> None:
    log = Log("gone", "a", "b")
    log.run(4 * RETRY_S, refused="gone")
    assert log.taken == ["a", "b"]
    assert "does not answer" in str(log.notes.problem)
    log.run(NOTE_LIMIT_S, refused="gone")
    assert log.run(4 * RETRY_S, refused="gone") == []
    log.notes.add("c", {"command": "stop", "survey": "c"})
    log.run(4 * RETRY_S, refused="gone")
    assert log.taken == ["a", "b", "c"] and log.notes.problem is None


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
    assert sorted(one["survey"] for one in log.notes.waiting) == refused.split()
    assert sorted([*log.taken, *refused.split()]) == ["a", "b", "c"]


def test_with_nothing_to_note_the_end_waits_for_nothing() -> None:
    log, ended = Log(), []  # type: Log, List[bool]
    log.notes.finish(lambda: ended.append(True))
    assert ended == [True] and log.requests.asked == []

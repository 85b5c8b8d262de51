"""Nobody waits for what is sent, and what fails is tried again behind the others."""

from __future__ import annotations

import threading
from typing import List

from case_kit import each_case

from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError
from gpr20_web.low.outbox import Outbox

LIMIT_S, TRIES = 100.0, 4


class Sender:
    """Sends things to a list; some of the first attempts fail.

    Attributes:
        sent: What has arrived.
        go: Set it to let an attempt begin; it waits for that.
    """

    def __init__(self, *failures: Exception) -> None:
        self.failures, self.sent = list(failures), []  # type: List[Exception], List[str]
        self.tried: List[str] = []
        self.go, self._come = threading.Event(), threading.Condition()

    def __call__(self, thing: str) -> None:
        assert self.go.wait(LIMIT_S)
        with self._come:
            self.tried.append(thing)
            self._come.notify_all()
            if self.failures:
                raise self.failures.pop(0)
            self.sent.append(thing)

    def wait_for(self, tries: int) -> None:
        with self._come:
            assert self._come.wait_for(lambda: len(self.tried) >= tries, LIMIT_S)


def test_what_fails_is_tried_again_behind_the_others_and_reported_once(
    fault_log: List[str],
) -> None:
    own, refused = ZeroDivisionError("our own fault"), SurveyRefusedError(Message("not there"))
    reported: List[Message] = []
    send = Sender(own, ConnectionRefusedError(), refused)
    box = Outbox(send, Message("not sent"), reported.append, 0.001, TRIES)
    for thing in ("lost by our fault", "first", "last"):
        box.put(thing)  # nobody waits for what hangs
    send.go.set()
    send.wait_for(5)
    box.close(LIMIT_S)
    assert send.sent == ["first", "last"]
    assert [one.fault_code for one in reported] == ["web.not_sent"]
    assert box.problem is None
    assert "our own fault" in "".join(fault_log)


@each_case("failures", [TRIES - 1, TRIES])
def test_a_thing_is_given_up_after_its_tries_and_holds_up_no_other(failures: int) -> None:
    send = Sender(*(TimeoutError() for _number in range(failures)))
    box = Outbox(send, Message("not sent"), lambda _problem: None, 0.001, TRIES)
    box.put("one")
    send.go.set()
    send.wait_for(TRIES)
    assert box.problem is None or failures == TRIES
    box.put("other")
    send.wait_for(TRIES + 1)
    box.close(LIMIT_S)
    assert send.sent == (["other"] if failures == TRIES else ["one", "other"])
    assert box.problem is None


def test_at_the_end_each_is_tried_once_more() -> None:
    send = Sender(*(TimeoutError() for _number in range(2)))
    box = Outbox(send, Message("not sent"), lambda _problem: None, LIMIT_S, TRIES)
    for thing in ("a", "b", "c"):
        box.put(thing)
    send.go.set()
    box.close(LIMIT_S)
    assert (send.tried, send.sent) == (["a", "b", "c"], ["c"])

"""Who did what stands in the log of the survey, and nobody waits for it."""

from __future__ import annotations

import json
import threading
from typing import List
from unittest import mock

import pytest

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.log_record import NOTES, Kind
from gpr20_survey.folder.survey_metadata import parse_object
from gpr20_web import calls
from gpr20_web.calls import Role
from gpr20_web.low import outbox
from gpr20_web.mid.audit import Audit

LIMIT_S = 100.0
ANA = calls.Person("ana", Role.CONTROL, "secret-of-the-session", "10.0.0.7")
CALL = calls.Call(ANA, "10.0.0.7")


class Heard:
    """Takes reports and lets a test wait for them."""

    def __init__(self) -> None:
        self.messages: List[Message] = []
        self._come = threading.Condition()

    def __call__(self, message: Message) -> None:
        with self._come:
            self.messages.append(message)
            self._come.notify_all()

    def wait_for(self, count: int) -> None:
        """Return when so many have come."""
        with self._come:
            assert self._come.wait_for(lambda: len(self.messages) >= count, LIMIT_S)


def test_a_command_for_a_survey_is_in_its_log_and_one_that_is_refused_holds_up_no_other() -> None:
    refused, heard = SurveyRefusedError(Message("there is no such survey")), Heard()
    log = mock.Mock(side_effect=[refused, None])
    audit = Audit(log, heard, Clock(), retry_s=0.001)
    audit.add(CALL, "start", "refused", "")
    audit.add(CALL, "pause", "sent", "of long ago")
    audit.add(CALL, "stop", "done " * 100, "5f")
    audit.close(LIMIT_S)
    assert log.call_count == 2
    survey, values = log.call_args[0]
    shown = [values[one] for one in ("user", "role", "address", "command")]
    assert (survey, *shown) == ("5f", "ana", "control", "10.0.0.7", "stop")
    assert values["time"].endswith("+00:00") and len(values["outcome"]) == 200
    assert "secret" not in json.dumps(values)
    # In a form that the storage takes.
    assert Kind.AUDIT in NOTES
    assert parse_object(json.dumps(values), "values_json") == values
    assert "there is no such survey" in str(heard.messages[0])


class Sender:
    """Sends things to a list; some of the first attempts fail.

    Attributes:
        sent: What has arrived.
        go: Set it to let an attempt begin; it waits for that.
    """

    def __init__(self, *failures: Exception) -> None:
        self.failures, self.sent = list(failures), []  # type: List[Exception], List[str]
        self.go, self.begun, self.last = threading.Event(), threading.Event(), threading.Event()

    def __call__(self, thing: str) -> None:
        self.begun.set()
        assert self.go.wait(LIMIT_S)
        if self.failures:
            raise self.failures.pop(0)
        self.sent.append(thing)
        if thing == "last":
            self.last.set()


def test_what_cannot_be_sent_is_sent_again_in_its_order_and_reported_once(
    fault_log: List[str],
) -> None:
    own = ZeroDivisionError("a fault of our own")
    send, heard = Sender(own, ConnectionRefusedError(), TimeoutError()), Heard()
    box = outbox.Outbox(send, Message("not sent"), heard, 0.001)
    for thing in ("lost by our fault", "first", "last"):
        box.put(thing)
    send.go.set()
    assert send.last.wait(LIMIT_S)
    box.close(LIMIT_S)
    assert send.sent == ["first", "last"]
    assert [one.fault_code for one in heard.messages] == ["web.not_sent"]
    assert box.problem is None
    assert "a fault of our own" in "".join(fault_log)


def test_nobody_waits_for_what_hangs_and_what_had_no_room_is_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(outbox, "MOST_WAITING", 3)
    send, heard = Sender(), Heard()
    box = outbox.Outbox(send, Message("not sent"), heard, 0.001)
    box.put("first")
    assert send.begun.wait(LIMIT_S)
    for number in range(7):
        box.put(str(number))
    assert box.waiting == ("first", "0", "1")
    send.go.set()
    box.close(LIMIT_S)
    assert send.sent == ["first", "0", "1"]
    assert "5 lost" in str(heard.messages[0])

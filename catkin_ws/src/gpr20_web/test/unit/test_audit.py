"""Who did what: durable, complete, and nobody waits for it."""

from __future__ import annotations

import json
import stat
import threading
import time
from pathlib import Path
from typing import Any, List, Mapping
from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.log_record import NOTES, Kind
from gpr20_survey.folder.survey_metadata import parse_object
from gpr20_web import calls
from gpr20_web.low import outbox
from gpr20_web.mid.audit import Audit
from gpr20_web.roles import Role

LIMIT_S = 30.0
ANA = calls.Person("ana", Role.OPERATE, "secret-of-the-session", "10.0.0.7")
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


def _audit(path: Path, log: Any = None, heard: Any = None, **options: Any) -> Audit:
    return Audit(
        path / "web" / "audit.jsonl",
        log or mock.Mock(),
        heard or Heard(),
        Clock(),
        **{"retry_s": 0.001, **options},
    )


def _lines(path: Path) -> List[Mapping[str, Any]]:
    file = path / "web/audit.jsonl"
    return [json.loads(one) for one in file.read_text().splitlines()] if file.exists() else []


def test_an_entry_says_when_who_from_where_what_and_how_it_ended(tmp_path: Path) -> None:
    (tmp_path / "web").mkdir(0o755)
    audit = _audit(tmp_path)
    audit.add(CALL, "pause", "done", x=1.5, name="long " * 100)
    audit.add(calls.Call(None, "10.0.0.9"), "failed_login", name="root")
    audit.close(LIMIT_S)
    entry, failed = _lines(tmp_path)
    assert entry["time"].endswith("+00:00")
    shown = {key: entry[key] for key in ("user", "role", "address", "command", "outcome")}
    assert list(shown.values()) == ["ana", "operate", "10.0.0.7", "pause", "done"]
    assert entry["values"]["x"] == 1.5
    assert len(entry["values"]["name"]) == 200
    assert "secret" not in json.dumps(entry)
    assert (failed["role"], failed["address"]) == ("nobody", "10.0.0.9")
    assert stat.S_IMODE((tmp_path / "web/audit.jsonl").stat().st_mode) == 0o600


def test_a_command_for_a_survey_is_in_its_log_and_a_note_that_is_refused_holds_up_no_other(
    tmp_path: Path,
) -> None:
    refused, heard = SurveyRefusedError(Message("there is no such survey")), Heard()
    log = mock.Mock(side_effect=[refused, None])
    audit = _audit(tmp_path, log, heard)
    audit.add(CALL, "pause", survey="of long ago")
    audit.add(CALL, "stop", "done", survey="5f")
    audit.close(LIMIT_S)
    survey, values = log.call_args[0]
    assert (survey, values["user"], values["command"]) == ("5f", "ana", "stop")
    assert {"role", "address", "outcome", "time"} <= set(values)
    # In a form that the storage takes.
    assert Kind.AUDIT in NOTES
    assert parse_object(json.dumps(values), "values_json") == values
    assert "there is no such survey" in str(heard.messages[0])
    assert len(_lines(tmp_path)) == 2


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


def test_a_file_that_cannot_be_written_is_reported_kept_and_written_later(tmp_path: Path) -> None:
    obstacle, heard = tmp_path / "web", Heard()
    obstacle.write_text("a file where the folder should be")
    audit = _audit(tmp_path, heard=heard)
    audit.add(CALL, "stop")
    heard.wait_for(1)
    assert audit.problems
    obstacle.unlink()
    audit.add(CALL, "pause")
    while audit.problems or len(_lines(tmp_path)) < 2:
        time.sleep(0.01)
    audit.close(LIMIT_S)
    assert [one["command"] for one in _lines(tmp_path)] == ["stop", "pause"]
    assert len(heard.messages) == 1


def test_a_full_file_has_one_predecessor(tmp_path: Path) -> None:
    audit = _audit(tmp_path, most_bytes=1000)
    for number in range(12):
        audit.add(CALL, "note", number=number)
    audit.close(LIMIT_S)
    files = sorted(one.name for one in (tmp_path / "web").iterdir())
    assert files == ["audit.1.jsonl", "audit.jsonl"]
    assert _lines(tmp_path)[-1]["values"]["number"] == 11


@given(st.dictionaries(st.sampled_from("abc"), st.floats() | st.binary() | st.none() | st.text()))
def test_whatever_an_entry_is_about_it_is_json(values: Any) -> None:
    kept: List[Any] = []
    audit = Audit(Path("/dev/null/none"), lambda _id, entry: kept.append(entry), Heard(), Clock())
    audit.add(CALL, "note", "", "5f", **values)
    audit._notes.close(LIMIT_S)
    json.dumps(kept, allow_nan=False)
    audit.close(LIMIT_S)

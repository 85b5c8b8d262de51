"""What somebody must learn who is not looking: once per occurrence, and by apprise.

Nobody waits for what is sent; the notices are whole, sent again if needed, and without a word of
apprise's addresses.
"""

from __future__ import annotations

import http.server
import json
import logging
import threading
from functools import partial
from typing import Any, Dict, Iterator, List, Optional, Tuple

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from view_kit import snapshot
from web_kit import ASKED, SILENT, state_of

from gpr20_common.message import Fault, Message
from gpr20_operator.robot.events import ControlState
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.plan.survey_state import SurveyState as S
from gpr20_web.low import notifier as module
from gpr20_web.low.notifier import TRIES, News, Notifier, Outbox
from gpr20_web.mid.watch import Watch

LIMIT_S, SHORT_S = 100.0, 0.001
NEWS = News("failure", Message("the VNA"), Message("it is silent"), Message("look"))


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
    box = Outbox(send, Message("not sent"), reported.append, SHORT_S)
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
    box = Outbox(send, Message("not sent"), lambda _problem: None, SHORT_S)
    box.put("one")
    send.go.set()
    send.wait_for(TRIES)
    box.put("other")
    send.wait_for(TRIES + 1)
    box.close(LIMIT_S)
    assert send.sent == (["other"] if failures == TRIES else ["one", "other"])
    assert box.problem is None


def test_at_the_end_each_is_tried_once_more() -> None:
    send = Sender(*(TimeoutError() for _number in range(2)))
    box = Outbox(send, Message("not sent"), lambda _problem: None, LIMIT_S)
    for thing in ("a", "b", "c"):
        box.put(thing)
    send.go.set()
    box.close(LIMIT_S)
    assert (send.tried, send.sent) == (["a", "b", "c"], ["c"])


class Receiver:
    """A service on loopback that may refuse or hang.

    Attributes:
        got: The JSON objects.
        refusals: How many of the next requests it refuses.
    """

    def __init__(self) -> None:
        self.got: List[Any] = []
        self.asked, self.refusals = 0, 0
        self.hang = threading.Event()
        self.hang.set()
        self._come = threading.Condition()
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                content = self.rfile.read(int(self.headers["Content-Length"]))
                outer.hang.wait(LIMIT_S)
                self.send_response(outer.take(json.loads(content)))
                self.end_headers()

            def log_message(self, *_words: Any) -> None:
                """Write nothing."""

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.place = f"127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, args=(0.01,), daemon=True).start()

    def close(self) -> None:
        self.hang.set()
        self.server.shutdown()
        self.server.server_close()

    def take(self, values: Any) -> int:
        with self._come:
            self.asked += 1
            self._come.notify_all()
            if self.refusals:
                self.refusals -= 1
                return 500
            self.got.append(values)
            return 200

    def wait_for(self, requests: int) -> None:
        with self._come:
            assert self._come.wait_for(lambda: self.asked >= requests, LIMIT_S)


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    one = Receiver()
    yield one
    one.close()


def _notifier(*urls: str) -> Tuple[Notifier, List[Message]]:
    reported: List[Message] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "Outbox", partial(Outbox, delay_s=SHORT_S))
        return Notifier(urls, "robot 1", str, reported.append), reported


def test_a_notice_arrives_with_reason_and_remedy_and_is_sent_again(receiver: Receiver) -> None:
    receiver.refusals = 1
    notifier, reported = _notifier(f"json://{receiver.place}/")
    notifier.send(NEWS)
    receiver.wait_for(2)
    notifier.close(LIMIT_S)
    (values,) = receiver.got
    assert (values["title"], values["type"]) == ("robot 1: the VNA", "failure")
    assert values["message"] == "It is silent\nLook"
    assert [one.fault_code for one in reported] == ["web.not_sent"]


def test_a_service_that_hangs_holds_up_nobody(receiver: Receiver) -> None:
    receiver.hang.clear()
    other = Receiver()
    notifier, _reported = _notifier(*(f"json://{one.place}/?rto=15" for one in (receiver, other)))
    for _number in range(3):
        notifier.send(NEWS)
    other.wait_for(3)
    receiver.hang.set()
    notifier.close(LIMIT_S)
    other.close()
    assert receiver.got == other.got


@each_case("url", ["nonsense://secret-word", "secret-word", "tgram://secret-word", "\0"])
def test_an_address_that_apprise_does_not_know_is_left_out_and_reported_without_its_text(
    receiver: Receiver, url: str
) -> None:
    receiver.got.clear()
    notifier, reported = _notifier(url, f"json://{receiver.place}/")
    notifier.send(NEWS)
    notifier.close(LIMIT_S)
    assert len(receiver.got) == 1
    (warning,) = reported
    assert warning.fault_code == "config.wrong"
    assert "address 1" in str(warning) and "secret-word" not in str(warning)


@each_case("service", ["takes it", "refuses", "is away"])
def test_no_part_of_an_address_is_in_a_log_a_report_or_an_error(service: str) -> None:
    words: List[str] = []

    class Everything(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            words.append(self.format(record))

    handler, root, receiver = Everything(), logging.getLogger(), Receiver()
    level = root.level
    root.addHandler(handler)
    root.setLevel(logging.DEBUG)
    receiver.refusals = 99 if service == "refuses" else 0
    place = "127.0.0.1:9" if service == "is away" else receiver.place
    try:
        notifier, reported = _notifier(f"json://user:pass7word@{place}/path7word?+X-Key=key7word")
        notifier.send(NEWS)
        notifier.close(LIMIT_S)
        words.extend(f"{one!r} {one}" for one in reported)
    finally:
        root.removeHandler(handler)
        root.setLevel(level)
        receiver.close()
    assert (receiver.asked > 0) is (service != "is away")
    assert not [one for one in words if "7word" in one]


OTHER = Fault("axis.stuck", Message("Look at the axis."))
PAUSED, FAULT, FINISHED, NO_CONTACT = "paused", "fault", "finished", "no contact"
KINDS = {PAUSED: "warning", FINISHED: "success", FAULT: "failure", NO_CONTACT: "failure"}
# State, fault, contact, and what somebody must learn who is not looking.
TABLE: Dict[str, Tuple[S, Optional[Fault], bool, Optional[str]]] = {
    "it rests": (S.IDLE, ASKED, True, None),
    "it measures": (S.SURVEYING, ASKED, True, None),
    "somebody has paused it": (S.PAUSED, ASKED, True, PAUSED),
    "a fault has paused it": (S.PAUSED, SILENT, True, FAULT),
    "another fault has paused it": (S.PAUSED, OTHER, True, FAULT),
    "it has failed": (S.FAILED, SILENT, True, FAULT),
    "somebody has stopped it": (S.STOPPED, ASKED, True, None),
    "it was stopped, with a fault": (S.STOPPED, SILENT, True, FAULT),
    "it has finished": (S.FINISHED, ASKED, True, FINISHED),
    "no contact while it measures": (S.SURVEYING, ASKED, False, NO_CONTACT),
    "no contact while it is paused": (S.PAUSED, ASKED, False, NO_CONTACT),
    "it is switched off at rest": (S.IDLE, ASKED, False, None),
    "it is switched off when done": (S.FINISHED, ASKED, False, FINISHED),
}


def _snapshot(name: str, survey: str = "a", number: int = 0) -> Snapshot:
    code, fault, alive, _expected = TABLE[name]
    silent_s = 0.1 if alive else 6.0 + number
    state = state_of(code, fault, survey, number)
    return snapshot(alive=alive, state=state, control_silent_s=silent_s)


class Out:
    """Collects what is sent."""

    def __init__(self) -> None:
        self.sent: List[News] = []
        self.watch = Watch(self.sent.append)

    def show(self, *snapshots: Snapshot) -> List[str]:
        """Show snapshots; return the kinds of what was sent since."""
        self.sent.clear()
        for one in snapshots:
            self.watch.refresh(one)
        return [one.kind for one in self.sent]


STEPS = st.lists(st.tuples(st.sampled_from(sorted(TABLE)), st.sampled_from("ab")), max_size=12)


@given(STEPS, st.integers(0, 9))
def test_each_occurrence_is_sent_once_whatever_comes_after_what(
    steps: List[Tuple[str, str]], number: int
) -> None:
    out, before, is_first = Out(), set(), True  # type: Out, set, bool
    # Of a robot that said nothing yet nothing is known.
    assert out.show(snapshot(), snapshot(alive=False)) == []
    for name, survey in steps:
        code, fault, _alive, occasion = TABLE[name]
        # The same one: of the same survey, and the same fault in the same state.
        which = {FAULT: (code, survey, fault), NO_CONTACT: None}.get(occasion, survey)
        now = {(occasion, which)} - {(None, survey)}
        new = now - before if not is_first or occasion is FAULT else set()
        several = [_snapshot(name, survey, number + more) for more in range(4)]
        assert out.show(*several) == [KINDS[one] for one, _which in new]
        # What was so before the contact was lost is not new after it.
        before, is_first = now | (before if occasion is NO_CONTACT else set()), False


def test_a_lost_survey_a_state_without_a_code_and_what_may_move_are_occasions() -> None:
    out = Out()
    out.show(_snapshot("it measures"))
    assert out.show(snapshot(state=state_of(S.IDLE), interrupted=True)) == ["failure"]
    assert "restarted" in str(out.sent[0].text)
    older = ControlState(S.PAUSED, Message("paused, says an older version"), "a", True)
    plain = snapshot(state=older)
    assert out.show(_snapshot("it measures"), plain, plain) == ["failure"]
    for fault in (Fault("mast.warped"), Fault("mast.warped", may_move=True)):
        assert out.show(snapshot(state=state_of(S.PAUSED, fault, "a"))) == ["failure"]
    out.show(_snapshot("a fault has paused it", "a", 7))
    (news,) = out.sent
    assert "7 times" in str(news.text)
    assert str(news.remedy) == "Check the cable of the VNA."

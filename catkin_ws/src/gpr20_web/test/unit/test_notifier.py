"""What somebody must learn who is not looking: once per occurrence, and by apprise.

The notices are whole, sent again if needed, and without a word of apprise's addresses.
"""

from __future__ import annotations

import http.server
import json
import logging
import threading
from dataclasses import replace
from typing import Any, Dict, Iterator, List, Optional, Tuple
from urllib.parse import quote

import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from view_kit import snapshot
from web_kit import ASKED, SILENT, ManualClock, state_of

from gpr20_common.message import Fault, Message
from gpr20_operator.robot.events import ControlState, Replay
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState as S
from gpr20_web.low.notifier import News, Notifier, Occasion
from gpr20_web.mid.watch import Watch

LIMIT_S = 100.0
NEWS = News(1, Occasion.FAULT, Message("the VNA"), Message("it is silent"), Message("look"))


class Receiver:
    """A service on loopback that may refuse or hang.

    Attributes:
        got: The JSON objects.
        refusals: How many of the next requests it refuses.
    """

    def __init__(self) -> None:
        self.got: List[Any] = []
        self.paths: List[str] = []
        self.refusals = 0
        self.hang = threading.Event()
        self.hang.set()
        self._come = threading.Condition()
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                content = self.rfile.read(int(self.headers["Content-Length"]))
                outer.hang.wait(LIMIT_S)
                self.send_response(outer.take(self.path, json.loads(content)))
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

    def take(self, path: str, values: Any) -> int:
        with self._come:
            self.paths.append(path)
            self._come.notify_all()
            if self.refusals:
                self.refusals -= 1
                return 500
            self.got.append(values)
            return 200

    def wait_for(self, requests: int) -> None:
        with self._come:
            assert self._come.wait_for(lambda: len(self.paths) >= requests, LIMIT_S)


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    one = Receiver()
    yield one
    one.close()


def _notifier(url: str) -> Tuple[Notifier, List[Message]]:
    reported: List[Message] = []
    return Notifier([url], "robot 1", str, reported.append, delay_s=0.001), reported


def test_a_notice_arrives_with_reason_and_remedy(receiver: Receiver) -> None:
    receiver.refusals = 1
    notifier, reported = _notifier(f"json://{receiver.place}/")
    notifier.send(NEWS)
    receiver.wait_for(2)
    notifier.close(LIMIT_S)
    (values,) = receiver.got
    assert values["title"] == "robot 1: the VNA"
    assert values["message"] == "It is silent\nLook"
    assert values["type"] == "failure"
    assert [one.fault_code for one in reported] == ["web.not_sent"]


def test_a_service_that_hangs_holds_up_nobody(receiver: Receiver) -> None:
    receiver.hang.clear()
    other = Receiver()
    urls = [f"json://{one.place}/?rto=15" for one in (receiver, other)]
    notifier = Notifier(urls, "", str, lambda _message: None)
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
    reported: List[Message] = []
    urls = [url, f"json://{receiver.place}/"]
    notifier = Notifier(urls, "robot 1", str, reported.append)
    notifier.send(NEWS)
    notifier.close(LIMIT_S)
    assert len(receiver.got) == 1
    receiver.got.clear()
    (warning,) = reported
    assert warning.fault_code == "config.wrong"
    assert "address 1" in str(warning) and "secret-word" not in str(warning)


SECRETS = st.text("abcdefghijkmnpqrstuvwxyz23456789", min_size=12, max_size=20)


@settings(max_examples=draws(6))
@given(SECRETS, SECRETS, SECRETS, st.sampled_from(["takes it", "refuses", "is away"]))
def test_no_part_of_an_address_is_in_a_log_a_report_or_an_error(
    password: str, path: str, value: str, service: str
) -> None:
    words: List[str] = []

    class Everything(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            words.append(self.format(record))

    handler, root = Everything(), logging.getLogger()
    level = root.level
    root.addHandler(handler)
    root.setLevel(logging.DEBUG)
    receiver = Receiver()
    receiver.refusals = 99 if service == "refuses" else 0
    place = "127.0.0.1:9" if service == "is away" else receiver.place
    try:
        url = f"json://user:{quote(password)}@{place}/{path}?+X-Key={value}"
        notifier, reported = _notifier(url)
        notifier.send(NEWS)
        notifier.close(LIMIT_S)
        words.extend(f"{one!r} {one}" for one in reported)
        words.extend(repr(vars(box)) for box in notifier._boxes if box.problem is None)
    finally:
        root.removeHandler(handler)
        root.setLevel(level)
        receiver.close()
    assert (len(receiver.paths) > 0) is (service != "is away")
    assert not [one for one in words for secret in (password, path, value) if secret in one]


OTHER = Fault("axis.stuck", Message("Look at the axis."))
PAUSED, FAULT = Occasion.PAUSED, Occasion.FAULT
FINISHED, NO_CONTACT = Occasion.FINISHED, Occasion.NO_CONTACT
# State, fault, contact, and what somebody must learn who is not looking.
TABLE: Dict[str, Tuple[S, Optional[Fault], bool, Optional[Occasion]]] = {
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
        self.clock = ManualClock()
        self.watch = Watch(self.clock, self.sent.append)

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
    out, before, is_first = Out(), set(), True  # type: Out, set, bool
    for name, survey in steps:
        code, fault, _alive, occasion = TABLE[name]
        # The same one: of the same survey, and the same fault in the same state.
        which = {FAULT: (code, survey, fault), NO_CONTACT: None}.get(occasion, survey)
        now = {(occasion, which)} - {(None, survey)}
        new = now - before if not is_first or occasion is FAULT else set()
        several = [_snapshot(name, survey, number + more) for more in range(4)]
        assert out.show(*several) == [one for one, _which in new]
        # What was so before the contact was lost is not new after it.
        before, is_first = now | (before if occasion is NO_CONTACT else set()), False


def test_a_replay_and_a_robot_that_said_nothing_yet_are_no_occasion() -> None:
    out = Out()
    failed, measuring = _snapshot("it has failed"), _snapshot("it measures")
    replayed = [replace(one, replay=Replay()) for one in (failed, measuring)]
    assert out.show(snapshot(), snapshot(alive=False), replayed[0]) == []
    assert out.show(measuring, failed) == [FAULT]
    assert out.show(replayed[1], failed) == []
    # What was so before the contact was lost is not new after it.
    paused, lost = _snapshot("somebody has paused it"), _snapshot("no contact while it is paused")
    assert out.show(paused, lost, paused) == [PAUSED, NO_CONTACT]


def test_a_lost_survey_a_state_without_a_code_and_what_may_move_are_occasions() -> None:
    out = Out()
    out.show(_snapshot("it measures"))
    assert out.show(snapshot(state=state_of(S.IDLE), interrupted=True)) == [NO_CONTACT]
    assert "restarted" in str(out.sent[0].text)
    older = ControlState(S.PAUSED, Message("paused, says an older version"), "a", True)
    plain = snapshot(state=older)
    assert out.show(_snapshot("it measures"), plain, plain) == [FAULT]
    for fault in (Fault("mast.warped"), Fault("mast.warped", may_move=True)):
        assert out.show(snapshot(state=state_of(S.PAUSED, fault, "a"))) == [FAULT]


def test_a_notice_is_whole_and_browsers_are_sent_the_last_one_while_it_is_true() -> None:
    out = Out()
    out.show(_snapshot("it measures"))
    assert out.watch.live(str) == {"notice": None}
    out.show(_snapshot("a fault has paused it", "a", 7))
    (news,) = out.sent
    assert "7 times" in str(news.text)
    assert str(news.remedy) == "Check the cable of the VNA."
    first = out.watch.live(str)["notice"]
    assert first["remedy"] == "Check the cable of the VNA."
    out.show(_snapshot("another fault has paused it"))
    assert out.watch.live(str)["notice"]["id"] > first["id"]
    out.show(_snapshot("it measures"))
    assert out.watch.live(str)["notice"] is None

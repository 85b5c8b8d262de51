"""Notices by apprise: whole, in time, again if needed, and without a word of its addresses."""

from __future__ import annotations

import base64
import http.server
import json
import logging
import threading
from typing import Any, Iterator, List, Tuple
from urllib.parse import quote

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gpr20_common.message import Message
from gpr20_web.low.notifier import TRIES, Notifier
from gpr20_web.news import News, Occasion

LIMIT_S = 20.0
NEWS = News(1, Occasion.FAULT, Message("the VNA"), Message("it is silent"), Message("look"), 34)


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

    def take(self, path: str, values: Any) -> int:
        """Take a request; return the status."""
        with self._come:
            self.paths.append(path)
            self._come.notify_all()
            if self.refusals:
                self.refusals -= 1
                return 500
            self.got.append(values)
            return 200

    def wait_for(self, requests: int) -> None:
        """Return when so many have come."""
        with self._come:
            assert self._come.wait_for(lambda: len(self.paths) >= requests, LIMIT_S)


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    one = Receiver()
    yield one
    one.hang.set()
    one.server.shutdown()
    one.server.server_close()


def _notifier(url: str, **options: Any) -> Tuple[Notifier, List[Message]]:
    reported: List[Message] = []
    options = {"delay_s": 0.001, "limit_s": LIMIT_S, **options}
    return Notifier([url], "robot 1", str, reported.append, **options), reported


def test_a_notice_arrives_with_reason_remedy_percent_and_picture(receiver: Receiver) -> None:
    notifier, reported = _notifier(f"json://{receiver.place}/")
    picture = b"\x89PNG picture"
    notifier.send(News(**{**vars(NEWS), "picture": picture}))
    notifier.close(LIMIT_S)
    (values,) = receiver.got
    assert values["title"] == "robot 1: the VNA"
    assert values["message"] == "It is silent\nLook\n34 %"
    assert values["type"] == "failure"
    (attached,) = values["attachments"]
    assert base64.b64decode(attached["base64"]) == picture
    assert attached["mimetype"] == "image/png"
    assert reported == []


def test_a_notice_that_was_refused_is_sent_again_and_reported_once(receiver: Receiver) -> None:
    receiver.refusals = 3
    notifier, reported = _notifier(f"json://{receiver.place}/")
    notifier.send(NEWS)
    receiver.wait_for(4)
    notifier.close(LIMIT_S)
    assert len(receiver.got) == 1
    assert [one.fault_code for one in reported] == ["web.not_sent"]


def test_after_three_more_tries_it_is_given_up_and_the_next_one_is_sent(receiver: Receiver) -> None:
    receiver.refusals = TRIES
    notifier, reported = _notifier(f"json://{receiver.place}/")
    notifier.send(NEWS)
    notifier.send(NEWS)
    receiver.wait_for(TRIES + 1)
    notifier.close(LIMIT_S)
    assert len(receiver.got) == 1
    assert len(reported) == 1


def test_a_service_that_hangs_holds_up_nobody_and_has_a_time_limit(receiver: Receiver) -> None:
    receiver.hang.clear()
    heard = threading.Event()
    notifier = Notifier(
        [f"json://{receiver.place}/?rto=15"], "", str, lambda _m: heard.set(), limit_s=0.05
    )
    for _ in range(50):
        notifier.send(NEWS)
    assert heard.wait(LIMIT_S)
    notifier.close(LIMIT_S)


@pytest.mark.parametrize(
    "url", ["", "nonsense://secret-word", "secret-word", "mailto://", "tgram://secret-word", "\0"]
)
def test_an_address_that_apprise_does_not_know_is_left_out_and_reported_without_its_text(
    receiver: Receiver, url: str
) -> None:
    reported: List[Message] = []
    urls = [url, f"json://{receiver.place}/"]
    notifier = Notifier(urls, "robot 1", str, reported.append, limit_s=LIMIT_S)
    notifier.send(NEWS)
    notifier.close(LIMIT_S)
    assert len(receiver.got) == 1
    (warning,) = reported
    assert warning.fault_code == "web.notify"
    assert "address 1" in str(warning) and "secret-word" not in str(warning)


SECRETS = st.text("abcdefghijkmnpqrstuvwxyz23456789", min_size=12, max_size=20)


@settings(max_examples=25, deadline=None)
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
        receiver.server.shutdown()
        receiver.server.server_close()
    assert (len(receiver.paths) > 0) is (service != "is away")
    assert not [one for one in words for secret in (password, path, value) if secret in one]

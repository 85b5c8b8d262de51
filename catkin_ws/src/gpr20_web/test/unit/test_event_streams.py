"""What browsers that watch are sent, and when."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import json
from types import SimpleNamespace
from typing import Any, Callable, Dict, Optional

import pytest

from gpr20_common.message import Message
from gpr20_web.calls import Document, Person, Role
from gpr20_web.faults import BusyError, NotLoggedInError
from gpr20_web.low import event_streams
from gpr20_web.low.event_streams import MAX_STREAMS, EventStreams


def person(session: str = "one") -> Person:
    return Person("ana", Role.WATCH, session, "")


def always() -> Document:
    """Return a document that does not change."""
    return Document('"a":1,')


class Browser:
    """Takes what is sent when a test says so."""

    def __init__(self, streams: EventStreams, make: Any, session: str = "one") -> None:
        self._events = streams.events(make, person(session))
        self._next: Optional[asyncio.Future[bytes]] = None

    async def take(self) -> Optional[Dict[str, Any]]:
        """Return the next of what is sent; None: there is nothing yet."""
        if self._next is None:
            self._next = asyncio.ensure_future(self._events.__anext__())
        for _number in range(5):
            await asyncio.sleep(0)  # everything runs that can
        if not self._next.done():
            return None
        event, self._next = self._next.result(), None
        assert event.startswith(b"data: ") and event.endswith(b"\n\n")
        return dict(json.loads(event[len(b"data: ") :]))


def in_loop(test: Callable[..., Any]) -> Callable[..., None]:
    """Run a test in a loop of its own."""

    @functools.wraps(test)
    def run(**fixtures: Any) -> None:
        asyncio.run(test(**fixtures))

    return run


@in_loop
async def test_what_matters_is_sent_at_once_the_rest_once_a_second_and_a_slow_one_gets_the_newest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s, state, stored = [100.0], ["works"], [0]
    monkeypatch.setattr(event_streams, "time", SimpleNamespace(monotonic=lambda: now_s[0]))
    streams = EventStreams(lambda _one: None)

    def make() -> Document:
        return Document(f'"state":"{state[0]}",', f'"stored":{stored[0]},')

    quick, slow = Browser(streams, make), Browser(streams, make)
    first = {"state": "works", "stored": 0, "sent_ms": 100_000}
    assert await quick.take() == await slow.take() == first
    last = {"state": "stopped", "stored": 2, "sent_ms": 102_400}
    for state[0], stored[0], now_s[0], sent in (
        ("works", 1, 100.5, None),
        ("works", 2, 101.1, {"state": "works", "stored": 2, "sent_ms": 101_100}),
        ("works", 2, 102.2, {"sent_ms": 102_200}),
        ("stops", 2, 102.3, {"state": "stops", "stored": 2, "sent_ms": 102_300}),
        ("stopped", 2, 102.4, last),
    ):
        assert await quick.take() is None  # until the next beat
        streams.beat()
        assert await quick.take() == sent
    # A new browser learns how old it is.
    now_s[0] = 130.0
    assert await quick.take() is await slow.take() is None
    assert await Browser(streams, make).take() == last
    streams.beat()
    assert await slow.take() == {**last, "sent_ms": 130_000}


@in_loop
async def test_a_stream_ends_with_its_session_or_its_document_and_no_other_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(event_streams, "SESSION_CHECK_S", -1.0)

    def check(one: Person) -> None:
        if one.session == "over":
            raise NotLoggedInError(Message("over"))

    streams = EventStreams(check)
    with pytest.raises(NotLoggedInError):
        await Browser(streams, always, "over").take()
    with pytest.raises(ZeroDivisionError):
        await Browser(streams, lambda: Document(str(1 / 0))).take()
    browser = Browser(streams, always)
    assert await browser.take() and await browser.take() is None
    streams.end()
    with pytest.raises(StopAsyncIteration):
        await browser.take()


def test_a_browser_keeps_connections_for_stop_and_all_together_have_a_limit() -> None:
    streams = EventStreams(lambda _one: None)
    with contextlib.ExitStack() as others:
        with contextlib.ExitStack() as own:
            for _number in range(3):
                own.enter_context(streams.watching(person()))
            with pytest.raises(BusyError, match="at most 3 in one browser, 64 in all"):
                own.enter_context(streams.watching(person()))
            assert streams.has("one") and not streams.has("other")
        assert not streams.has("one")
        for number in range(MAX_STREAMS):
            others.enter_context(streams.watching(person(str(number))))
        with pytest.raises(BusyError):
            others.enter_context(streams.watching(person("another")))

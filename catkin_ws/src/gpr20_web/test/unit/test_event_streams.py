"""What browsers that watch are sent, and when."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import json
from typing import Any, Callable, Dict, List

import pytest

from gpr20_common.message import Message
from gpr20_web.calls import Document, Person, Role
from gpr20_web.faults import BusyError, NotLoggedInError
from gpr20_web.low import event_streams
from gpr20_web.low.event_streams import MAX_STREAMS, EventStreams

LIMIT_S = 20.0


def person(session: str = "one") -> Person:
    return Person("ana", Role.WATCH, session, "")


def always() -> Document:
    """Return a document that does not change."""
    return Document('"a":1,')


class Browser:
    """Takes what is sent as it comes; a slow one only what it asks for."""

    def __init__(self, streams: EventStreams, make: Any, session: str = "one") -> None:
        self.known: Dict[str, Any] = {}
        self.sent: List[Dict[str, Any]] = []
        self._events = streams.events(make, person(session))

    async def take(self) -> None:
        event = await self._events.__anext__()
        assert event.startswith(b"data: ") and event.endswith(b"\n\n")
        self.sent.append(json.loads(event[len(b"data: ") :]))
        self.known.update(self.sent[-1])

    async def take_all(self) -> None:
        while True:
            await self.take()


def in_loop(test: Callable[..., Any]) -> Callable[..., None]:
    """Run a test in a loop of its own."""

    @functools.wraps(test)
    def run(**fixtures: Any) -> None:
        asyncio.run(asyncio.wait_for(test(**fixtures), LIMIT_S))

    return run


async def rest() -> None:
    """Let everything run that can."""
    for _number in range(5):
        await asyncio.sleep(0)


@in_loop
async def test_a_slow_browser_gets_the_newest_state_and_none_of_those_between() -> None:
    number, streams = [0], EventStreams(lambda _one: None)

    def stream() -> Document:
        return Document(f'"number":{number[0]},')

    slow, quick = Browser(streams, stream), Browser(streams, stream)
    await slow.take()
    taking = asyncio.ensure_future(quick.take_all())
    for number[0] in range(1, 6):
        await rest()
        streams.beat()
    await rest()
    assert [one["number"] for one in quick.sent] == list(range(1, 6))
    taken = asyncio.ensure_future(slow.take())
    await rest()
    streams.beat()
    await taken
    assert [one["number"] for one in slow.sent] == [0, 5]
    taking.cancel()


@in_loop
async def test_what_changes_all_the_time_waits_for_the_sign_of_life_or_for_what_matters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    state, stored, streams = ["works"], [0], EventStreams(lambda _one: None)

    def stream() -> Document:
        return Document(f'"state":"{state[0]}",', f'"stored":{stored[0]},')

    browser = Browser(streams, stream)
    taking = asyncio.ensure_future(browser.take_all())
    await rest()
    monkeypatch.setattr(event_streams, "SIGN_OF_LIFE_S", 1e6)
    for stored[0] in (1, 2):
        streams.beat()
        await rest()
    assert len(browser.sent) == 1
    monkeypatch.setattr(event_streams, "SIGN_OF_LIFE_S", 0.0)
    for _number in range(2):
        streams.beat()
        await rest()
    # What the browser has is not sent again.
    assert [set(one) for one in browser.sent[1:]] == [{"state", "stored", "sent_ms"}, {"sent_ms"}]
    monkeypatch.setattr(event_streams, "SIGN_OF_LIFE_S", 1e6)
    state[0] = "stopped"
    streams.beat()
    await rest()
    taking.cancel()
    assert (browser.known["state"], browser.known["stored"]) == ("stopped", 2)


@in_loop
async def test_without_a_beat_nothing_is_sent_and_a_new_browser_learns_how_old_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: now_s[0])
    streams = EventStreams(lambda _one: None)
    first, late = Browser(streams, always), Browser(streams, always)
    taking = asyncio.ensure_future(first.take_all())
    await rest()
    now_s[0] = 130.0
    await rest()
    await late.take()
    taking.cancel()
    assert [one["sent_ms"] for one in (*first.sent, *late.sent)] == [100_000, 100_000]


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
    await browser.take()
    assert browser.known["a"] == 1
    taking = asyncio.ensure_future(browser.take())
    await rest()
    streams.end()
    with pytest.raises(StopAsyncIteration):
        await taking


def test_a_browser_keeps_connections_for_stop_and_all_together_have_a_limit() -> None:
    streams = EventStreams(lambda _one: None)
    with contextlib.ExitStack() as others:
        with contextlib.ExitStack() as own:
            for _number in range(3):
                own.enter_context(streams.watching(person()))
            with pytest.raises(BusyError, match="at most 3 in one browser, 64 in all") as refused:
                own.enter_context(streams.watching(person()))
            assert refused.value.message.fault_code == "web.bad_request"
            assert streams.has("one") and not streams.has("other")
        assert not streams.has("one")
        for number in range(MAX_STREAMS):
            others.enter_context(streams.watching(person(str(number))))
        with pytest.raises(BusyError):
            others.enter_context(streams.watching(person("another")))

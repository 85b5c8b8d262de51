"""What browsers that watch are sent, and when."""

from __future__ import annotations

import asyncio
import functools
import json
from typing import Any, Callable, Dict, List

import pytest

from gpr20_common.message import Message
from gpr20_web.calls import Person, Role, Stream
from gpr20_web.errors import BusyError, NotLoggedInError
from gpr20_web.low import event_streams
from gpr20_web.low.event_streams import MAX_STREAMS_OF_PERSON, EventStreams

LIMIT_S = 100.0


class Browser:
    """Takes what is sent; a slow one takes nothing until it is let."""

    def __init__(self, slow: bool = False) -> None:
        self.known: Dict[str, Any] = {}
        self.sent: List[Dict[str, Any]] = []
        self._free = asyncio.Event()
        if not slow:
            self._free.set()

    def write(self, chunk: bytes) -> None:
        assert chunk.startswith(b"data: ") and chunk.endswith(b"\n\n")
        self.sent.append(json.loads(chunk[len(b"data: ") :]))

    async def flush(self) -> None:
        await self._free.wait()
        for one in self.sent:
            self.known.update(one)

    def let(self) -> None:
        self._free.set()


def person(name: str = "ana", session: str = "one") -> Person:
    return Person(name, Role.WATCH, session, "")


def in_loop(test: Callable[..., Any]) -> Callable[..., None]:
    """Run a test in a loop of its own."""

    @functools.wraps(test)
    def run(**fixtures: Any) -> None:
        asyncio.run(asyncio.wait_for(test(**fixtures), LIMIT_S))

    return run


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await asyncio.sleep(0.01)


@in_loop
async def test_slow_browser_gets_the_newest_state_and_none_of_those_between() -> None:
    document: Dict[str, Any] = {"number": 0, "same": 1}
    streams, slow, quick = EventStreams(lambda _one: None, print), Browser(True), Browser()
    for one in (slow, quick):
        streams.add(one, Stream(lambda: dict(document)), person())
    running = asyncio.ensure_future(streams.run())
    for number in range(1, 6):
        document["number"] = number
        await until(lambda: quick.known.get("number") == number)  # noqa: B023
    assert len(slow.sent) == 1
    assert [one["number"] for one in quick.sent if "number" in one] == list(range(1, 6))
    slow.let()
    await until(lambda: slow.known.get("number") == 5)
    assert len(slow.sent) == 2
    running.cancel()


@in_loop
async def test_state_that_is_no_longer_made_is_not_sent_as_new() -> None:
    streams, browser = EventStreams(lambda _one: None, print), Browser()
    streams.add(browser, Stream(lambda: {"a": 1}), person())
    streams.fresh_s = 7.0
    running = asyncio.ensure_future(streams.run())
    await until(lambda: len(browser.sent) == 2)
    running.cancel()
    assert [one["sent_ms"] for one in browser.sent] == [7000, 7000]


@in_loop
async def test_what_changes_all_the_time_waits_for_the_sign_of_life_or_for_what_matters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    document = {"state": "works", "stored": 0}
    streams, browser, other = EventStreams(lambda _one: None, print), Browser(), Browser()
    streams.add(browser, Stream(lambda: dict(document), frozenset({"stored"})), person())
    streams.add(other, Stream(lambda: dict(document)), person())
    running = asyncio.ensure_future(streams.run())
    await until(lambda: len(browser.sent) == 1)
    document["stored"] = 1
    await until(lambda: browser.known.get("stored") == 1)
    monkeypatch.setattr(event_streams, "SIGN_OF_LIFE_S", 1e6)
    # Another browser is sent them: there were as many times to send to this one.
    for number in (2, 3, 4):
        document["stored"] = number
        await until(lambda: other.known.get("stored") == number)  # noqa: B023
    assert len(browser.sent) == 2
    document["state"] = "stopped"
    await until(lambda: browser.known.get("state") == "stopped")
    running.cancel()
    assert browser.known["stored"] == 4


@in_loop
async def test_stream_ends_with_its_session(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(event_streams, "SESSION_CHECK_S", 0.0)

    def check(one: Person) -> None:
        if one.session == "over":
            raise NotLoggedInError(Message("over"))

    streams = EventStreams(check, print)
    over = streams.add(Browser(), Stream(dict), person(session="over"))
    valid = streams.add(Browser(), Stream(dict), person())
    running = asyncio.ensure_future(streams.run())
    await over.gone.wait()
    assert not valid.gone.is_set()
    running.cancel()


@in_loop
async def test_document_that_cannot_be_made_ends_its_stream_and_no_other() -> None:
    reported: List[BaseException] = []

    def broken() -> Dict[str, Any]:
        raise ZeroDivisionError

    streams, other = EventStreams(lambda _one: None, reported.append), Browser()
    watcher = streams.add(Browser(), Stream(broken), person())
    streams.add(other, Stream(lambda: {"a": 1}), person())
    running = asyncio.ensure_future(streams.run())
    await watcher.gone.wait()
    await until(lambda: other.known.get("a") == 1)
    assert isinstance(reported[0], ZeroDivisionError)
    running.cancel()


@in_loop
async def test_one_person_cannot_take_all_streams_and_a_browser_keeps_connections_for_stop() -> (
    None
):
    streams = EventStreams(lambda _one: None, print)
    first = streams.add(Browser(), Stream(dict), person())
    for _ in range(2):
        streams.add(Browser(), Stream(dict), person())
    with pytest.raises(BusyError, match="at most 3 in one browser"):
        streams.add(Browser(), Stream(dict), person())
    streams.remove(first)
    for number in range(MAX_STREAMS_OF_PERSON - 2):
        streams.add(Browser(), Stream(dict), person(session=str(number)))
    with pytest.raises(BusyError, match="30 of one account, 64 in all") as refused:
        streams.add(Browser(), Stream(dict), person())
    assert refused.value.message.fault_code == "web.bad_request"
    streams.add(Browser(), Stream(dict), person("ben"))

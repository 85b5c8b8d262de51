"""What the server does with any route, over a real socket; rights and OWASP: test_routes."""

from __future__ import annotations

import contextlib
import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Dict, Iterator

import pytest
from wait_kit import wait_until
from web_kit import COOKIE, LIMIT_S, Site

from gpr20_common.low.links import end_when_broken
from gpr20_common.message import Message
from gpr20_web.calls import Call, Document, Role, Route
from gpr20_web.faults import NotNowError
from gpr20_web.low import http_server
from gpr20_web.low.http_server import THREADS


def _fail(_call: Call) -> Any:
    raise ZeroDivisionError("secret of the program")


def _refuse(_call: Call) -> Any:
    raise NotNowError(Message("not {when}", when="now"))


ROUTES = [
    Route("POST", "/api/sent", Role.NOBODY, lambda call: call.values),
    Route("GET", "/api/fail", Role.NOBODY, _fail),
    Route("GET", "/api/fail_in_thread", Role.NOBODY, _fail, blocking=True),
    Route("GET", "/api/refuse", Role.NOBODY, _refuse),
]


@pytest.fixture(scope="module")
def site() -> Iterator[Site]:
    running = Site(ROUTES)
    yield running
    running.close()


def test_too_many_connections_are_closed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_server, "MAX_CONNECTIONS", 2)
    with contextlib.closing(Site(ROUTES)) as site, contextlib.ExitStack() as kept:
        for _number in range(2):
            connection = kept.enter_context(contextlib.closing(site.connect()))
            connection.request("GET", "/api/refuse")
            connection.getresponse().read()
        with pytest.raises(ConnectionError):
            site.ask("GET", "/api/refuse")


def test_refusal_says_reason_and_remedy_and_a_fault_of_the_program_nothing(site: Site) -> None:
    reply = site.ask("GET", "/api/refuse")
    assert (reply.status, reply.values["code"]) == (409, "web.not_now")
    assert reply.values["error"] == "not now" and reply.values["remedy"]
    for path in ("/api/fail", "/api/fail_in_thread"):
        reply = site.ask("GET", path)
        assert reply.status == 500 and b"secret" not in reply.body
        assert isinstance(site.reported.pop(), ZeroDivisionError)
    for body in (b"[]", b"nonsense", b"[" * 60_000, b"\xff\xfe"):
        assert site.ask("POST", "/api/sent", body=body).values["code"] == "web.bad_request"


def test_login_does_not_wait_for_what_others_wait_for() -> None:
    go, begun = threading.Event(), threading.Semaphore(0)

    def hang(_call: Call) -> Dict[str, Any]:
        begun.release()
        assert go.wait(2 * LIMIT_S)  # longer than a browser
        return {}

    login = Route("POST", "/api/login", Role.NOBODY, lambda _call: {"in": True}, blocking=True)
    routes = (Route("GET", "/api/slow", Role.WATCH, hang, blocking=True), login)
    with contextlib.closing(Site(routes)) as site, ThreadPoolExecutor(THREADS + 1) as pool:
        try:
            for _number in range(THREADS + 1):
                pool.submit(site.ask, "GET", "/api/slow", session="watch")
            for _number in range(THREADS):
                assert begun.acquire(timeout=LIMIT_S)
            assert site.ask("POST", "/api/login").values == {"in": True}
        finally:
            go.set()


def test_a_browser_that_leaves_or_vanishes_while_it_is_sent_to_is_gone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    limits = []

    def note(connection: socket.socket, limit_s: float) -> None:
        end_when_broken(connection, limit_s)
        options = (socket.TCP_USER_TIMEOUT, socket.TCP_KEEPIDLE)
        limits.append([connection.getsockopt(socket.IPPROTO_TCP, one) for one in options])

    monkeypatch.setattr(http_server, "end_when_broken", note)
    document = Document(f'"a":"{"x" * 50_000_000}",')  # more than the connection takes
    route = Route("GET", "/api/live", Role.WATCH, lambda _call: lambda: document)
    with contextlib.closing(Site([route])) as site:

        async def beat() -> int:
            site.server.streams.beat()
            return len(site.server.streams)

        with contextlib.closing(site.connect()) as connection:
            connection.request("GET", "/api/live", headers={"Cookie": f"{COOKIE}=watch"})
            assert connection.getresponse().status == 200
            assert site.call(beat()) == 1
        wait_until(lambda: site.call(beat()) == 0, "it is gone")
    assert limits == [[10_000, 1]]

"""What the server does with any route, over a real socket; rights and OWASP: test_routes."""

from __future__ import annotations

import contextlib
import http.client
import json
import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Dict, Iterator, List

import pytest
from fault_kit import raises_fault
from tornado import httputil, netutil
from wait_kit import wait_until
from web_kit import COOKIE, LIMIT_S, Site

from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.links import end_when_broken
from gpr20_common.message import Message
from gpr20_web.calls import Call, Document, File, Role, Route
from gpr20_web.faults import NotNowError, SetupError
from gpr20_web.low import http_server
from gpr20_web.low.http_server import THREADS


def _fail(_call: Call) -> Any:
    raise ZeroDivisionError("secret of the program")


def _refuse(_call: Call) -> Any:
    raise NotNowError(Message("not {when}", when="now"))


ROUTES = [
    Route("GET", "/api/nobody", Role.NOBODY, lambda _call: {"ok": True}),
    Route("POST", "/api/nobody", Role.NOBODY, lambda call: dict(call.values)),
    Route("GET", "/api/fail", Role.NOBODY, _fail),
    Route("GET", "/api/fail_in_thread", Role.NOBODY, _fail, blocking=True),
    Route("GET", "/api/refuse", Role.NOBODY, _refuse),
    Route("GET", "/api/live", Role.WATCH, lambda _call: lambda: Document('"a":1,')),
]


@pytest.fixture(scope="module")
def site() -> Iterator[Site]:
    running = Site(ROUTES, files={"/": File(b"<script>1</script>", "text/html")})
    yield running
    running.close()


def test_no_form_is_read(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    read: List[str] = []
    monkeypatch.setattr(
        httputil, "parse_body_arguments", lambda kind, *_rest, **_more: read.append(kind)
    )
    form = b'--x\r\nContent-Disposition: form-data; name="' + b";" * 60_000 + b'"\r\n\r\n\r\n--x--'
    for path in ("/nowhere", "/api/nobody"):
        headers = {"Content-Type": "multipart/form-data; boundary=x"}
        assert site.ask("POST", path, session="", headers=headers, body=form).status in (
            403,
            404,
            405,
        )
    assert read == []


def test_too_many_connections_are_closed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_server, "MAX_CONNECTIONS", 2)
    with contextlib.closing(Site(ROUTES)) as site:
        kept = [site.connect() for _number in range(2)]
        for one in kept:
            one.request("GET", "/api/nobody")
            one.getresponse().read()
        with pytest.raises((http.client.RemoteDisconnected, ConnectionError)):
            site.ask("GET", "/api/nobody")
        for one in kept:
            one.request("GET", "/api/nobody")
            assert one.getresponse().read()
            one.close()


def test_a_file_that_the_browser_has_is_not_sent_again(site: Site) -> None:
    tag = site.ask("GET", "/").headers["ETag"]
    assert site.ask("GET", "/", headers={"If-None-Match": tag}).status == 304


def test_refusal_says_reason_and_remedy_and_a_fault_of_the_program_nothing(site: Site) -> None:
    reply = site.ask("GET", "/api/refuse")
    assert (reply.status, reply.values["code"]) == (409, "web.not_now")
    assert reply.values["error"] == "not now" and reply.values["remedy"]
    for path in ("/api/fail", "/api/fail_in_thread"):
        reply = site.ask("GET", path)
        assert reply.status == 500 and b"secret" not in reply.body
        assert isinstance(site.reported.pop(), ZeroDivisionError)


def test_an_answer_is_in_the_language_that_the_page_asks_for(site: Site) -> None:
    spanish = site.ask("GET", "/api/refuse?language=es").values["remedy"]
    assert spanish != site.ask("GET", "/api/refuse?language=xx").values["remedy"]
    reply = site.ask("GET", "/api/nothing?language=es")
    assert (reply.status, reply.values["error"]) == (404, "no hay ninguna página /api/nothing")
    assert site.ask("GET", "/nothing.js").status == 404


def test_a_query_or_a_body_that_is_none_is_refused_with_what_is_allowed(site: Site) -> None:
    assert site.ask("GET", "/api/nobody?language=%ff").status == 200
    assert site.ask("GET", "/api/nobody?a=%ff").values["code"] == "web.bad_request"
    for body in (b"[]", b"nonsense", b"[" * 60_000, b"\xff\xfe"):
        assert site.ask("POST", "/api/nobody", body=body).status == 400


def test_an_address_that_cannot_be_had_is_named_with_where_it_stands(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def listen(address: str) -> None:
        site.server.listen(address, site.port, None)

    for address in ("127.0.0.1", "203.0.113.9"):  # taken; of another computer
        with raises_fault(CONFIGURATION, address, site.port, "web.yaml", error=SetupError):
            site.call(listen(address))
    monkeypatch.setattr(netutil, "bind_sockets", lambda _port, _address: [])
    with pytest.raises(SetupError):
        site.server.listen("::1", 0, None)


def test_a_stream_sends_all_first_and_a_browser_that_vanishes_is_gone_after_ten_seconds(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    limited = []

    def note(connection: socket.socket, limit_s: float) -> None:
        end_when_broken(connection, limit_s)
        options = (socket.TCP_USER_TIMEOUT, socket.TCP_KEEPIDLE)
        limited.append([connection.getsockopt(socket.IPPROTO_TCP, one) for one in options])

    monkeypatch.setattr(http_server, "end_when_broken", note)
    with contextlib.closing(site.connect()) as connection:
        connection.request("GET", "/api/live", headers={"Cookie": f"{COOKIE}=watch"})
        response = connection.getresponse()
        assert response.headers["Content-Type"] == "text/event-stream"
        line = response.readline()
        assert line.startswith(b"data: ") and response.readline() == b"\n"
        assert json.loads(line[len(b"data: ") :])["a"] == 1
    assert limited == [[10_000, 1]]


def test_login_does_not_wait_for_what_others_wait_for() -> None:
    go, begun = threading.Event(), threading.Semaphore(0)

    def hang(_call: Call) -> Dict[str, Any]:
        begun.release()
        assert go.wait(LIMIT_S)
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


def test_a_browser_that_leaves_while_it_is_sent_to_is_gone() -> None:
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

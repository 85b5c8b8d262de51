"""Rights, origin, headers and files of the page, over a real socket."""

from __future__ import annotations

import http.client
import json
import re
import socket
import threading
from typing import Any, Dict, Iterator, List

import pytest
from tornado import httputil, netutil
from web_kit import COOKIE, LIMIT_S, Site

from gpr20_common.low.tcp_keepalive import end_when_broken
from gpr20_common.message import Message
from gpr20_web.calls import Body, Call, Cookie, Route, Stream
from gpr20_web.errors import NotNowError, PortTakenError
from gpr20_web.low import http_server, table_handler
from gpr20_web.low.http_server import THREADS
from gpr20_web.roles import Role

DOCUMENT = {"band": {"title": "rest"}, "many": list(range(10))}


def _fail(_call: Call) -> Any:
    raise ZeroDivisionError("secret of the program")


def _refuse(_call: Call) -> Any:
    raise NotNowError(Message("not {when}", when="now"))


def _parts() -> Iterator[bytes]:
    for number in range(3):
        yield bytes([number]) * 100_000


ROUTES = [
    *(Route("GET", f"/api/{role.word}", role, lambda call: {"ok": True}) for role in Role),
    *(Route("POST", f"/api/{role.word}", role, lambda call: dict(call.values)) for role in Role),
    *(Route("DELETE", f"/api/{role.word}", role, lambda call: {}) for role in Role),
    Route("GET", "/api/fail", Role.NOBODY, _fail),
    Route("GET", "/api/fail_in_thread", Role.NOBODY, _fail, blocking=True),
    Route("GET", "/api/refuse", Role.NOBODY, _refuse),
    Route("GET", "/api/thread", Role.NOBODY, lambda _call: {"t": _name()}, blocking=True),
    Route("GET", "/api/parts", Role.VIEW, lambda _call: Body(_parts(), "x/y", "a.zip")),
    Route("POST", "/api/enter", Role.NOBODY, lambda _call: Cookie("secret")),
    Route("POST", "/api/leave", Role.NOBODY, lambda _call: Cookie("")),
    Route("GET", "/api/part/(?P<name>[a-z]+)", Role.NOBODY, lambda call: dict(call.parts)),
    Route("GET", "/api/live", Role.VIEW, lambda _call: Stream(lambda: DOCUMENT)),
]


def _name() -> str:
    return threading.current_thread().name


@pytest.fixture(scope="module")
def site() -> Iterator[Site]:
    running = Site(ROUTES)
    yield running
    running.close()


@pytest.mark.parametrize("method", ["GET", "POST", "DELETE"])
@pytest.mark.parametrize("needed", list(Role))
@pytest.mark.parametrize("role", list(Role))
def test_each_role_may_do_what_needs_it_or_less(
    site: Site, method: str, needed: Role, role: Role
) -> None:
    session = "" if role is Role.NOBODY else role.word
    reply = site.ask(method, f"/api/{needed.word}", {}, session)
    if role >= needed:
        assert reply.status == 200
    else:
        assert reply.status == (401 if role is Role.NOBODY else 403)


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": None},
        {"Origin": "null"},
        {"Origin": "https://evil.example"},
        {"Origin": "http://127.0.0.1"},
        {"Content-Type": "text/plain"},
        {"Content-Type": "application/x-www-form-urlencoded"},
        {"Content-Type": None},
    ],
)
def test_a_request_that_another_page_could_send_changes_nothing(site: Site, headers: Any) -> None:
    reply = site.ask("POST", "/api/admin", {}, "admin", headers)
    assert reply.status == 403


def test_no_form_is_read(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    read: List[str] = []
    monkeypatch.setattr(
        httputil, "parse_body_arguments", lambda kind, *_rest, **_more: read.append(kind)
    )
    form = b'--x\r\nContent-Disposition: form-data; name="' + b";" * 60_000 + b'"\r\n\r\n\r\n--x--'
    for path in ("/nowhere", "/api/nobody"):
        headers = {"Content-Type": "multipart/form-data; boundary=x"}
        assert site.ask("POST", path, session="", headers=headers, body=form).status in (403, 404)
    assert read == []


def test_too_many_connections_are_closed_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_server, "MAX_CONNECTIONS", 2)
    site = Site(ROUTES)
    try:
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
    finally:
        site.close()


def test_every_answer_forbids_frames_foreign_content_and_guessing_of_types(site: Site) -> None:
    for path in ("/", "/app.js", "/api/nobody", "/api/admin", "/api/fail", "/nowhere", "/api/x"):
        headers = site.ask("GET", path).headers
        assert headers["X-Frame-Options"] == "DENY"
        assert headers["X-Content-Type-Options"] == "nosniff"
        policy = headers["Content-Security-Policy"]
        assert "default-src 'self'" in policy and "unsafe" not in policy
        assert "Server" not in headers


def test_answers_with_data_are_not_kept_by_the_browser(site: Site) -> None:
    assert site.ask("GET", "/api/nobody").headers["Cache-Control"] == "no-store"


def test_cookie_is_for_this_host_secure_and_out_of_reach_of_scripts(site: Site) -> None:
    cookie = site.ask("POST", "/api/enter").headers["Set-Cookie"]
    assert cookie.startswith(f"{COOKIE}=secret;")
    for flag in ("HttpOnly", "Secure", "SameSite=Strict", "Path=/"):
        assert flag in cookie
    assert "Domain" not in cookie
    assert "expires=Thu, 01 Jan 1970" in site.ask("POST", "/api/leave").headers["Set-Cookie"]


@pytest.mark.parametrize(
    "path",
    [
        "/../errors.py", "/%2e%2e/errors.py", "/pages/../../errors.py", "/static/app.js",
        "//etc/passwd", "/etc/passwd", "/..%2f..%2ferrors.py", "/app.js%00.txt", "/pages",
        "/%ff", "/index.html/..", "/\\..\\errors.py",
    ],
)  # fmt: skip
def test_only_files_of_the_page_are_served(site: Site, path: str) -> None:
    assert site.ask("GET", path).status in (400, 404)


def test_file_that_the_browser_has_is_not_sent_again(site: Site) -> None:
    tag = site.ask("GET", "/app.js").headers["ETag"]
    assert site.ask("GET", "/app.js", headers={"If-None-Match": tag}).status == 304


@pytest.mark.parametrize("path", ["/api/fail", "/api/fail_in_thread"])
def test_fault_of_the_program_is_reported_and_not_shown(site: Site, path: str) -> None:
    reply = site.ask("GET", path)
    assert reply.status == 500 and b"secret" not in reply.body
    assert isinstance(site.reported.pop(), ZeroDivisionError)


def test_refusal_says_reason_remedy_and_code(site: Site) -> None:
    reply = site.ask("GET", "/api/refuse")
    assert reply.status == 409
    assert reply.values["error"] == "not now" and reply.values["code"] == "web.not_now"
    assert reply.values["remedy"]


def test_blocking_route_has_a_thread_of_its_own(site: Site) -> None:
    assert site.ask("GET", "/api/thread").values["t"].startswith(("web", "login"))


def test_language_of_the_page_counts_then_that_of_the_browser(site: Site) -> None:
    spanish = site.ask("GET", "/api/refuse?language=es").values["remedy"]
    assert (
        spanish
        == site.ask("GET", "/api/refuse", headers={"Accept-Language": "es-PE,en;q=0.5"}).values[
            "remedy"
        ]
    )
    assert spanish != site.ask("GET", "/api/refuse?language=xx").values["remedy"]


def test_an_unknown_path_is_said_in_the_language_of_the_page(site: Site) -> None:
    for path in ("/api/nothing", "/nothing.js"):
        reply = site.ask("GET", f"{path}?language=es")
        assert (reply.status, reply.values["error"]) == (404, f"no hay ninguna página {path}")


@pytest.mark.parametrize("query", ["language=%ff", "&".join(f"a{n}=1" for n in range(33))])
@pytest.mark.parametrize("path", ["/api/nobody", "/api/nothing", "/"])
def test_a_query_that_is_none_is_refused_with_what_is_allowed(
    site: Site, path: str, query: str
) -> None:
    reply = site.ask("GET", f"{path}?{query}")
    assert (reply.status, "more than 32 fields" in reply.values["error"]) == (400, True)


@pytest.mark.parametrize(
    "body", [b"[]", b"nonsense", b'"text"', b'{"a": NaN}', b"[" * 60_000, b"\xff\xfe"]
)
def test_body_that_is_no_json_object_is_refused(site: Site, body: bytes) -> None:
    assert site.ask("POST", "/api/nobody", body=body).status == 400


def test_body_that_is_too_large_is_refused(site: Site) -> None:
    try:
        status = site.ask("POST", "/api/nobody", body=b"x" * 100_000).status
    except (ConnectionError, OSError):
        return  # the server has closed the connection
    assert status in (400, 413)


def test_download_comes_whole_and_named(site: Site) -> None:
    reply = site.ask("GET", "/api/parts", session="view")
    assert reply.body == b"".join(_parts())
    assert reply.headers["Content-Disposition"] == 'attachment; filename="a.zip"'


def test_parts_of_the_path_reach_the_route(site: Site) -> None:
    assert site.ask("GET", "/api/part/abc").values == {"name": "abc"}
    assert site.ask("GET", "/api/part/ABC").status == 404


@pytest.mark.parametrize(
    ("address", "reason"),
    [("127.0.0.1", "another program"), ("203.0.113.9", "no address of this computer")],
)
def test_an_address_that_cannot_be_had_says_which_why_and_what_to_do(
    site: Site, address: str, reason: str
) -> None:
    async def listen() -> None:
        site.server.listen(address, site.port, None)

    with pytest.raises(PortTakenError, match=reason) as refused:
        site.call(listen())
    said = refused.value.message.sentence()
    assert address in said and str(site.port) in said and "web.yaml" in said


def test_stream_sends_all_first_and_then_what_changes(site: Site) -> None:
    connection = site.connect()
    connection.request("GET", "/api/live", headers={"Cookie": f"{COOKIE}=view"})
    response = connection.getresponse()
    assert response.headers["Content-Type"] == "text/event-stream"
    first = _event(response)
    assert first["band"] == {"title": "rest"} and first["many"] == DOCUMENT["many"]
    DOCUMENT["band"] = {"title": "moves"}
    second = _event(response)
    while "band" not in second:
        assert set(second) == {"sent_ms"}
        second = _event(response)
    assert second["band"] == {"title": "moves"} and "many" not in second
    connection.close()


def test_browser_that_watches_and_vanishes_is_gone_after_ten_seconds(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    limited = []

    def note(connection: socket.socket, limit_s: float) -> None:
        end_when_broken(connection, limit_s)
        options = (socket.TCP_USER_TIMEOUT, socket.TCP_KEEPIDLE)
        limited.append([connection.getsockopt(socket.IPPROTO_TCP, one) for one in options])

    monkeypatch.setattr(table_handler, "end_when_broken", note)
    assert site.ask("GET", "/api/live", session="view").status == 200
    assert limited == [[10_000, 1]]


def _event(response: Any) -> Any:
    line = response.readline()
    assert re.match(rb"data: \{", line)
    assert response.readline() == b"\n"
    return json.loads(line[len(b"data: ") :])


def test_login_does_not_wait_for_what_others_wait_for() -> None:
    go, begun = threading.Event(), threading.Semaphore(0)

    def hang(_call: Call) -> Dict[str, Any]:
        begun.release()
        assert go.wait(LIMIT_S)
        return {}

    login = Route("POST", "/api/login", Role.NOBODY, lambda _call: {"in": True}, blocking=True)
    site = Site((Route("GET", "/api/slow", Role.VIEW, hang, blocking=True), login))
    waiting = [
        threading.Thread(target=site.ask, args=("GET", "/api/slow", None, "view"), daemon=True)
        for _number in range(THREADS + 1)
    ]
    try:
        for one in waiting:
            one.start()
        for _number in range(THREADS):
            assert begun.acquire(timeout=LIMIT_S)
        assert site.ask("POST", "/api/login").values == {"in": True}
    finally:
        go.set()
        for one in waiting:
            one.join(LIMIT_S)
        site.close()


def test_ipv6_address_without_ipv6_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(netutil, "bind_sockets", lambda _port, _address: [])
    with pytest.raises(PortTakenError):
        Site(())

"""Who may what, by a table that was written by hand; and what OWASP lists against web sites.

Each over a real socket. Cookies and passwords are in test_login and test_accounts; a
real page of another origin is in scripts/test/test_web_page.py.
"""

from __future__ import annotations

import contextlib
import re
from typing import Iterator, List, Mapping, Optional, Sequence
from uuid import uuid4

import pytest
from case_kit import each_case
from web_kit import COOKIE, PASSWORD, STATIC, Reply
from whole_page_kit import PEOPLE, TABLE, Row, S, WholePage, is_without_right

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Role
from gpr20_web.low.http_server import MAX_BODY_BYTES, MAX_HEADER_BYTES

NOBODY, WATCH, CONTROL = Role
OF_OTHERS: Sequence[Mapping[str, Optional[str]]] = tuple(
    {"Sec-Fetch-Site": one} for one in ("same-site", "cross-site")
)
WITHOUT_ORIGIN: Sequence[Mapping[str, Optional[str]]] = (
    *({"Origin": one} for one in (None, "null", "https://other.example")),
    *({"Content-Type": one} for one in (None, "text/plain", "application/x-www-form-urlencoded")),
)
FILES = [f"/{one.relative_to(STATIC).as_posix()}" for one in STATIC.rglob("*") if one.is_file()]
BAD = b"HTTP/1.1 400"


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WholePage]:
    with contextlib.closing(WholePage(tmp_path_factory.mktemp("page"))) as made:
        yield made
    assert made.foreign == []


@pytest.fixture
def page(shared: WholePage) -> WholePage:
    shared.renew()
    return shared


def _path(page: WholePage, row: Row) -> str:
    return row.path.format(folder=page.surveys.whole)


def test_the_table_has_every_route_and_every_route_is_in_the_table(page: WholePage) -> None:
    known = set()
    for row in TABLE:
        path = _path(page, row)
        routes = [one for one in page.routes if one.method == row.method]
        (route,) = [one for one in routes if re.fullmatch(one.pattern, path)]
        known.add(id(route))
    assert [one.pattern for one in page.routes if id(one) not in known] == []


@each_case("row", TABLE)
def test_each_route_is_for_the_roles_of_the_table_and_for_no_other_page(
    page: WholePage, row: Row
) -> None:
    for role in Role:
        page.renew()
        before = page.done()
        reply = page.ask(row.method, _path(page, row), role, row.values)
        assert is_without_right(reply) is (role < row.right)
        if role < row.right:
            assert reply.status == (401 if role is NOBODY else 403)
            assert page.done() == before
    page.renew()
    before = page.done()
    for headers in OF_OTHERS if row.method == "GET" else (*OF_OTHERS, *WITHOUT_ORIGIN):
        reply = page.ask(row.method, _path(page, row), CONTROL, row.values, headers=headers)
        assert (reply.status, reply.values["code"]) == (403, "web.bad_request")
    assert page.done() == before


# These change nothing here, or need a search or somebody who asks: other tests have them.
NOT_HERE = (
    "/api/login",
    "/api/logout",
    "/api/control/take",
    f"{S}/found",
)
STATES = {"/api/pause": SurveyState.SURVEYING, "/api/resume": SurveyState.PAUSED}
CHANGES = [one for one in TABLE if one.method != "GET" and one.path not in NOT_HERE]


@each_case("row", CHANGES)
def test_who_may_do_something_does_it(page: WholePage, row: Row) -> None:
    role = max(row.right, WATCH)
    page.renew()
    page.be(STATES.get(row.path, SurveyState.CONFIGURED))
    page.lease.holder = page.person(role)
    before = page.done()
    pressed = {"press": uuid4().hex, "pressed_ms": 1e3 * page.clock.time_s}
    reply = page.ask(row.method, _path(page, row), role, {**row.values, **pressed})
    assert reply.status == 200, reply.body
    assert page.done() != before


def _head(page: WholePage, line: str, *more: str) -> bytes:
    """Return a request of somebody who may do all, up to its body."""
    own = [f"Host: 127.0.0.1:{page.site.port}", f"Origin: {page.site.origin}"]
    own += ["Content-Type: application/json", "Connection: close"]
    own.append(f"Cookie: {COOKIE}={page.session(CONTROL)}")
    return "\r\n".join([line, *own, *more, "", ""]).encode()


@pytest.fixture(scope="module")
def answers(shared: WholePage) -> List[Reply]:
    """What comes from every GET of the table, from files, and from what is not there."""
    shared.renew()
    paths = [_path(shared, one) for one in TABLE if one.method == "GET"]
    asked = [(one, role) for one in paths for role in (NOBODY, CONTROL)]
    asked += [(one, NOBODY) for one in (*FILES, "/", "/nowhere", "/api/nowhere", "/%ff")]
    asked += [
        (one, NOBODY) for one in ("//other.example", "/\\other.example", "/?next=//o.example")
    ]
    return [shared.ask("GET", path, role) for path, role in asked]


def test_no_answer_may_be_in_a_frame_guessed_at_kept_or_lead_elsewhere(
    answers: List[Reply],
) -> None:
    contents = [(STATIC / one[1:]).read_bytes() for one in FILES]
    for reply in answers:
        assert reply.headers["X-Frame-Options"] == "DENY"
        assert reply.headers["X-Content-Type-Options"] == "nosniff"
        policy = reply.headers["Content-Security-Policy"]
        assert "frame-ancestors 'none'" in policy
        assert "default-src 'self'" in policy and "unsafe" not in policy
        assert reply.headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert reply.status // 100 != 3
        assert not {"Location", "Refresh", "Server"} & set(reply.headers)
        # No file is used without asking.
        kept = "no-cache" if reply.body in contents else "no-store"
        assert reply.headers["Cache-Control"] == kept


def test_error_pages_say_nothing_of_the_program(page: WholePage, answers: List[Reply]) -> None:
    sent = [
        *(b"\0\0\0\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n"),
        b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n",
        *(_head(page, f"{one} /api/me HTTP/1.1") for one in ("PUT", "BREW", "CONNECT", "get")),
        _head(page, "GET /api/surveys?before=../.. HTTP/1.1"),
        _head(page, "POST /api/stop HTTP/1.1", "Content-Length: 5") + b"[[[[[",
    ]
    found = [page.exchange(one) for one in sent]
    for answer in (*found, *(one.body for one in answers if one.status >= 400)):
        words = (b"Traceback", b"tornado", b"python", b".py", b"line ", b"Server:", b"/work")
        assert not [one for one in words if one.lower() in answer.lower()]


@each_case("up", ["..", "%2e%2e", "%252e%252e", "..%00", "%c0%ae%c0%ae", "..\\", "....", "..%2f.."])
def test_path_traversal_nothing_outside_is_reached(page: WholePage, up: str) -> None:
    secret = page.folder / "web" / "accounts.json"
    for path in ("/pages", "/pages/", "/.", "/pages/..", "/api", "/api/", "/api/surveys/"):
        assert page.ask("GET", path, CONTROL).status == 404
    starts = ("/", "/pages/", "/api/surveys/", f"/api/surveys/{page.surveys.whole}/made/")
    for start in starts:
        for name in (f"{up}/errors.py", f"{up}/" * 4 + "etc/passwd", f"{up}/{secret}"):
            line = f"GET {start}{name} HTTP/1.1"
            answer = page.exchange(_head(page, line))
            assert re.match(rb"HTTP/1.1 (400|403|404) ", answer), line
            assert b"hash" not in answer and b"root:" not in answer


def test_upload_limits_more_than_the_page_sends_is_refused(page: WholePage) -> None:
    before = page.done()
    for path in ("/api/login", "/api/stop", f"/api/surveys/{page.surveys.whole}/notes"):
        for size in (MAX_BODY_BYTES + 1, 10**12, 10**40):
            answer = page.exchange(_head(page, f"POST {path} HTTP/1.1", f"Content-Length: {size}"))
            assert answer == b"" or answer.startswith(BAD)
    long = page.exchange(_head(page, "GET / HTTP/1.1", f"X: {'a' * MAX_HEADER_BYTES}"))
    assert long == b"" or re.match(rb"HTTP/1.1 4(00|31) ", long)
    assert page.done() == before


def test_user_enumeration_a_known_and_an_unknown_name_are_answered_alike(page: WholePage) -> None:
    page.wait(10_000.0)
    page.renew()
    answers = []
    for name in ("vera", "nobody.here"):
        values = {"name": name, "password": "wrong horse battery"}
        replies = [page.ask("POST", "/api/login", NOBODY, values) for _ in range(6)]
        answers.append([(one.status, one.values) for one in replies])
        page.wait(10_000.0)
    assert answers[0] == answers[1]
    assert answers[0][0][0] == 401 and answers[0][-1][0] == 429


@each_case(
    "framing",
    [
        ("Content-Length: 4", "Transfer-Encoding: chunked"),
        ("Transfer-Encoding: chunked", "Content-Length: 4"),
        ("Content-Length: 4", "Content-Length: 5"),
        *((f"Content-Length: {one}",) for one in ("+4", "0x4", "4_0", "-1", "٤", "4\r\n 5")),
        *(
            (f"Transfer-Encoding: {one}",)
            for one in ("xchunked", "chunked, identity", "\x0bchunked")
        ),
        ("Transfer-Encoding : chunked",),
    ],
)
def test_request_smuggling_a_body_of_doubtful_length_ends_the_connection(
    page: WholePage, framing: Sequence[str]
) -> None:
    before = page.done()
    hidden = _head(page, "POST /api/stop HTTP/1.1", "Content-Length: 2") + b"{}"
    sent = _head(page, "POST /api/pause HTTP/1.1", *framing) + b"0\r\n\r\n" + hidden
    answer = page.exchange(sent)
    assert answer == b"" or answer.startswith(BAD)
    assert answer.count(b"HTTP/1.1 ") <= 1
    assert page.done() == before


def test_header_injection_no_name_reaches_the_headers_of_an_answer(page: WholePage) -> None:
    whole, evil = page.surveys.whole, "%0d%0aSet-Cookie:%20a=b"
    name = page.ask("GET", f"/api/surveys/{whole}/zip", CONTROL).headers["Content-Disposition"]
    assert re.fullmatch(r'attachment; filename="[\w.]+"', name)
    for path in (f"/{evil}", f"/api/surveys/{whole}{evil}/zip", f"/api/words?language={evil}"):
        assert "Set-Cookie" not in page.ask("GET", path, CONTROL).headers


def test_mass_assignment_fields_that_a_route_has_not_are_not_taken(page: WholePage) -> None:
    login = {"name": "vera", "password": PASSWORD, "role": "control", "person": "otto"}
    assert page.ask("POST", "/api/login", NOBODY, login).values["role"] == WATCH
    roles = {one.name: one.role for one in page.accounts.all() if one.name in PEOPLE.values()}
    assert roles == {name: role for role, name in PEOPLE.items()}

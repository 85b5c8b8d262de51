"""What OWASP lists against web sites, one test for each, on the whole page.

Sessions, cookies and passwords are in test_sessions, test_login_page, test_login_limits and
test_accounts; CSRF on every route is in test_routes; a real page of another origin is in
scripts/test/test_web_page.py.
"""

from __future__ import annotations

import re
from typing import Iterator, List

import pytest
from login_kit import OTHER_PASSWORD, PASSWORD
from route_table import TABLE, least_right
from web_kit import COOKIE, STATIC, Reply
from whole_page_kit import PEOPLE, WholePage

from gpr20_web.low.http_server import MAX_BODY_BYTES, MAX_HEADER_BYTES
from gpr20_web.roles import Role

ADMIN = Role.ADMIN
FILES = [f"/{one.relative_to(STATIC).as_posix()}" for one in STATIC.rglob("*") if one.is_file()]
BAD = b"HTTP/1.1 400"


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WholePage]:
    made = WholePage(tmp_path_factory.mktemp("page"))
    yield made
    made.close()
    assert made.foreign == []


@pytest.fixture
def page(shared: WholePage) -> WholePage:
    shared.renew()
    return shared


def _head(page: WholePage, line: str, *more: str, cookie: bool = True) -> bytes:
    """Return a request of an administrator up to its body."""
    own = [f"Host: 127.0.0.1:{page.site.port}", f"Origin: {page.site.origin}"]
    own += ["Content-Type: application/json", "Connection: close"]
    if cookie:
        own.append(f"Cookie: {COOKIE}={page.session(ADMIN)}")
    return "\r\n".join([line, *own, *more, "", ""]).encode()


def _every_answer(page: WholePage) -> List[Reply]:
    """Return what comes from every GET of the table, from files, and from what is not there."""
    paths = [one.path.format(folder=page.surveys.whole) for one in TABLE if one.method == "GET"]
    asked = [(one, role) for one in paths for role in (Role.NOBODY, ADMIN)]
    asked += [(one, Role.NOBODY) for one in (*FILES, "/", "/nowhere", "/api/nowhere", "/%ff")]
    return [page.ask("GET", path, role) for path, role in asked]


def test_clickjacking_no_answer_may_be_in_a_frame(page: WholePage) -> None:
    for reply in _every_answer(page):
        assert reply.headers["X-Frame-Options"] == "DENY"
        assert "frame-ancestors 'none'" in reply.headers["Content-Security-Policy"]
        assert reply.headers["Cross-Origin-Resource-Policy"] == "same-origin"


def test_caching_no_data_is_kept_and_no_file_is_used_without_asking(page: WholePage) -> None:
    contents = [(STATIC / one[1:]).read_bytes() for one in FILES]
    for reply in _every_answer(page):
        kept = reply.headers["Cache-Control"]
        assert kept == ("no-cache" if reply.body in contents else "no-store")


def test_open_redirect_nothing_leads_anywhere(page: WholePage) -> None:
    paths = ("//other.example", "/\\other.example", "/?next=//other.example", "/https://o.example")
    answers = [page.ask("GET", path, Role.NOBODY) for path in paths]
    for reply in (*answers, *_every_answer(page)):
        assert reply.status // 100 != 3
        assert "Location" not in reply.headers and "Refresh" not in reply.headers


def test_directory_listing_a_folder_is_not_there(page: WholePage) -> None:
    for path in ("/pages", "/pages/", "/.", "/pages/..", "/api", "/api/", "/api/surveys/"):
        assert page.ask("GET", path, ADMIN).status == 404


@pytest.mark.parametrize(
    "up", ["..", "%2e%2e", "%252e%252e", "..%00", "%c0%ae%c0%ae", "..\\", "...."]
)
def test_path_traversal_nothing_outside_is_reached(page: WholePage, up: str) -> None:
    secret = page.folder / "web" / "accounts.json"
    starts = ("/", "/pages/", "/api/surveys/", f"/api/surveys/{page.surveys.whole}/files/")
    for start in starts:
        for steps in (1, 4):
            for name in ("web/accounts.json", "errors.py", "etc/passwd", str(secret)):
                line = f"GET {start}{f'{up}/' * steps}{name} HTTP/1.1"
                answer = page.exchange(_head(page, line))
                assert re.match(rb"HTTP/1.1 (400|404) ", answer), line
                assert b"hash" not in answer and b"root:" not in answer


def test_upload_limits_more_than_the_page_sends_is_refused(page: WholePage) -> None:
    before = page.done()
    for row in TABLE:
        if row.method == "GET":
            continue
        path = row.path.format(folder=page.surveys.whole)
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
        replies = [page.ask("POST", "/api/login", Role.NOBODY, values) for _ in range(6)]
        answers.append([(one.status, one.values) for one in replies])
        page.wait(10_000.0)
    assert answers[0] == answers[1]
    assert answers[0][0][0] == 401 and answers[0][-1][0] == 429


def test_error_pages_say_nothing_of_the_program(page: WholePage) -> None:
    sent = [
        *(
            b"\0\0\0\r\n\r\n",
            b"GET\r\n\r\n",
            b"GET / HTTP/9.9\r\n\r\n",
            b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n",
        ),
        *(_head(page, f"{one} /api/me HTTP/1.1") for one in ("PUT", "BREW", "CONNECT", "get")),
        _head(page, "GET /api/surveys?before=../.. HTTP/1.1"),
        _head(page, "POST /api/stop HTTP/1.1", "Content-Length: 5") + b"[[[[[",
    ]
    answers = [page.exchange(one) for one in sent]
    for answer in (*answers, *(one.body for one in _every_answer(page) if one.status >= 400)):
        words = (b"Traceback", b"tornado", b"python", b".py", b"line ", b"Server:", b"/work")
        assert not [one for one in words if one.lower() in answer.lower()]


def test_verb_tampering_another_verb_does_nothing(page: WholePage) -> None:
    verbs = ("HEAD", "PUT", "post", "GET", "POST", "DELETE")
    more = ("X-HTTP-Method-Override: POST", "Content-Length: 2")
    before = page.done()
    for row in TABLE:
        path = row.path.format(folder=page.surveys.whole)
        for verb in verbs:
            if least_right(verb, path) is None:
                answer = page.exchange(_head(page, f"{verb} {path} HTTP/1.1", *more) + b"{}")
                assert re.match(rb"HTTP/1.1 40[0345] ", answer), (verb, path, answer)
    assert page.done() == before


@pytest.mark.parametrize(
    "framing",
    [
        ("Content-Length: 4", "Transfer-Encoding: chunked"),
        ("Transfer-Encoding: chunked", "Content-Length: 4"),
        ("Content-Length: 4", "Content-Length: 5"),
        ("Content-Length: +4",),
        ("Content-Length: 0x4",),
        ("Content-Length: 4_0",),
        ("Content-Length: -1",),
        ("Content-Length: ٤",),
        ("Transfer-Encoding: xchunked",),
        ("Transfer-Encoding: chunked, identity",),
        ("Transfer-Encoding : chunked",),
        ("Content-Length: 4\r\n 5",),
        ("Transfer-Encoding: \x0bchunked",),
    ],
    ids=str,
)
def test_request_smuggling_a_body_of_doubtful_length_ends_the_connection(
    page: WholePage, framing: List[str]
) -> None:
    before = page.done()
    hidden = _head(page, "POST /api/stop HTTP/1.1", "Content-Length: 2") + b"{}"
    answer = page.exchange(
        _head(page, "POST /api/pause HTTP/1.1", *framing) + b"0\r\n\r\n" + hidden
    )
    assert answer == b"" or answer.startswith(BAD)
    assert answer.count(b"HTTP/1.1 ") <= 1
    assert page.done() == before


def test_header_injection_no_name_reaches_the_headers_of_an_answer(page: WholePage) -> None:
    whole, evil = page.surveys.whole, "%0d%0aSet-Cookie:%20a=b"
    for path in (f"/api/surveys/{whole}/zip", f"/api/surveys/{whole}/files/survey.json"):
        name = page.ask("GET", path, ADMIN).headers["Content-Disposition"]
        assert re.fullmatch(r'attachment; filename="[\w.]+"', name)
    for path in (f"/{evil}", f"/api/surveys/{whole}{evil}/zip", f"/api/words?language={evil}"):
        assert "Set-Cookie" not in page.ask("GET", path, ADMIN).headers
    user = {"name": "eva\r\nSet-Cookie: a=b", "role": "view", "password": PASSWORD}
    assert page.ask("POST", "/api/users", ADMIN, user).status == 400


def test_mass_assignment_fields_that_a_route_has_not_are_not_taken(page: WholePage) -> None:
    more = {"role": "admin", "person": "ada", "session": page.session(ADMIN), "generation": 1}
    login = {"name": "vera", "password": PASSWORD, **more}
    assert page.ask("POST", "/api/login", Role.NOBODY, login).values["role"] == Role.VIEW
    changed = {"old": PASSWORD, "new": OTHER_PASSWORD, "name": "ada", **more}
    assert page.ask("POST", "/api/password", Role.VIEW, changed).values["name"] == "vera"
    roles = {one.name: one.role for one in page.accounts.all() if one.name in PEOPLE.values()}
    assert roles == {name: role for role, name in PEOPLE.items()}

"""Who may what, by a table that was written by hand; and what OWASP lists against web sites.

Each over a real socket. Whatever is sent: no error but those of the project, nothing without
right, and the page answers. Cookies and passwords are in test_login and test_accounts; a real page
of another origin is in scripts/test/test_web_page.py.
"""

from __future__ import annotations

import contextlib
import json
import random
import re
from collections import Counter
from typing import Any, Dict, Iterator, Mapping, Optional, Sequence
from urllib.parse import quote
from uuid import uuid4

import pytest
from case_kit import each_case
from run_seed import SEED, draws
from test_commands import PLAN
from view_kit import FOLDER, PAST, SURVEY
from web_kit import COOKIE, PASSWORD
from whole_page_kit import TABLE, Row, S, WholePage, is_without_right

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Role
from gpr20_web.low.http_server import MAX_BODY_BYTES, MAX_HEADER_BYTES
from gpr20_web.mid.commands import plan_id

NOBODY, WATCH, CONTROL = Role
OF_OTHERS: Sequence[Mapping[str, Optional[str]]] = tuple(
    {"Sec-Fetch-Site": one} for one in ("same-site", "cross-site")
)
WITHOUT_ORIGIN: Sequence[Mapping[str, Optional[str]]] = (
    *({"Origin": one} for one in (None, "null", "https://other.example")),
    *({"Content-Type": one} for one in (None, "text/plain", "application/x-www-form-urlencoded")),
)


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


def test_no_answer_is_kept_framed_or_leads_elsewhere_and_errors_say_nothing_of_the_program(
    page: WholePage,
) -> None:
    paths = [_path(page, one) for one in TABLE if one.method == "GET"]
    asked = [(one, role) for one in paths for role in (NOBODY, CONTROL)]
    odd = ("//other.example", "/\\other.example", "/?next=//o.example", "/api/surveys?before=../..")
    asked += [(one, NOBODY) for one in (*page.files, "/nowhere", "/api/nowhere", "/%ff", *odd)]
    for path, role in asked:
        reply = page.ask("GET", path, role)
        assert reply.headers["X-Frame-Options"] == "DENY"
        assert reply.headers["X-Content-Type-Options"] == "nosniff"
        policy = reply.headers["Content-Security-Policy"]
        assert "frame-ancestors 'none'" in policy
        assert "default-src 'self'" in policy and "unsafe" not in policy
        assert reply.headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert reply.status // 100 != 3
        assert not {"Location", "Refresh", "Server"} & set(reply.headers)
        # No file is used without asking.
        kept = "no-cache" if path.split("?")[0] in page.files else "no-store"
        assert reply.headers["Cache-Control"] == kept
        words = (b"Traceback", b"tornado", b"python", b".py", b"line ", b"/work")
        said = reply.body.lower() if reply.status >= 400 else b""
        assert not [one for one in words if one.lower() in said]


@each_case("up", ["..", "%2e%2e", "%252e%252e", "..%00", "..\\", "..%2f.."])
def test_path_traversal_nothing_outside_is_reached(page: WholePage, up: str) -> None:
    secret = page.folder / "web" / "accounts.txt"
    for start in ("/", "/pages/", "/api/surveys/", f"/api/surveys/{page.surveys.whole}/made/"):
        for name in (f"{up}/errors.py", f"{up}/" * 4 + "etc/passwd", f"{up}/{secret}"):
            answer = page.exchange(_request(page, CONTROL, "GET", f"{start}{name}", {}))
            assert re.match(rb"HTTP/1.1 (400|403|404) ", answer), name
            assert b"hash" not in answer and b"root:" not in answer


def test_more_than_the_page_sends_is_refused(page: WholePage) -> None:
    before = page.done()
    for path in ("/api/login", "/api/stop"):
        body = {"name": "a" * MAX_BODY_BYTES}
        answer = page.exchange(_request(page, CONTROL, "POST", path, body))
        assert answer == b"" or answer.startswith(b"HTTP/1.1 400")
    long = page.exchange(_request(page, CONTROL, "GET", "/", {}, X="a" * MAX_HEADER_BYTES))
    assert long == b"" or re.match(rb"HTTP/1.1 4(00|31) ", long)
    assert page.done() == before


def _request(
    page: WholePage, role: Role, method: str, path: str, values: Mapping[str, Any], **headers: str
) -> bytes:
    """Return a request as bytes, which may be one that no browser sends."""
    body, own = json.dumps(values).encode(), page.site.origin
    if method == "GET":
        texts = {
            name: quote(str(one)[:500], errors="surrogatepass") for name, one in values.items()
        }
        path, body = f"{path}?" + "&".join(map("=".join, texts.items())), b""
    given = {
        **{"Host": own[len("http://") :], "Origin": own, "Content-Type": "application/json"},
        **{"Cookie": f"{COOKIE}={page.session(role)}", "Connection": "close", **headers},
    }
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {one}" for name, one in given.items())]
    head = "\r\n".join([*lines, f"Content-Length: {len(body)}", "", ""])
    return head.encode("utf-8", "surrogatepass") + body


REQUESTS = draws(300)
FIELDS = sorted({*(name for row in TABLE for name in row.values), "pressed_ms"}) + [
    *("depth_mm", "before", "layer", "theme", "x", "y", "depth", "known", "polarization", "along"),
    *("language", "survey", "again", "__proto__"),
]
GOOD = (
    *("0" * 32, "1" * 32, plan_id(PLAN), SURVEY, PAST, FOLDER, PASSWORD, "mine", "pmn", "vera"),
    *("coverage", "echoes", "sun", "night", "x", "y", "0", "1", "5", "es"),
)
ODD = (
    *("", " ", "NaN", "-Infinity", "1e999", "1_0", "٣", "\0", "\x1b[2J", "\u202egnp", "\ud800"),
    *("é\u0301" * 40, "a" * 5000, "../" * 20 + "etc/passwd", "%00", "%c0%ae", "\r\nA: b"),
    *(0, -1, 2**63, 10**400, 1e308, -0.0, 0.1, None, True, [], {}, [[1]], {"a": None}),
)
HEADERS = ("Origin", "Content-Type", "Accept-Language", "If-None-Match", "Range", "Host", "Cookie")


def test_random_requests_do_nothing_without_right_and_the_page_answers(page: WholePage) -> None:
    draw, answers, acts = random.Random(SEED), Counter(), Counter()  # type: Any, Counter, Counter
    for number in range(REQUESTS):
        if number % 10 == 0:
            page.renew()
            page.be(draw.choice(list(SurveyState)), armed=draw.random() < 0.8)
        page.wait(draw.choice([0.0, 0.1, 1.0, 20.0]))
        page.forget()
        row, role = draw.choice(TABLE), draw.choice(list(Role))
        values: Dict[str, Any] = {**row.values} if draw.random() < 0.6 else {}
        if "press" in values:
            values["press"] = f"{draw.getrandbits(128):032x}"
            values["pressed_ms"] = 1e3 * page.clock.time_s
        for _ in range(draw.choice([0, 0, 1, 2, 5])):
            values[draw.choice(FIELDS)] = draw.choice(draw.choice([GOOD, ODD]))
        is_odd = draw.random() < 0.1
        headers = {draw.choice(HEADERS): str(draw.choice(ODD))[:200]} if is_odd else {}
        sent = _request(page, role, row.method, _path(page, row), values, **headers)
        before = page.done()
        # A stream ends when the browser goes; all else is waited for.
        answer = page.exchange(sent, ends="/api/live" in row.path)
        answers[int(answer[9:12]) if answer[9:12].isdigit() else 0] += 1
        assert not answers[500] and not page.foreign, (sent, page.foreign)
        if page.done() == before:
            continue
        acts[role.word] += 1
        assert role >= row.right, sent
        if any(one == "resume" or one[0] == "start" for one in page.control.asked):
            holder = page.lease.holder
            assert holder is not None and holder.session == page.session(role), sent
    page.renew()
    assert page.ask("GET", "/api/me", WATCH).values["me"]["name"] == "vera"
    # Without these, the requests would only show that rubbish is refused.
    assert answers[200] > REQUESTS / 10
    assert {"watch", "control"} <= set(acts)

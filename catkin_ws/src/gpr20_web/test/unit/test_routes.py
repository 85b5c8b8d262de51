"""Who may what, by a table that was written by hand; and what OWASP lists against web sites.

Each over a real socket, with every page over fakes of the robot. Whatever is sent: no error but
those of the project, nothing without right, and the page answers. Cookies and passwords are in
test_login and test_accounts.
"""

from __future__ import annotations

import contextlib
import http.client
import json
import random
import re
import socket
from collections import Counter
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple
from urllib.parse import quote
from uuid import uuid4

import pytest
from case_kit import each_case
from run_seed import SEED, draws
from surveys_kit import Surveys
from test_commands import ANA, PLAN, SURVEY, Desk
from view_kit import FOLDER, PAST
from web_ground_kit import Server
from web_kit import COOKIE, LIMIT_S, PASSWORD, STATIC, Site, make_accounts, make_logins

from gpr20_common.catalogue import Language
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Role
from gpr20_web.low.http_server import MAX_BODY_BYTES, MAX_HEADER_BYTES
from gpr20_web.mid.commands import plan_id
from gpr20_web.mid.robot_pages import NowPage, ServicePage
from gpr20_web.mid.shell import Shell

NOBODY, WATCH, CONTROL = Role
# The session of a role, as `find_person` has it.
SESSIONS = {one: one.word if one else "" for one in Role}
PRESS = {"press": "0" * 32}
# What the path of a request has for {folder}: a stored survey.
S = "/api/surveys/{folder}"


class Row(NamedTuple):
    """A route, who may use it, and a request that the page sends."""

    method: str
    path: str
    right: Role
    values: Mapping[str, Any] = {}


TABLE = (
    # Before the login there is the form alone.
    Row("GET", "/api/me", NOBODY),
    Row("POST", "/api/login", NOBODY, {"name": "vera", "password": PASSWORD}),
    # Everybody with an account watches.
    Row("GET", "/api/live", WATCH),
    Row("POST", "/api/logout", WATCH),
    Row("GET", "/api/ground", WATCH),
    Row("GET", "/api/ground/map.png", WATCH),
    Row("GET", "/api/ground/section.png", WATCH),
    Row("GET", "/api/ground/bar.png", WATCH),
    Row("GET", "/api/service", WATCH),
    # The stored surveys: search, verdict, candidates, downloads.
    Row("GET", "/api/surveys", WATCH),
    Row("GET", S, WATCH),
    Row("POST", f"{S}/candidates", WATCH),
    Row("GET", f"{S}/zip", WATCH),
    Row("GET", f"{S}/made/report-html", WATCH),
    # Notes, markers, found records, PAUSE and STOP from anywhere.
    Row("POST", f"{S}/notes", WATCH, {"text": "wet"}),
    Row("POST", f"{S}/markers", WATCH, {"x_mm": 1.0, "y_mm": 2.0, "text": "can"}),
    Row("POST", f"{S}/found", WATCH, {"what": "scrap", "candidate": "c", "list": "l"}),
    Row("POST", "/api/pause", WATCH, PRESS),
    Row("POST", "/api/stop", WATCH, PRESS),
    # START and RESUME, and control over them.
    Row("POST", "/api/start", CONTROL, {**PRESS, "plan": plan_id(PLAN)}),
    Row("POST", "/api/resume", CONTROL, {**PRESS, "survey": SURVEY}),
    Row("POST", "/api/control/take", CONTROL),
    Row("POST", "/api/control/release", CONTROL),
)


class WholePage:
    """Every page as the node has it, at a port of its own."""

    def __init__(self, folder: Path) -> None:
        self.desk, self.surveys, ground = Desk(), Surveys(folder / "data"), Server()
        ground.run()
        make_accounts(folder).put("vera", WATCH, PASSWORD)
        self.shell = Shell(
            {
                "now": NowPage(""),
                "commands": self.desk.commands,
                "map": ground.page,
                "surveys": self.surveys.page,
                "service": ServicePage(lambda *_asked, **_more: None, self.desk.time),
            },
            make_logins(make_accounts(folder), self.desk.time),
        )
        self.files = self.shell.files(STATIC)
        self.routes = self.shell.all_routes()
        self.site = Site(self.routes, files=self.files)
        self.be(SurveyState.CONFIGURED)

    def be(self, code: SurveyState, armed: bool = True) -> None:
        """Let the robot be in a state, and somebody beside it allow START and RESUME or not."""

        async def take() -> None:
            self.desk.be(code)
            if armed:
                self.desk.allow()
            self.shell.refresh(self.desk.model.snapshot())

        self.site.call(take())

    async def beat(self) -> None:
        """Send what is new, as the node does five times a second."""
        self.site.server.streams.beat()

    def close(self) -> None:
        self.site.close()
        self.surveys.close()

    def ask(self, row: Row, role: Role, values: Any = None, **more: Any) -> Any:
        """Ask as the browser of a person of a role."""
        path = row.path.format(folder=self.surveys.whole)
        sent = row.values if values is None else values
        if row.method == "GET" and sent:
            texts = (f"{one}={quote(str(sent[one])[:500], errors='surrogatepass')}" for one in sent)
            path = f"{path}?{'&'.join(texts)}"
        return self.site.ask(row.method, path, sent, SESSIONS[role], **more)

    def exchange(self, sent: bytes) -> bytes:
        """Send bytes; return all that comes back until the server closes the connection."""
        with socket.create_connection(("127.0.0.1", self.site.port), LIMIT_S) as connection:
            try:
                connection.sendall(sent)
                return b"".join(iter(lambda: connection.recv(65536), b""))
            except ConnectionError:
                return b""

    def done(self) -> Tuple[Any, ...]:
        """Return what requests have changed, or have asked the robot for."""
        asked = (*self.desk.control.asked, *self.surveys.services.asked)
        return (tuple(map(repr, asked)), self.desk.lease.holder)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WholePage]:
    with contextlib.closing(WholePage(tmp_path_factory.mktemp("page"))) as made:
        yield made
    assert made.site.reported == []


def test_the_table_has_every_route_and_every_route_is_in_the_table(page: WholePage) -> None:
    known = set()
    for row in TABLE:
        path = row.path.format(folder=page.surveys.whole)
        routes = [one for one in page.routes if one.method == row.method]
        (route,) = [one for one in routes if re.fullmatch(one.pattern, path)]
        known.add(id(route))
    assert [one.pattern for one in page.routes if id(one) not in known] == []


OF_OTHERS: Sequence[Mapping[str, Optional[str]]] = tuple(
    {"Sec-Fetch-Site": one} for one in ("same-site", "cross-site")
)
WITHOUT_ORIGIN: Sequence[Mapping[str, Optional[str]]] = (
    *({"Origin": one} for one in (None, "null", "https://other.example")),
    *({"Content-Type": one} for one in (None, "text/plain", "application/x-www-form-urlencoded")),
)


@each_case("row", TABLE)
def test_each_route_is_for_the_roles_of_the_table_and_for_no_other_page(
    page: WholePage, row: Row
) -> None:
    for role in Role:
        before = page.done()
        reply = page.ask(row, role)
        if role < row.right:
            code = "web.not_allowed" if role else "web.not_logged_in"
            assert (reply.status, reply.values["code"]) == (403 if role else 401, code)
            assert page.done() == before
        else:
            assert reply.status not in (401, 403) or reply.values["code"] == "web.not_in_control"
    before = page.done()
    for headers in OF_OTHERS if row.method == "GET" else (*OF_OTHERS, *WITHOUT_ORIGIN):
        reply = page.ask(row, CONTROL, headers=headers)
        assert (reply.status, reply.values["code"]) == (403, "web.bad_request")
    assert page.done() == before


def test_both_of_two_screens_are_told_with_the_next_beat_who_is_in_control(
    page: WholePage,
) -> None:
    with contextlib.ExitStack() as stack:
        screens = []
        for role in (WATCH, CONTROL):
            connection = stack.enter_context(contextlib.closing(page.site.connect()))
            connection.request("GET", "/api/live", headers={"Cookie": f"{COOKIE}={role.word}"})
            screens.append(connection.getresponse())

        def shown() -> List[Any]:
            lines = [(one.readline(), one.readline())[0] for one in screens]
            return [json.loads(one[len(b"data: ") :])["holder"] for one in lines]

        shown()
        for act, name in (("take", "control"), ("release", None), ("take", "control")):
            page.site.ask("POST", f"/api/control/{act}", session=CONTROL.word)
            page.be(SurveyState.CONFIGURED)
            page.site.call(page.beat())
            assert [one and one["name"] for one in shown()] == [name, name]
    # What changes with each trace is not sent with each beat.
    seldom = json.loads(f"{{{page.shell.document(Language.ENGLISH).seldom[:-1]}}}")
    assert set(seldom) == {"band", "job", "ground"}


def test_no_answer_is_kept_framed_or_leads_elsewhere_and_errors_say_nothing_of_the_program(
    page: WholePage,
) -> None:
    asked = [page.ask(row, role) for row in TABLE if row.method == "GET" for role in Role]
    odd = ("//other.example", "/\\other.example", "/?next=//o.example", "/api/surveys?before=../..")
    paths = (*page.files, "/nowhere", "/api/nowhere", "/%ff", *odd)
    asked += [page.site.ask("GET", one) for one in paths]
    for reply in asked:
        assert reply.headers["X-Frame-Options"] == "DENY"
        assert reply.headers["X-Content-Type-Options"] == "nosniff"
        policy = reply.headers["Content-Security-Policy"]
        assert "frame-ancestors 'none'" in policy
        assert "default-src 'self'" in policy and "unsafe" not in policy
        assert reply.headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert reply.status // 100 != 3
        assert not {"Location", "Refresh", "Server"} & set(reply.headers)
        # No file is used without asking.
        is_file = reply.body in [one.content for one in page.files.values()]
        assert reply.headers["Cache-Control"] == ("no-cache" if is_file else "no-store")
        words = (b"Traceback", b"tornado", b"python", b".py", b"line ", b"/work")
        said = reply.body.lower() if reply.status >= 400 else b""
        assert not [one for one in words if one.lower() in said]


def test_the_page_is_one_document_whose_words_end_no_element(page: WholePage) -> None:
    html = page.site.ask("GET", "/").body.decode()
    assert not re.search(r'(?:src|href)="[^"#]*\.(?:js|css)"', html)
    assert "--mark-selected:" in html and "class App" in html
    (words,) = re.findall(r'id="words">(.*?)</script>', html, re.DOTALL)
    assert "<" not in words and json.loads(words)["es"]["words"]["surveys.add"] == "Añadir"


@each_case("up", ["..", "%2e%2e", "%252e%252e", "..%00", "..\\", "..%2f.."])
def test_path_traversal_nothing_outside_is_reached(page: WholePage, up: str) -> None:
    for start in ("/", "/pages/", "/api/surveys/", f"/api/surveys/{page.surveys.whole}/made/"):
        for name in (f"{up}/faults.py", f"{up}/" * 4 + "etc/passwd", f"{up}/accounts.txt"):
            cookie = f"Cookie: {COOKIE}={SESSIONS[CONTROL]}\r\nConnection: close\r\n\r\n"
            sent = f"GET {start}{name} HTTP/1.1\r\nHost: 127.0.0.1\r\n{cookie}"
            answer = page.exchange(sent.encode())
            assert re.match(rb"HTTP/1.1 (400|403|404) ", answer), name
            assert b"scrypt" not in answer and b"root:" not in answer


def test_more_than_the_page_sends_is_refused(page: WholePage) -> None:
    before, body, long = page.done(), b"a" * (MAX_BODY_BYTES + 1), "a" * MAX_HEADER_BYTES
    for path, more in (("/api/stop", {"body": body}), ("/api/login", {"headers": {"X": long}})):
        with contextlib.suppress(ConnectionError, http.client.RemoteDisconnected):
            reply = page.site.ask("POST", path, session=SESSIONS[CONTROL], **more)
            assert reply.status in (413, 431)
    assert page.done() == before


REQUESTS = draws(300)
FIELDS = sorted({*(name for row in TABLE for name in row.values), "pressed_ms"}) + [
    *("depth_mm", "before", "choice", "known", "language", "again", "__proto__"),
]
GOOD = (
    *("0" * 32, "1" * 32, plan_id(PLAN), SURVEY, PAST, FOLDER, PASSWORD, "scrap", "pmn", "vera"),
    *("{}", '{"layer": "echoes", "x_mm": 120, "y_mm": 60}', "0", "1", "5", "es"),
)
ODD = (
    *("", " ", "NaN", "-Infinity", "1e999", "1_0", "٣", "\0", "\x1b[2J", "\u202egnp", "\ud800"),
    *("é\u0301" * 40, "a" * 5000, "../" * 20 + "etc/passwd", "%00", "%c0%ae", "\r\nA: b", "[" * 99),
    *(0, -1, 2**63, 10**400, 1e308, -0.0, 0.1, None, True, [], {}, [[1]], {"a": None}),
)


def test_random_requests_do_nothing_without_right_and_the_page_answers(page: WholePage) -> None:
    draw, answers, acts = random.Random(SEED), Counter(), Counter()  # type: Any, Counter, Counter
    commands: List[Any] = page.desk.control.asked
    for number in range(REQUESTS):
        if number % 10 == 0:
            page.be(draw.choice(list(SurveyState)), armed=draw.random() < 0.8)
        page.desk.time.time_s += draw.choice([0.0, 0.1, 1.0, 2.0])
        row, role = draw.choice(TABLE), draw.choice(list(Role))
        values: Dict[str, Any] = {**row.values} if draw.random() < 0.6 else {}
        if "press" in values:
            values["press"] = uuid4().hex
            values["pressed_ms"] = 1e3 * page.desk.time.time_s
        for _ in range(draw.choice([0, 0, 1, 2, 5])):
            values[draw.choice(FIELDS)] = draw.choice(draw.choice([GOOD, ODD]))
        before, known = page.done(), len(commands)
        reply = page.ask(row, role, values)
        answers[reply.status] += 1
        assert reply.status != 500 and not page.site.reported, (row, values)
        if page.done() == before:
            continue
        acts[role] += 1
        assert role >= row.right, (row, values)
        if any(one == "resume" or one[0] == "start" for one in commands[known:]):
            holder = page.desk.lease.holder
            assert holder is not None and holder.session == SESSIONS[role]
    assert page.site.ask("GET", "/api/me", session=ANA.role.word).values["me"]["name"] == "control"
    # Without these, the requests would only show that rubbish is refused.
    assert answers[200] > REQUESTS / 10 and {WATCH, CONTROL} <= set(acts)

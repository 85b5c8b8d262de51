"""Whatever is sent: no error but those of the project, nothing without right, the page answers."""

from __future__ import annotations

import contextlib
import json
import random
from collections import Counter
from pathlib import Path
from typing import Any, List
from urllib.parse import quote

from run_seed import SEED, draws
from test_commands import PLAN
from view_kit import FOLDER, PAST, SURVEY
from web_kit import COOKIE, PASSWORD
from whole_page_kit import TABLE, WholePage, least_right

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Role
from gpr20_web.mid.commands import plan_id

REQUESTS = draws(400)
FIELDS = sorted({*(name for row in TABLE for name in row.values), "pressed_ms"}) + [
    *("depth_mm", "remove", "before", "listed", "layer", "theme", "x", "y", "depth", "known"),
    *("polarization", "background", "gain", "along", "colours", "section", "cell", "language"),
    *("unknown", "__proto__"),
]
GOOD = (
    *("0" * 32, "1" * 32, plan_id(PLAN), SURVEY, PAST, FOLDER, PASSWORD, "mine", "pmn", "vera"),
    *("hiding", "coverage", "echoes", "sun", "night", "x", "y", "0", "1", "5", "all", "es", "grey"),
)
ODD = (
    *("", " ", "NaN", "-Infinity", "1e999", "1_0", "٣", "\0", "\x1b[2J", "\u202egnp", "\ud800"),
    *(
        "é\u0301" * 40,
        "😀" * 200,
        "a" * 5000,
        "../" * 20 + "etc/passwd",
        "%00",
        "%c0%ae",
        "\r\nA: b",
    ),
    *(0, -1, 2**63, 10**400, 1e308, -0.0, 0.1, None, True, [], {}, [[1]], {"a": None}),
)
METHODS = ("GET", "POST", "DELETE", "PUT", "HEAD", "OPTIONS", "TRACE", "CONNECT", "get")
HEADERS = ("Origin", "Content-Type", "Accept-Language", "If-None-Match", "Range", "Host", "Cookie")
PIECES = (
    *(b"\r\n", b"\n", b"\0", b":", b" ", b"\r\n\r\n", b"\xff\xfe"),
    *(b"\r\nTransfer-Encoding: chunked\r\n", b"\r\nContent-Length: 3\r\n"),
)


class Fuzz:
    """Sends random requests, and fails at the first one that does what it may not.

    Attributes:
        answers: How many had which status; 0: the connection was closed.
        acts: How many did something, by the role that has sent them.
    """

    def __init__(self, page: WholePage) -> None:
        self._page, self._draw = page, random.Random(SEED)
        self.answers: Counter[int] = Counter()
        self.acts: Counter[str] = Counter()

    def send(self) -> None:
        """Send a request, sometimes a broken one without a session."""
        draw, page = self._draw, self._page
        page.forget()
        row, role = draw.choice(TABLE), draw.choice(list(Role))
        method = row.method if draw.random() < 0.9 else draw.choice(METHODS)
        path = self._path(row.path)
        is_raw = draw.random() < 0.2
        sent = self._request(method, path, row, "" if is_raw else page.session(role))
        sent = self._mutated(sent) if is_raw else sent
        before = page.done()
        # A stream ends when the browser goes; all else is waited for.
        answer = page.exchange(sent, ends=is_raw or "/api/live" in path)
        status = int(answer[9:12]) if answer[9:12].isdigit() else 0
        self.answers[status] += 1
        assert status != 500 and not page.foreign, (sent, page.foreign)
        if page.done() == before:
            return
        self.acts[role.word] += 1
        least = least_right(method, path.partition("?")[0])
        # Whoever sends name and password is logged in; that alone needs no session.
        assert (b"/api/login" in sent) if is_raw else (least is not None and role >= least), sent
        if any(one == "resume" or one[0] == "start" for one in page.control.asked):
            holder = page.lease.holder
            assert holder is not None and holder.session == page.session(role), sent

    def _path(self, path: str) -> str:
        draw, surveys = self._draw, self._page.surveys
        path = path.format(folder=draw.choice([surveys.whole, surveys.part, FOLDER]))
        if draw.random() < 0.1:
            at = draw.randrange(len(path))
            path = path[:at] + str(draw.choice(ODD)) + path[at + draw.randint(0, 2) :]
        return quote(path, safe="/%", errors="surrogatepass")

    def _request(self, method: str, path: str, row: Any, session: str) -> bytes:
        draw = self._draw
        values = {**row.values} if draw.random() < 0.6 else {}
        if "press" in values:
            values["press"] = f"{draw.getrandbits(128):032x}"
            values["pressed_ms"] = 1e3 * self._page.clock.time_s
        for _ in range(draw.choice([0, 0, 1, 2, 5])):
            values[draw.choice(FIELDS)] = draw.choice(draw.choice([GOOD, ODD]))
        body = json.dumps(values).encode()
        if method == "GET":
            texts = {
                name: quote(str(one)[:500], errors="surrogatepass") for name, one in values.items()
            }
            path, body = f"{path}?" + "&".join(map("=".join, texts.items())), b""
        elif draw.random() < 0.1:
            body = draw.choice([self._mutated(body), body * 3, b"[" * 30000, b"\xff"])
        own = self._page.site.origin
        headers = {"Host": own[len("http://") :], "Origin": own, "Content-Type": "application/json"}
        headers.update({"Cookie": f"{COOKIE}={session}", "Connection": "close"})
        if draw.random() < 0.1:
            headers[draw.choice(HEADERS)] = str(draw.choice(ODD))[:200]
        lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {one}" for name, one in headers.items())]
        head = "\r\n".join([*lines, f"Content-Length: {len(body)}", "", ""])
        return head.encode("utf-8", "surrogatepass") + body

    def _mutated(self, data: bytes) -> bytes:
        """Return bytes of which some were removed, repeated, or replaced by what is special."""
        draw, found = self._draw, bytearray(data)
        for _ in range(draw.randint(1, 6)):
            at = draw.randint(0, len(found))
            part: List[bytes] = [b"", bytes(found[at : at + 60]), draw.choice(PIECES)]
            found[at : at + draw.choice([0, 1, 30])] = draw.choice(part)
        return bytes(found)


def test_random_requests_do_nothing_without_right_and_the_page_answers(tmp_path: Path) -> None:
    draw = random.Random(f"{SEED} states")
    with contextlib.closing(WholePage(tmp_path)) as page:
        fuzz = Fuzz(page)
        for number in range(REQUESTS):
            if number % 10 == 0:
                page.renew()
                page.be(draw.choice(list(SurveyState)), armed=draw.random() < 0.8)
            page.wait(draw.choice([0.0, 0.1, 1.0, 20.0]))
            fuzz.send()
        page.renew()
        assert page.ask("GET", "/api/me", Role.WATCH).values["name"] == "vera"
    assert page.foreign == []
    # Without these, the requests would only show that rubbish is refused.
    assert fuzz.answers[200] > REQUESTS / 10
    assert {"watch", "control"} <= set(fuzz.acts)

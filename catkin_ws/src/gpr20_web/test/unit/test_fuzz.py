"""Whatever is sent: no error but those of the project, nothing without right, the page answers."""

from __future__ import annotations

import contextlib
import http.client
import json
import random
import socket
from collections import Counter
from pathlib import Path
from typing import Any, Dict, List, Optional
from urllib.parse import quote

from run_seed import SEED, draws
from test_commands import PLAN
from view_kit import FOLDER, PAST, SURVEY
from web_kit import COOKIE, PASSWORD
from whole_page_kit import TABLE, Row, WholePage, least_right

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Role
from gpr20_web.mid.remote_plan import plan_id

REQUESTS, LIMIT_S = draws(400), 30.0
FIELDS = (
    *("press", "plan", "survey", "text", "x_mm", "y_mm", "depth_mm", "remove", "what", "list"),
    "pressed_ms",
    *("candidate", "name", "role", "password", "old", "new", "before", "listed", "layer", "theme"),
    *("x", "y", "depth", "polarization", "background", "gain", "along", "colours", "section"),
    *("permittivity", "cell", "target", "known", "again", "language", "unknown", "__proto__"),
)
GOOD = (
    *("0" * 32, "1" * 32, plan_id(PLAN), SURVEY, PAST, FOLDER, PASSWORD, "mine", "pmn", "watch"),
    *("control", "eva", "vera", "map", "focused", "coverage", "echoes", "sun"),
    *("night", "x", "y", "0", "1", "5", "100", "all", "imported", "not complete", "es", "grey"),
)
ODD_TEXTS = (
    *("", " ", "NaN", "-Infinity", "1e999", "0x10", "1_0", "٣", "\uff19", "\0", "\x1b[2J"),
    *("\u202egnp", "\ud800", "é\u0301" * 40, "😀" * 200, "a" * 5000, "../" * 20 + "etc/passwd"),
    *("%00", "%c0%ae", "<img src=x>", "'; --", "{0.__class__}", "%s%n", "null", "\r\nA: b"),
)
ODD_NUMBERS = (0, -1, 1, 2**31, 2**63, -(10**30), 10**400, 1e308, -1e308, 5e-324, -0.0, 0.1)
METHODS = ("GET", "POST", "DELETE", "PUT", "PATCH", "HEAD", "OPTIONS", "TRACE", "CONNECT", "get")
HEADERS = (
    *("Origin", "Content-Type", "Accept-Language", "If-None-Match", "Range", "Host", "Referer"),
    *("X-HTTP-Method-Override", "X-Forwarded-For", "Sec-Fetch-Site", "Upgrade", "Cookie"),
)
FRAMING = (b"Transfer-Encoding: chunked", b"Content-Length: 3", b"Expect: 100-continue")


class Fuzz:
    """Sends random requests, and fails at the first one that does what it may not.

    Attributes:
        answers: How many had which status; 0: the connection was closed.
        acts: How many did something, by the role that has sent them.
    """

    def __init__(self, page: WholePage) -> None:
        self._page, self._draw = page, random.Random(SEED)
        self._connection: Optional[socket.socket] = None
        self.answers: Counter[int] = Counter()
        self.acts: Counter[str] = Counter()

    def run(self, requests: int) -> None:
        """Send so many requests, and change what the robot does between them."""
        draw, page = self._draw, self._page
        for number in range(requests):
            if number % 10 == 0:
                page.renew()
                page.be(draw.choice(list(SurveyState)), armed=draw.random() < 0.8)
            page.wait(draw.choice([0.0, 0.1, 1.0, 20.0]))
            page.forget()
            if draw.random() < 0.2:
                self._send_raw()
            else:
                self._send_request()
        self.close()

    def close(self) -> None:
        """Close the connection that several requests share."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _send_raw(self) -> None:
        """Send bytes without a session: nothing may be done."""
        before = self._page.done()
        sent = self._raw()
        answer = self._page.exchange(sent, ends=True)
        status = answer[9:12]
        self.answers[int(status) if status.isdigit() else 0] += 1
        # Whoever sends name and password is logged in; that alone needs no session.
        is_login = b"POST /api/login" in sent and PASSWORD.encode() in sent
        assert is_login or self._page.done() == before, sent
        assert not self._page.foreign, (sent, self._page.foreign)

    def _send_request(self) -> None:
        """Send a request of a person: nothing is done without the right to do it."""
        draw, page = self._draw, self._page
        role, row = draw.choice(list(Role)), draw.choice(TABLE)
        method = row.method if draw.random() < 0.9 else draw.choice(METHODS)
        path, before = self._path(row), page.done()
        sent = self._request(method, path, row, page.session(role))
        self.answers[self._status(method, sent)] += 1
        assert not page.foreign, (sent, page.foreign)
        if page.done() == before:
            return
        self.acts[role.word] += 1
        least = least_right(method, path.partition("?")[0])
        assert least is not None and role >= least, sent
        if any(one == "resume" or one[0] == "start" for one in page.control.asked):
            holder = page.lease.holder
            assert holder is not None and holder.session == page.session(role), sent

    def _status(self, method: str, sent: bytes) -> int:
        """Send a request on the open connection, and return the status of its answer."""
        if self._connection is None:
            port = self._page.site.port
            self._connection = socket.create_connection(("127.0.0.1", port), LIMIT_S)
        answer = http.client.HTTPResponse(self._connection, method=method)
        try:
            self._connection.sendall(sent)
            answer.begin()
            is_stream = answer.headers.get("Content-Type") == "text/event-stream"
            if not is_stream:
                answer.read()
        except (ConnectionError, http.client.HTTPException):
            self.close()
            return 0
        if is_stream or answer.will_close:
            self.close()
        assert answer.status != 500, sent
        return answer.status

    def _path(self, row: Row) -> str:
        draw, surveys = self._draw, self._page.surveys
        path = row.path.format(folder=draw.choice([surveys.whole, surveys.part, FOLDER]))
        if draw.random() < 0.1:
            at = draw.randrange(len(path))
            path = path[:at] + self._text() + path[at + draw.randint(0, 2) :]
        return quote(path, safe="/%", errors="surrogatepass")

    def _request(self, method: str, path: str, row: Row, session: str) -> bytes:
        draw = self._draw
        values = {**row.values} if draw.random() < 0.6 else {}
        if "press" in values:
            values["press"] = f"{draw.getrandbits(128):032x}"
            values["pressed_ms"] = 1e3 * self._page.clock.time_s
        for _ in range(draw.choice([0, 0, 1, 2, 5])):
            values[draw.choice(FIELDS)] = self._value()
        headers: Dict[str, str] = {"Cookie": f"{COOKIE}={session}"}
        body = b""
        if method in ("POST", "DELETE"):
            headers.update({"Origin": self._page.site.origin, "Content-Type": "application/json"})
            body = json.dumps(values).encode()
            if draw.random() < 0.1:
                body = draw.choice([self._mutated(body), body * 3, b"[" * 30000, self._bytes(9)])
        elif values:
            texts = {name: str(one)[:500] for name, one in values.items()}
            path += "?" + "&".join(
                f"{name}={quote(one, errors='surrogatepass')}" for name, one in texts.items()
            )
        headers["Host"] = self._page.site.origin[len("http://") :]
        if draw.random() < 0.1:
            headers[draw.choice(HEADERS)] = self._text()[:200]
        lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {one}" for name, one in headers.items())]
        head = "\r\n".join([*lines, f"Content-Length: {len(body)}", "", ""])
        return head.encode("utf-8", "surrogatepass") + body

    def _raw(self) -> bytes:
        """Return bytes that are, or once were, a request."""
        draw, row = self._draw, self._draw.choice(TABLE)
        if draw.random() < 0.2:
            return self._bytes(draw.randint(1, 400))
        sent = self._request(draw.choice(METHODS), self._path(row), row, self._text())
        return self._mutated(sent) + (sent if draw.random() < 0.2 else b"")

    def _mutated(self, data: bytes) -> bytes:
        """Return bytes of which some were changed, removed, repeated or moved."""
        draw, found = self._draw, bytearray(data)
        for _ in range(draw.randint(1, 6)):
            at = draw.randint(0, len(found))
            kind = draw.randrange(5)
            if kind == 0:
                found[at:at] = self._bytes(draw.randint(1, 4))
            elif kind == 1:
                del found[at : at + draw.randint(1, 30)]
            elif kind == 2:
                found[at:at] = found[at : at + draw.randint(1, 60)]
            elif kind == 3:
                found[at : at + 1] = draw.choice([b"\r\n", b"\n", b"\0", b":", b" ", b"\r\n\r\n"])
            else:
                found[at:at] = b"\r\n" + draw.choice(FRAMING) + b"\r\n"
        return bytes(found)

    def _bytes(self, count: int) -> bytes:
        return bytes(self._draw.getrandbits(8) for _ in range(count))

    def _text(self) -> str:
        return self._draw.choice(ODD_TEXTS if self._draw.random() < 0.7 else GOOD)

    def _value(self, depth: int = 0) -> Any:
        draw, kind = self._draw, self._draw.randrange(8)
        if kind < 3:
            return draw.choice(GOOD)
        if kind == 3:
            return draw.choice(ODD_TEXTS)
        if kind == 4:
            return draw.choice(ODD_NUMBERS)
        if kind == 5 or depth > 4:
            return draw.choice([None, True, False, draw.uniform(-1e4, 1e4), draw.randint(-99, 99)])
        parts: List[Any] = [self._value(depth + 1) for _ in range(draw.randint(0, 3))]
        return parts if kind == 6 else {draw.choice(ODD_TEXTS): one for one in parts}


def test_random_requests_do_nothing_without_right_and_the_page_answers(tmp_path: Path) -> None:
    with contextlib.closing(WholePage(tmp_path)) as page:
        fuzz = Fuzz(page)
        fuzz.run(REQUESTS)
        page.renew()
        assert page.ask("GET", "/api/me", Role.WATCH).values["name"] == "vera"
    assert page.foreign == []
    # Without these, the requests would only show that rubbish is refused.
    assert fuzz.answers[200] > REQUESTS / 10
    assert {role.word for role in Role if role is not Role.NOBODY} <= set(fuzz.acts)

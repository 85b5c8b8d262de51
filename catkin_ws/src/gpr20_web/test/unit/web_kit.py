"""A page on loopback without encryption, and a browser that sends what it is asked to."""

from __future__ import annotations

import asyncio
import http.client
import json
import re
import threading
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import gpr20_web
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_web.calls import ROLES, File, Person, Route
from gpr20_web.faults import NotLoggedInError
from gpr20_web.low.accounts import Accounts, Cost
from gpr20_web.low.http_server import COOKIE, HttpServer
from gpr20_web.low.logins import Logins

STATIC = Path(gpr20_web.__file__).parent / "static"
LIMIT_S = 100.0


def find_person(session: str, address: str) -> Person:
    """Return the person of a session that is named like its role."""
    if session not in ROLES:
        raise NotLoggedInError(Message("nobody is logged in"))
    return Person(session, ROLES[session], session, address)


def route_of(routes: Sequence[Route], method: str, path: str) -> Tuple[Route, Mapping[str, str]]:
    """Return the route of a request, and the parts of its path."""
    for route in routes:
        found = re.fullmatch(route.pattern, path) if route.method == method else None
        if found is not None:
            return route, found.groupdict()
    raise LookupError(path)


class Reply:
    """What a browser got."""

    def __init__(self, response: http.client.HTTPResponse) -> None:
        self.status = response.status
        self.headers = response.headers
        kind = self.headers.get("Content-Type", "")
        # A stream does not end by itself.
        self.body = b"" if kind == "text/event-stream" else response.read()

    @property
    def values(self) -> Dict[str, Any]:
        return dict(json.loads(self.body))


class Site:
    """Runs a server in a thread of its own.

    Attributes:
        reported: Exceptions that no error of the project is.
    """

    def __init__(
        self,
        routes: Sequence[Route],
        find: Callable[[str, str], Person] = find_person,
        files: Optional[Mapping[str, File]] = None,
    ) -> None:
        self.reported: List[BaseException] = []
        self.loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self.loop.run_forever, daemon=True)
        self._thread.start()

        async def begin() -> None:
            self.server = HttpServer(routes, files or {}, find, self.reported.append)
            self.port = self.server.listen("127.0.0.1", 0, None)

        self.call(begin())

    def call(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(LIMIT_S)

    def close(self) -> None:
        self.call(self.server.close())
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join(LIMIT_S)

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def connect(self) -> http.client.HTTPConnection:
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=LIMIT_S)

    def ask(
        self,
        method: str,
        path: str,
        values: Optional[Mapping[str, Any]] = None,
        session: str = "",
        headers: Optional[Mapping[str, str]] = None,
        body: Optional[bytes] = None,
    ) -> Reply:
        """Ask as the page does; `headers` replace its own, None leaves one out."""
        sent = {"Cookie": f"{COOKIE}={session}"} if session else {}
        if method != "GET":
            sent.update({"Origin": self.origin, "Content-Type": "application/json"})
        sent.update(headers or {})
        sent = {name: one for name, one in sent.items() if one is not None}
        if body is None and method != "GET":
            body = json.dumps(values or {}).encode()
        connection = self.connect()
        try:
            connection.request(method, path, body, sent)
            return Reply(connection.getresponse())
        finally:
            connection.close()


# Hashes that cost nothing: the tests are about everything else.
CHEAP = Cost(n=2, r=1, p=1)
PASSWORD, OTHER_PASSWORD = "correct horse battery", "staple of another kind"


class ManualClock(Clock):
    """Stands still until a test moves it."""

    def __init__(self) -> None:
        self.time_s = 1000.0

    def now_s(self) -> float:
        return self.time_s

    def time_of_day_us(self) -> int:
        return int((1.8e9 + self.time_s) * 1e6)


KEY, LONGEST_HOURS = b"k" * 32, 12.0


def make_logins(accounts: Accounts, clock: Clock) -> Logins:
    """Return sessions that nobody else can sign."""
    return Logins(accounts, KEY, LONGEST_HOURS, clock)


def make_accounts(folder: Path) -> Accounts:
    """Return the accounts of a folder, with hashes that cost nothing."""
    return Accounts(folder / "web", CHEAP)

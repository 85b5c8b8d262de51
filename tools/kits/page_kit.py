"""The page at a distance as a benchmark uses it: its folder, its clients, many that watch.

usage: page_kit.py PORT WATCHERS STAY_S

Watches the page until standard input ends, then prints what came as JSON; it says `ready` when
every watcher has got the whole state. With a STAY_S above 0, watchers leave after about so long,
come back with the same session, and every fifth time with another one.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import random
import ssl
import subprocess
import sys
import time
import uuid
from dataclasses import asdict, dataclass
from http.client import HTTPSConnection
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional

from robot_kit import free_port

from gpr20_web.calls import Role
from gpr20_web.low.accounts import Accounts

NAME, PASSWORD = "otto", "correct horse battery staple"
MOST_WATCHERS, SESSIONS_OF_ACCOUNT = 30, 5
SHORT_S, LIMIT_S = 0.05, 30.0
# Every so often a watcher that comes back logs in again.
LOG_IN_AGAIN = 5
# An event may carry a whole page.
MOST_BYTES = 1 << 20


def trusting() -> ssl.SSLContext:
    """Return what accepts the certificate that the installation has made."""
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context


@dataclass(frozen=True)
class Page:
    """Where the page is."""

    config: Path
    port: int

    @property
    def options(self) -> List[str]:
        """The arguments of a launch file."""
        return ["web:=true", f"config:={self.config}"]


def watcher_name(number: int) -> str:
    """Return the account of a watcher: the page ends the oldest of many sessions of one."""
    return f"watcher{number}"


def new_page(folder: Path, address: str = "127.0.0.1") -> Page:
    """Make a robot's configuration with a page, and the accounts."""
    page = Page(folder / "config", free_port())
    create = ["rosrun", "gpr20_launch", "robot_config", "create", str(page.config)]
    subprocess.run(create, check=True, stdout=subprocess.DEVNULL)
    own = folder / "page"
    (page.config / "web.yaml").write_text(f"address: {address}\nport: {page.port}\nfolder: {own}\n")
    accounts = Accounts(own)
    for name in (NAME, *map(watcher_name, range(MOST_WATCHERS // SESSIONS_OF_ACCOUNT))):
        accounts.put(name, Role.CONTROL, PASSWORD)
    return page


class Client:
    """Somebody who is logged in; each request has a connection of its own."""

    def __init__(self, port: int, name: str = NAME, host: str = "127.0.0.1") -> None:
        self.port, self.host, self._context = port, host, trusting()
        self._name = name
        self.cookie = ""
        self.log_in()

    def log_in(self) -> None:
        """Begin a session."""
        deadline_s = time.monotonic() + LIMIT_S
        while True:
            try:
                self.post("/api/login", name=self._name, password=PASSWORD)
                return
            except ConnectionError:
                # The node is still starting.
                if time.monotonic() > deadline_s:
                    raise
                time.sleep(SHORT_S)

    def press(self, command: str) -> None:
        """Give a command, as its button does."""
        self.post(f"/api/{command}", press=uuid.uuid4().hex)

    def post(self, path: str, **values: str) -> None:
        """Send a request that must succeed."""
        connection = HTTPSConnection(self.host, self.port, context=self._context, timeout=LIMIT_S)
        headers = {
            "Cookie": self.cookie,
            "Content-Type": "application/json",
            "Origin": f"https://{self.host}:{self.port}",
        }
        with contextlib.closing(connection):
            connection.request("POST", path, json.dumps(values), headers)
            answer = connection.getresponse()
            text = answer.read().decode()
        if answer.status != 200:
            raise SystemExit(f"{path} was refused: {answer.status} {text}")
        cookie = answer.headers.get("Set-Cookie", "")
        self.cookie = cookie.partition(";")[0] or self.cookie


@dataclass
class Counts:
    """What came to all watchers."""

    messages: int = 0
    bytes: int = 0
    visits: int = 0
    longest_silence_s: float = 0.0


async def _watch(client: Client, counts: Counts, leave_s: Optional[float]) -> None:
    """Read the live document until the watcher leaves."""
    counts.visits += 1
    reader, writer = await asyncio.open_connection(
        client.host, client.port, ssl=trusting(), limit=MOST_BYTES
    )
    try:
        request = (
            f"GET /api/live HTTP/1.1\r\nHost: {client.host}\r\nCookie: {client.cookie}\r\n\r\n"
        )
        writer.write(request.encode())
        begin_s = last_s = time.monotonic()
        while leave_s is None or last_s - begin_s < leave_s:
            line = await reader.readline()
            now_s = time.monotonic()
            if not line:
                raise SystemExit("the page has ended a stream")
            counts.bytes += len(line)
            if line.startswith(b"data:"):
                if not counts.messages:
                    begin_s = now_s
                counts.longest_silence_s = max(counts.longest_silence_s, now_s - last_s)
                counts.messages += 1
                last_s = now_s
    finally:
        writer.close()


async def _come_and_go(client: Client, counts: Counts, stay_s: float) -> None:
    loop = asyncio.get_event_loop()
    for visit in range(1, sys.maxsize):
        await _watch(client, counts, random.uniform(0.2, 1.8) * stay_s if stay_s else None)
        await asyncio.sleep(random.uniform(0.0, 0.5) * stay_s)
        if visit % LOG_IN_AGAIN == 0:
            await loop.run_in_executor(None, client.post, "/api/logout")
            await loop.run_in_executor(None, client.log_in)


async def _all(port: int, count: int, stay_s: float) -> Counts:
    counts, loop = Counts(), asyncio.get_event_loop()
    names = [watcher_name(number // SESSIONS_OF_ACCOUNT) for number in range(count)]
    clients = [Client(port, name) for name in names]
    tasks = [asyncio.ensure_future(_come_and_go(one, counts, stay_s)) for one in clients]
    while counts.messages < count:
        await asyncio.sleep(SHORT_S)
    print("ready", flush=True)
    over = asyncio.ensure_future(loop.run_in_executor(None, sys.stdin.read))
    done, _ = await asyncio.wait([over, *tasks], return_when=asyncio.FIRST_COMPLETED)
    for one in tasks:
        one.cancel()
    for one in done:
        one.result()
    return counts


@contextlib.contextmanager
def watchers(page: Page, count: int, stay_s: float = 0.0) -> Iterator[subprocess.Popen]:
    """Let many watch from one process; in the end it prints what came to them."""
    command = [sys.executable, __file__, str(page.port), str(count), f"{stay_s:g}"]
    streams: Dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    process = subprocess.Popen(command, text=True, **streams)
    assert process.stdout is not None
    try:
        if process.stdout.readline() != "ready\n":
            raise SystemExit("the watchers have ended")
        yield process
        if process.poll() is not None:
            raise SystemExit("the watchers have ended too early")
    finally:
        print(f"to {count} watchers: {process.communicate()[0].strip()}", flush=True)


def main() -> None:
    """Watch as the command line says."""
    port, count, stay_s = sys.argv[1:4]
    found = asyncio.run(_all(int(port), int(count), float(stay_s)))
    print(json.dumps(asdict(found)))


if __name__ == "__main__":
    main()

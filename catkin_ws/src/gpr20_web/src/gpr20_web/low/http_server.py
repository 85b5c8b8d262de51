"""The pages and their routes over HTTPS, by tornado: a file, or a route with its right."""

from __future__ import annotations

import asyncio
import errno
import json
import os
import re
import ssl
from base64 import b64encode
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property, lru_cache
from hashlib import sha256
from typing import Any, Callable, Dict, Mapping, Optional, Sequence

from tornado import httpserver, netutil, web
from tornado.http1connection import HTTP1Connection
from tornado.iostream import IOStream, StreamClosedError

from gpr20_common.catalogue import Language, languages, read_catalogue
from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.links import end_when_broken
from gpr20_common.message import Message
from gpr20_operator.robot.condition import first_step
from gpr20_web.calls import Answer, Body, Call, Cookie, Document, File, Person, Role, Route
from gpr20_web.faults import (
    BAD_REQUEST,
    BadRequestError,
    NotAllowedError,
    NotFoundError,
    NotLoggedInError,
    SetupError,
    WebError,
)
from gpr20_web.low.event_streams import EventStreams, json_text

MAX_BODY_BYTES, MAX_HEADER_BYTES = 64 * 1024, 16 * 1024
# So much is read, and not kept, so that whoever sends too much gets an answer.
MAX_READ_BYTES = 16 * MAX_BODY_BYTES
READ_LIMIT_S, IDLE_CONNECTION_S = 10.0, 120.0
# A browser that watches and whose computer has not answered for so long is gone [s].
BROKEN_S = 10.0
# Each has a descriptor, of which a process usually has 1024: without any, nothing works.
MAX_CONNECTIONS = 512
THREADS, LOGIN_THREADS = 8, 2
# "__Host-": browsers take it only with Secure, for this host alone and for every path.
COOKIE = "__Host-session"
JSON = "application/json"
POLICY = (
    "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'; "
    "object-src 'none'"
)
# Nothing from outside, no frame around it, no address of it for others. No HSTS: it would
# forbid a person to accept the certificate that the installation made.
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
    "Cache-Control": "no-store",
}


class HttpServer:
    """Answers browsers; belongs to the thread of its event loop.

    Args:
        routes: Everything that can be asked for; what is not in it cannot be reached.
        files: What everybody may load, by its path; of a page, the scripts in it are run.
        find: Returns the person of a cookie and an address, or raises NotLoggedInError.
        report: Takes an exception that no error of the project is, to be logged.
    """

    def __init__(
        self,
        routes: Sequence[Route],
        files: Mapping[str, File],
        find: Callable[[str, str], Person],
        report: Callable[[BaseException], None],
    ) -> None:
        self.streams = EventStreams(lambda one: find(one.session, one.address))
        self._pools = {
            name: ThreadPoolExecutor(count, thread_name_prefix=name)
            for name, count in (("work", THREADS), ("logins", LOGIN_THREADS))
        }
        by_path: Dict[str, Dict[str, Route]] = {}
        for one in routes:
            by_path.setdefault(one.pattern, {})[one.method] = one
        # Of the handlers below.
        settings: Dict[str, Any] = {"find": find, "report": report, **self._pools}
        self._application = web.Application(
            [
                *((path, _RouteHandler, {"routes": found}) for path, found in by_path.items()),
                *((re.escape(path), _FileHandler, {"file": one}) for path, one in files.items()),
                (r".*", _RouteHandler, {"routes": {}}),
            ],
            compress_response=True,
            log_function=lambda _handler: None,  # the logs of the surveys say who did what
            streams=self.streams,
            **settings,
        )
        self._server: Optional[httpserver.HTTPServer] = None

    def listen(self, address: str, port: int, context: Optional[ssl.SSLContext]) -> int:
        """Answer from now on; return the port.

        Args:
            address: Of the interface.
            port: 0: a free one.
            context: Key and certificate; None: without encryption, for tests of this class.

        Raises:
            SetupError: The address is not one of this computer, or the port is taken.
        """
        try:
            sockets = netutil.bind_sockets(port, address)
            if not sockets:  # an IPv6 address, and this computer has no IPv6
                raise OSError(errno.EADDRNOTAVAIL, os.strerror(errno.EADDRNOTAVAIL))
        except OSError as error:
            raise SetupError(
                Message(
                    "the page cannot listen at {address}, port {port} of web.yaml: {reason}",
                    address=address,
                    port=port,
                    reason=os_reason(error),
                    details=error,
                )
            ) from error
        self._server = _BoundedServer(
            self._application,
            ssl_options=context,
            max_body_size=MAX_READ_BYTES,
            max_header_size=MAX_HEADER_BYTES,
            body_timeout=READ_LIMIT_S,
            idle_connection_timeout=IDLE_CONNECTION_S,
        )
        self._server.add_sockets(sockets)
        return int(sockets[0].getsockname()[1])

    async def close(self) -> None:
        """End every answer."""
        self.streams.end()
        if self._server is not None:
            self._server.stop()
            await self._server.close_all_connections()
        for threads in self._pools.values():
            threads.shutdown(wait=False)


class _BoundedServer(httpserver.HTTPServer):
    """Closes further connections at once when there are too many."""

    def handle_stream(self, stream: IOStream, address: Any) -> None:
        if len(self._connections) < MAX_CONNECTIONS:
            super().handle_stream(stream, address)
        else:
            stream.close()


# Otherwise tornado itself reads forms, before any check; tornado 6.4 takes seconds for some.
@web.stream_request_body
class _PageHandler(web.RequestHandler):
    """What all answers have in common; the settings of the application are those of HttpServer."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        self._body = bytearray()
        # Of a stream: the browser has left.
        self._gone: Optional[asyncio.Future[None]] = None
        super().__init__(*arguments, **settings)

    def on_connection_close(self) -> None:
        """Tornado: nobody else says so to what waits for a browser to read."""
        if self._gone is not None and not self._gone.done():
            self._gone.set_result(None)

    def data_received(self, chunk: bytes) -> None:
        """Tornado: take a part of the body."""
        if len(self._body) <= MAX_BODY_BYTES:
            self._body += chunk

    def set_default_headers(self) -> None:
        """Tornado: set what every answer has, also one of an error."""
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def log_exception(self, kind: Any, error: Any, trace: Any) -> None:
        """Tornado: report a fault of the program."""
        if not isinstance(error, (Gpr20Error, web.HTTPError, StreamClosedError)):
            self.settings["report"](error)

    def send_error(self, status_code: int = 500, **kwargs: Any) -> None:
        """Tornado: an error behind a part of a download would end it as if it were whole."""
        if self._headers_written:
            self._connection.close()
        else:
            super().send_error(status_code, **kwargs)

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        """Tornado: write an error, without what it knows of this program."""
        error, text = kwargs.get("exc_info", (None, None))[1], read_catalogue(self.language).text
        if isinstance(error, Gpr20Error):
            self.set_status(error.status if isinstance(error, WebError) else 409)
            first = first_step(error.message)
            self.send_json(
                {
                    "error": text(error.message),
                    "remedy": "" if first is None else text(first),
                    "code": error.message.fault_code,
                }
            )
            return
        said = Message("The request was refused.")
        if status_code >= 500:
            said = Message("The page has a fault of its own; its log says which.")
        self.send_json({"error": text(said)})

    @property
    def _connection(self) -> IOStream:
        connection = self.request.connection
        assert isinstance(connection, HTTP1Connection)
        return connection.stream

    @cached_property
    def language(self) -> Language:
        """The language that a page asks for."""
        asked = self.request.query_arguments.get("language", [b""])[-1].decode("ascii", "replace")
        return next((one for one in languages() if one.value == asked), Language.ENGLISH)

    def send_json(self, values: Mapping[str, Any]) -> None:
        """End the answer with an object."""
        self.set_header("Content-Type", f"{JSON}; charset=UTF-8")
        self.finish(json_text(values))


class _FileHandler(_PageHandler):
    """A file of the page; the browser asks each time, so that an update reaches it."""

    def initialize(self, file: File) -> None:
        """Tornado: take the file."""
        self._file = file

    def get(self) -> None:
        """Answer with the file, or that the browser has it."""
        self.set_header("Cache-Control", "no-cache")
        self.set_header("Content-Security-Policy", _policy_of(self._file.content))
        self.set_header("Content-Type", self._file.kind)
        self.finish(self._file.content)


class _RouteHandler(_PageHandler):
    """Answers one path by its routes."""

    def initialize(self, routes: Mapping[str, Route]) -> None:
        """Tornado: take the routes by their methods."""
        self._routes = routes

    async def get(self, **parts: str) -> None:
        """Answer a request; a GET changes nothing."""
        route = self._routes.get(self.request.method or "")
        if route is None:
            path = self.request.path[:80]
            raise NotFoundError(Message("there is no page {path}", path=path))
        self._check_origin()
        address, person = str(self.request.remote_ip), None
        try:
            person = self.settings["find"](self.get_cookie(COOKIE) or "", address)
        except NotLoggedInError:
            if route.right is not Role.NOBODY:
                raise
        if person is not None and person.role < route.right:
            raise NotAllowedError(
                Message(
                    "{name} has the right {role}; this needs {right}",
                    name=person.name,
                    role=person.role.word,
                    right=route.right.word,
                )
            )
        call = Call(person, address, self._values(), parts, self.language)
        if route.blocking:
            # Whatever the others wait for, who is not logged in yet gets in.
            pool = "logins" if route.right is Role.NOBODY else "work"
            await self._send(await self._in_thread(pool, route.answer, call), call)
        else:
            await self._send(route.answer(call), call)

    post = get

    def _check_origin(self) -> None:
        """Refuse what another page has made a browser send.

        Raises:
            NotAllowedError: The request names another origin than this page's, or none.
        """
        headers = self.request.headers
        own = f"{self.request.protocol}://{self.request.host}"
        kind = headers.get("Content-Type", "").partition(";")[0].strip()
        # Every present browser says so; a page at another port has the cookie sent too.
        is_foreign = headers.get("Sec-Fetch-Site") in ("same-site", "cross-site")
        if self.request.method != "GET":
            is_foreign |= headers.get("Origin", "") != own or kind != JSON
        if is_foreign:
            raise NotAllowedError(
                Message("the request does not come from this page"), fault=BAD_REQUEST
            )

    def _values(self) -> Mapping[str, Any]:
        """Return the query of a GET, or the JSON object of a POST."""
        if len(self._body) > MAX_BODY_BYTES:
            raise web.HTTPError(413)
        try:
            if self.request.method == "GET":
                given = self.request.query_arguments.items()
                return {name: one[-1].decode() for name, one in given if name != "language"}
            values = json.loads(self._body or b"{}")
            if not isinstance(values, dict):
                raise ValueError("no object")
            return values
        except (ValueError, RecursionError) as error:
            raise BadRequestError(Message("the request cannot be read")) from error

    async def _send(self, answer: Answer, call: Call) -> None:
        if callable(answer):
            await self._watch(answer, call.who)
        elif isinstance(answer, Body):
            await self._send_body(answer)
        elif isinstance(answer, Cookie):
            flags: Dict[str, Any] = {"path": "/", "secure": True, "httponly": True}
            # An empty one has ended in 1970: the browser forgets it.
            expires = None if answer.session else 1.0
            self.set_cookie(COOKIE, answer.session, expires=expires, samesite="Strict", **flags)
            self.send_json(answer.values)
        else:
            self.send_json(answer)

    async def _watch(self, document: Callable[[], Document], person: Person) -> None:
        with self.settings["streams"].watching(person):
            gone = self._gone = asyncio.get_event_loop().create_future()
            if not self._connection.closed():
                # Without this, a browser whose link is lost would be there for 15 min.
                end_when_broken(self._connection.socket, BROKEN_S)
            self.set_header("Content-Type", "text/event-stream")
            async for event in self.settings["streams"].events(document, person):
                self.write(event)
                sent = asyncio.ensure_future(self.flush())
                await asyncio.wait([sent, gone], return_when=asyncio.FIRST_COMPLETED)
                if gone.done():
                    return
                sent.result()

    async def _send_body(self, body: Body) -> None:
        self.set_header("Content-Type", body.kind)
        if body.name:
            self.set_header("Content-Disposition", f'attachment; filename="{body.name}"')
        if isinstance(body.content, bytes):
            self.finish(body.content)
            return
        parts = iter(body.content)
        part = await self._in_thread("work", next, parts, None)
        while part is not None:
            self.write(part)
            await self.flush()
            part = await self._in_thread("work", next, parts, None)
        self.finish()

    async def _in_thread(self, pool: str, work: Any, *arguments: Any) -> Any:
        loop = asyncio.get_event_loop()
        return await loop.run_in_executor(self.settings[pool], work, *arguments)


@lru_cache(maxsize=None)
def _policy_of(page: bytes) -> str:
    """Return the policy that lets the scripts and styles in a page run, and no others."""
    inside = re.findall(rb"<(script|style)>(.*?)</\1>", page, re.DOTALL)
    sums = (b64encode(sha256(one).digest()).decode() for _kind, one in inside)
    own = " ".join(["'self'", *(f"'sha256-{one}'" for one in sums)])
    return f"{POLICY}; script-src {own}; style-src {own}"

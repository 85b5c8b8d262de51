"""One request: finds its route, checks origin and right, and writes the answer."""

from __future__ import annotations

import asyncio
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any, Awaitable, Callable, Dict, Iterator, Mapping, Optional, Tuple

from tornado import web
from tornado.http1connection import HTTP1Connection
from tornado.iostream import StreamClosedError

from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.errors import Gpr20Error
from gpr20_common.low.links import end_when_broken
from gpr20_common.message import Message
from gpr20_operator.robot.condition import first_step
from gpr20_web import faults
from gpr20_web.calls import Answer, Body, Call, Cookie, Person, Route, Routes, Stream
from gpr20_web.errors import BusyError, NotAllowedError, NotFoundError, WebError
from gpr20_web.low.event_streams import EventStreams, Watcher, json_text
from gpr20_web.low.request_reading import language_of, object_of, path_of, query_of
from gpr20_web.low.static_files import StaticFile
from gpr20_web.roles import Role

# "__Host-": browsers take it only with Secure, for this host alone and for every path.
COOKIE = "__Host-session"
# In seconds since 1970.
LONG_AGO = 1.0
MAX_WAITING = 32
# A browser that watches and whose computer has not answered for so long is gone [s].
BROKEN_S = 10.0
JSON = "application/json"
# Nothing from outside, no frame around it, no address of it for others. No HSTS: it would
# forbid a person to accept the certificate that the installation made.
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'; "
        "object-src 'none'"
    ),
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
    "Cache-Control": "no-store",
}


@dataclass
class Pool:
    """Threads, and how many requests wait for them or are in them."""

    threads: Executor
    waiting: int = 0


@dataclass
class Site:
    """What every request needs.

    Attributes:
        routes: Everything that can be asked for.
        find: Returns the person of a session and an address, or raises NotLoggedInError.
        report: Takes an exception that no error of the project is, to be logged.
        work: For requests that wait for files or nodes.
        logins: For those who are not logged in yet: whatever the others wait for, they get in.
    """

    routes: Routes
    files: Mapping[str, StaticFile]
    find: Callable[[str, str], Person]
    report: Callable[[BaseException], None]
    streams: EventStreams
    work: Pool
    logins: Pool


# Otherwise tornado itself reads forms, before any check; tornado 6.4 takes seconds for some.
@web.stream_request_body
class TableHandler(web.RequestHandler):
    """Answers by the table alone."""

    def initialize(self, site: Site) -> None:
        """Tornado: take what every request needs."""
        self._site = site
        self._text: Callable[[Message], str] = str
        self._watcher: Optional[Watcher] = None
        self._body = bytearray()

    def data_received(self, chunk: bytes) -> None:
        """Tornado: take a part of the body, which is no longer than the server allows."""
        self._body += chunk

    def set_default_headers(self) -> None:
        """Tornado: set what every answer has, also one of an error."""
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def get(self) -> Awaitable[None]:
        """Answer a request that changes nothing."""
        return self._serve()

    def post(self) -> Awaitable[None]:
        return self._serve()

    def on_connection_close(self) -> None:
        """Tornado: the browser has left."""
        if self._watcher is not None:
            self._watcher.gone.set()

    def write_error(self, status_code: int, **_kwargs: Any) -> None:
        """Tornado: write an error of its own, without what it knows of this program."""
        self._send_json({"error": self._text(Message("The request was refused."))})

    async def _serve(self) -> None:
        try:
            query = query_of(self.request.query)
            # First of all: whatever is refused is refused in it.
            language = self._choose_language(query.pop("language", ""))
            path = path_of(self.request.path)
            if not path.startswith("/api/"):
                self._send_file(path)
                return
            route, parts = self._route(path)
            call = self._call(route, parts, query, language)
            await self._write(await self._answer(route, call), call)
        except Gpr20Error as error:
            self._refuse(error)
        except StreamClosedError:
            return  # the browser has left
        except Exception as error:  # the last place: the others must be served
            self._site.report(error)
            self.set_status(500)
            words = Message("The page has a fault of its own; its log says which.")
            self._send_json({"error": self._text(words)})

    def _send_file(self, path: str) -> None:
        file = self._site.files.get("/index.html" if path == "/" else path)
        if file is None or self.request.method != "GET":
            raise _not_found(path)
        self.set_header("Content-Type", file.kind)
        self.set_header("ETag", file.tag)
        # The browser asks each time, so that an update of the robot reaches it.
        self.set_header("Cache-Control", "no-cache")
        if self.request.headers.get("If-None-Match") == file.tag:
            self.set_status(304)
            self.finish()
        else:
            self.finish(file.content)

    def _route(self, path: str) -> Tuple[Route, Mapping[str, str]]:
        for route in self._site.routes:
            parts = route.match(path) if route.method == self.request.method else None
            if parts is not None:
                return route, parts
        raise _not_found(path)

    def _choose_language(self, code: str) -> Language:
        language = language_of(code, self.request.headers.get("Accept-Language", ""))
        self._text = read_catalogue(language).text
        return language

    def _call(
        self, route: Route, parts: Mapping[str, str], query: Mapping[str, str], language: Language
    ) -> Call:
        """Check a request and return it.

        Raises:
            WebError: It is not from this page, nobody is logged in, or has not the right.
        """
        self._check_origin(route.method)
        address = str(self.request.remote_ip)
        person = None
        if route.right is not Role.NOBODY:
            person = self._site.find(self.get_cookie(COOKIE) or "", address)
            if person.role < route.right:
                raise NotAllowedError(
                    Message(
                        "{name} has the right {role}; this needs {right}",
                        name=person.name,
                        role=person.role.word,
                        right=route.right.word,
                    )
                )
        values: Mapping[str, Any] = query
        if route.method != "GET":
            values = object_of(bytes(self._body))
        return Call(person, address, values, parts, language, self._text)

    def _check_origin(self, method: str) -> None:
        """Refuse what another page has made a browser send.

        Raises:
            NotAllowedError: The request names another origin than this page's, or none.
        """
        headers = self.request.headers
        own = f"{self.request.protocol}://{self.request.host}"
        kind = headers.get("Content-Type", "").partition(";")[0].strip()
        # Every present browser says so; a page at another port has the cookie sent too.
        is_foreign = headers.get("Sec-Fetch-Site") in ("same-site", "cross-site")
        if method != "GET":
            is_foreign |= headers.get("Origin", "") != own or kind != JSON
        if is_foreign:
            raise NotAllowedError(
                Message("the request does not come from this page"), fault=faults.BAD_REQUEST
            )

    async def _answer(self, route: Route, call: Call) -> Answer:
        site = self._site
        if not route.blocking:
            return route.answer(call)
        pool = site.logins if route.right is Role.NOBODY else site.work
        if pool.waiting >= MAX_WAITING:
            raise BusyError(
                Message("the page has too much to do: {count} requests wait", count=pool.waiting)
            )
        pool.waiting += 1
        try:
            return await asyncio.get_event_loop().run_in_executor(pool.threads, route.answer, call)
        finally:
            pool.waiting -= 1

    async def _write(self, answer: Answer, call: Call) -> None:
        if isinstance(answer, Stream):
            await self._watch(answer, call)
        elif isinstance(answer, Body):
            await self._send_body(answer)
        elif isinstance(answer, Cookie):
            flags: Dict[str, Any] = {"path": "/", "secure": True, "httponly": True}
            # An empty one has ended: the browser forgets it.
            expires = None if answer.session else LONG_AGO
            self.set_cookie(COOKIE, answer.session, expires=expires, samesite="Strict", **flags)
            self._send_json(answer.values)
        else:
            self._send_json(answer)

    async def _watch(self, stream: Stream, call: Call) -> None:
        watcher = self._watcher = self._site.streams.add(self, stream, call.who)
        connection = self.request.connection
        try:
            if isinstance(connection, HTTP1Connection) and not connection.stream.closed():
                # Without this, a browser whose link is lost would be there for 15 min.
                end_when_broken(connection.stream.socket, BROKEN_S)
            self.set_header("Content-Type", "text/event-stream")
            await self.flush()
            await watcher.gone.wait()
        finally:
            self._site.streams.remove(watcher)

    async def _send_body(self, body: Body) -> None:
        self.set_header("Content-Type", body.kind)
        if body.name:
            self.set_header("Content-Disposition", f'attachment; filename="{body.name}"')
        if isinstance(body.content, bytes):
            self.finish(body.content)
            return
        loop, parts = asyncio.get_event_loop(), iter(body.content)
        part = await loop.run_in_executor(self._site.work.threads, _next, parts)
        while part is not None:
            self.write(part)
            await self.flush()
            part = await loop.run_in_executor(self._site.work.threads, _next, parts)
        self.finish()

    def _send_json(self, values: Mapping[str, Any]) -> None:
        connection = self.request.connection
        if self._headers_written and isinstance(connection, HTTP1Connection):
            # An error behind a part of a download would end it as if it were whole.
            connection.close()
            return
        self.set_header("Content-Type", f"{JSON}; charset=UTF-8")
        self.finish(json_text(values))

    def _refuse(self, error: Gpr20Error) -> None:
        self.set_status(error.status if isinstance(error, WebError) else 409)
        message = error.message
        first = first_step(message)
        remedy = "" if first is None else self._text(first)
        self._send_json(
            {"error": self._text(message), "remedy": remedy, "code": message.fault_code}
        )


def _not_found(path: str) -> NotFoundError:
    return NotFoundError(Message("there is no page {path}", path=path[:80]))


def _next(parts: Iterator[bytes]) -> Optional[bytes]:
    return next(parts, None)

"""One request, by tornado: a file of the pages, or a route with its right."""

from __future__ import annotations

import asyncio
import json
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any, Awaitable, Callable, Dict, Iterator, List, Mapping, Optional

from tornado import web
from tornado.http1connection import HTTP1Connection
from tornado.iostream import StreamClosedError

from gpr20_common.catalogue import Language, language_from_code, languages, read_catalogue
from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.low.links import end_when_broken
from gpr20_common.message import Message
from gpr20_operator.robot.condition import first_step
from gpr20_web import faults
from gpr20_web.calls import Answer, Body, Call, Cookie, Person, Role, Route, Stream
from gpr20_web.errors import (
    BadRequestError,
    BusyError,
    NotAllowedError,
    NotFoundError,
    WebError,
)
from gpr20_web.low.event_streams import EventStreams, Watcher, json_text

# "__Host-": browsers take it only with Secure, for this host alone and for every path.
COOKIE = "__Host-session"
# In seconds since 1970.
LONG_AGO = 1.0
MAX_WAITING = 32
# A browser that watches and whose computer has not answered for so long is gone [s].
BROKEN_S = 10.0
MAX_LANGUAGES_CHARACTERS = 200
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
        find: Returns the person of a cookie and an address, or raises NotLoggedInError.
        report: Takes an exception that no error of the project is, to be logged.
        work: For requests that wait for files or nodes.
        logins: For those who are not logged in yet: whatever the others wait for, they get in.
    """

    find: Callable[[str, str], Person]
    report: Callable[[BaseException], None]
    streams: EventStreams
    work: Pool
    logins: Pool


# Otherwise tornado itself reads forms, before any check; tornado 6.4 takes seconds for some.
@web.stream_request_body
class PageHandler(web.RequestHandler):
    """What all answers have in common; it refuses what no other handler takes."""

    def initialize(self, site: Site) -> None:
        """Tornado: take what every request needs."""
        self._site = site
        self._body = bytearray()

    def data_received(self, chunk: bytes) -> None:
        """Tornado: take a part of the body, which is no longer than the server allows."""
        self._body += chunk

    def set_default_headers(self) -> None:
        """Tornado: set what every answer has, also one of an error."""
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def prepare(self) -> None:
        """Tornado: refuse what no other handler takes."""
        self._refuse(NotFoundError(Message("there is no page {path}", path=self.request.path[:80])))

    def write_error(self, status_code: int, **_kwargs: Any) -> None:
        """Tornado: write an error of its own, without what it knows of this program."""
        self._send_json({"error": self._text(Message("The request was refused."))})

    def _language(self) -> Language:
        """Return the language that a page asks for, else one that its browser accepts."""
        accepted = self.request.headers.get("Accept-Language", "")[:MAX_LANGUAGES_CHARACTERS]
        asked = self.request.query_arguments.get("language", [b""])[-1].decode("ascii", "replace")
        known = {one.value for one in languages()}
        wanted = (
            one.strip().partition("-")[0].lower()
            for one in (asked, *accepted.replace(";", ",").split(","))
        )
        found = next((one for one in wanted if one in known), Language.ENGLISH.value)
        try:
            language = language_from_code(found)
            read_catalogue(language)
        except InvalidValueError:
            # The catalogue was damaged since: a page in English is better than none.
            return Language.ENGLISH
        return language

    def _text(self, message: Message) -> str:
        return read_catalogue(self._language()).text(message)

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


@web.stream_request_body
class FileHandler(web.StaticFileHandler):
    """A file of the pages; the browser asks each time, so that an update reaches it."""

    def data_received(self, chunk: bytes) -> None:
        """Tornado: ignore what is sent with a request for a file."""

    def set_default_headers(self) -> None:
        """Tornado: set what every answer has."""
        PageHandler.set_default_headers(self)  # type: ignore[arg-type]

    def set_extra_headers(self, path: str) -> None:
        """Tornado: replace what is for answers that are made."""
        self.set_header("Cache-Control", "no-cache")

    def write_error(self, status_code: int, **_kwargs: Any) -> None:
        """Tornado: write an error without what it knows of this program."""
        self.finish()


class RouteHandler(PageHandler):
    """Answers one path by its routes."""

    def initialize(  # type: ignore[override]
        self, site: Site, routes: Mapping[str, Route]
    ) -> None:
        """Tornado: take what every request needs, and the routes by their methods."""
        super().initialize(site)
        self._routes = routes
        self._watcher: Optional[Watcher] = None

    def prepare(self) -> None:
        """Tornado: do nothing before the request is read."""

    def get(self, **parts: str) -> Awaitable[None]:
        """Answer a request that changes nothing."""
        return self._serve(parts)

    def post(self, **parts: str) -> Awaitable[None]:
        """Answer a request that changes something."""
        return self._serve(parts)

    def on_connection_close(self) -> None:
        """Tornado: the browser has left."""
        if self._watcher is not None:
            self._watcher.gone.set()

    async def _serve(self, parts: Mapping[str, str]) -> None:
        try:
            method = self.request.method or ""
            route = self._routes.get(method)
            if route is None:
                path = self.request.path[:80]
                raise NotFoundError(Message("there is no page {path}", path=path))
            call = self._call(route, parts)
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

    def _call(self, route: Route, parts: Mapping[str, str]) -> Call:
        """Check a request and return it.

        Raises:
            WebError: It is not from this page, nobody is logged in, or has not the right.
        """
        self._check_origin()
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
        is_get = route.method == "GET"
        values = _fields(self.request.query_arguments) if is_get else _object(bytes(self._body))
        return Call(person, address, values, parts, self._language(), self._text)

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
                Message("the request does not come from this page"), fault=faults.BAD_REQUEST
            )

    async def _answer(self, route: Route, call: Call) -> Answer:
        if not route.blocking:
            return route.answer(call)
        pool = self._site.logins if route.right is Role.NOBODY else self._site.work
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
        while True:
            part = await loop.run_in_executor(self._site.work.threads, _next, parts)
            if part is None:
                break
            self.write(part)
            await self.flush()
        self.finish()


def _next(parts: Iterator[bytes]) -> Optional[bytes]:
    return next(parts, None)


def _fields(given: Mapping[str, List[bytes]]) -> Dict[str, str]:
    try:
        return {name: values[-1].decode() for name, values in given.items() if name != "language"}
    except UnicodeDecodeError as error:
        raise BadRequestError(Message("the address is no text")) from error


def _object(body: bytes) -> Mapping[str, Any]:
    try:
        values = json.loads(body or b"{}", parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise BadRequestError(Message("the request is not JSON")) from error
    if not isinstance(values, dict):
        raise BadRequestError(Message("the request is no JSON object"))
    return values


def _refuse_constant(name: str) -> None:
    raise ValueError(name)

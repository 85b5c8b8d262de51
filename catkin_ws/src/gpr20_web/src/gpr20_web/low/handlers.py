"""One request, by tornado: a file of the pages, or a route with its right."""

from __future__ import annotations

import asyncio
import json
import re
from functools import cached_property
from typing import Any, Dict, List, Mapping, Optional

from tornado import web
from tornado.http1connection import HTTP1Connection
from tornado.iostream import IOStream, StreamClosedError

from gpr20_common.catalogue import Language, languages, read_catalogue
from gpr20_common.errors import Gpr20Error
from gpr20_common.low.links import end_when_broken
from gpr20_common.message import Message
from gpr20_operator.robot.condition import first_step
from gpr20_web import faults
from gpr20_web.calls import Answer, Body, Call, Cookie, Person, Role, Route, Stream
from gpr20_web.errors import BadRequestError, NotAllowedError, NotFoundError, WebError
from gpr20_web.low.event_streams import json_text

# "__Host-": browsers take it only with Secure, for this host alone and for every path.
COOKIE = "__Host-session"
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


# Otherwise tornado itself reads forms, before any check; tornado 6.4 takes seconds for some.
@web.stream_request_body
class PageHandler(web.RequestHandler):
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
        """Tornado: take a part of the body, which is no longer than the server allows."""
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
        error = kwargs.get("exc_info", (None, None))[1]
        if isinstance(error, Gpr20Error):
            self.set_status(error.status if isinstance(error, WebError) else 409)
            first = first_step(error.message)
            self.send_json(
                {
                    "error": self.text(error.message),
                    "remedy": "" if first is None else self.text(first),
                    "code": error.message.fault_code,
                }
            )
            return
        said = Message("The request was refused.")
        if status_code >= 500:
            said = Message("The page has a fault of its own; its log says which.")
        self.send_json({"error": self.text(said)})

    @property
    def _connection(self) -> IOStream:
        connection = self.request.connection
        assert isinstance(connection, HTTP1Connection)
        return connection.stream

    @cached_property
    def language(self) -> Language:
        """The language that a page asks for, else one that its browser accepts."""
        asked = self.request.query_arguments.get("language", [b""])[-1].decode("ascii", "replace")
        accepted = self.request.headers.get("Accept-Language", "")
        known = {one.value: one for one in languages()}
        codes = re.split("[,;]", f"{asked},{accepted}")
        found = (known.get(one.strip().partition("-")[0].lower()) for one in codes)
        return next(filter(None, found), Language.ENGLISH)

    def text(self, message: Message) -> str:
        """Return a message in the language of the browser."""
        return read_catalogue(self.language).text(message)

    def send_json(self, values: Mapping[str, Any]) -> None:
        """End the answer with an object."""
        self.set_header("Content-Type", f"{JSON}; charset=UTF-8")
        self.finish(json_text(values))


class FileHandler(PageHandler, web.StaticFileHandler):
    """A file of the pages; the browser asks each time, so that an update reaches it."""

    def set_extra_headers(self, path: str) -> None:
        """Tornado: replace what is for answers that are made."""
        self.set_header("Cache-Control", "no-cache")


class RouteHandler(PageHandler):
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
        call = self._call(route, parts)
        if route.blocking:
            # Whatever the others wait for, who is not logged in yet gets in.
            pool = "logins" if route.right is Role.NOBODY else "work"
            answer = await self._in_thread(pool, route.answer, call)
        else:
            answer = route.answer(call)
        await self._send(answer, call)

    post = get

    def _call(self, route: Route, parts: Mapping[str, str]) -> Call:
        """Check a request and return it.

        Raises:
            WebError: It is not from this page, nobody is logged in, or has not the right.
        """
        self._check_origin()
        address = str(self.request.remote_ip)
        person = None
        if route.right is not Role.NOBODY:
            person = self.settings["find"](self.get_cookie(COOKIE) or "", address)
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
        return Call(person, address, values, parts, self.language, self.text)

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

    async def _send(self, answer: Answer, call: Call) -> None:
        if isinstance(answer, Stream):
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

    async def _watch(self, stream: Stream, person: Person) -> None:
        with self.settings["streams"].watching(person):
            gone = self._gone = asyncio.get_event_loop().create_future()
            if not self._connection.closed():
                # Without this, a browser whose link is lost would be there for 15 min.
                end_when_broken(self._connection.socket, BROKEN_S)
            self.set_header("Content-Type", "text/event-stream")
            async for event in self.settings["streams"].events(stream, person):
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

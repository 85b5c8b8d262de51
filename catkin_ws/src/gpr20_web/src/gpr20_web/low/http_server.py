"""The pages and their routes over HTTPS, by tornado."""

from __future__ import annotations

import errno
import os
import ssl
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable, Dict, Optional

from tornado import httpserver, netutil, web
from tornado.iostream import IOStream

from gpr20_common.errors import os_reason
from gpr20_common.message import Message
from gpr20_web.calls import Person, Route, Routes
from gpr20_web.errors import SetupError
from gpr20_web.low.event_streams import EventStreams
from gpr20_web.low.handlers import FileHandler, RouteHandler

MAX_BODY_BYTES, MAX_HEADER_BYTES = 64 * 1024, 16 * 1024
READ_LIMIT_S, IDLE_CONNECTION_S = 10.0, 120.0
# Each has a descriptor, of which a process usually has 1024: without any, nothing works.
MAX_CONNECTIONS = 512
THREADS, LOGIN_THREADS = 8, 2
# A file of the pages; without a name it is the first one.
FILES = r"/((?:(?:[a-z]+/)?[a-z_]+\.[a-z]+)?)"


class _BoundedServer(httpserver.HTTPServer):
    """Closes further connections at once when there are too many."""

    def handle_stream(self, stream: IOStream, address: Any) -> None:
        if len(self._connections) < MAX_CONNECTIONS:
            super().handle_stream(stream, address)
        else:
            stream.close()


class HttpServer:
    """Answers browsers; belongs to the thread of its event loop.

    Args:
        routes: Everything that can be asked for; what is not in it cannot be reached.
        static: Folder of the pages.
        find: Returns the person of a cookie and an address, or raises NotLoggedInError.
        report: Takes an exception that no error of the project is, to be logged.
    """

    def __init__(
        self,
        routes: Routes,
        static: Path,
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
        files = {"path": str(static), "default_filename": "index.html"}
        settings: Dict[str, Any] = {"find": find, "report": report, **self._pools}
        self._application = web.Application(
            [
                *((path, RouteHandler, {"routes": found}) for path, found in by_path.items()),
                (FILES, FileHandler, files),
                (r".*", RouteHandler, {"routes": {}}),
            ],
            streams=self.streams,
            compress_response=True,
            **settings,
            log_function=lambda _handler: None,  # the logs of the surveys say who did what
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
            max_body_size=MAX_BODY_BYTES,
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

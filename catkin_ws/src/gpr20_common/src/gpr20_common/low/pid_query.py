"""Asking one node for the number of its process, many times."""

from __future__ import annotations

import re
import socket
from typing import Optional, Tuple
from urllib.parse import urlsplit
from xml.sax.saxutils import escape

from gpr20_common.low.limited_rpc import SUCCESS

REQUEST = (
    '<?xml version="1.0"?><methodCall><methodName>getPid</methodName><params><param><value>'
    "<string>{caller_id}</string></value></param></params></methodCall>"
)
HEADER = (
    "POST / HTTP/1.1\r\nHost: {host}\r\nContent-Type: text/xml\r\nContent-Length: {length}\r\n\r\n"
)
END_OF_HEADER = b"\r\n\r\n"
LENGTH = re.compile(rb"\r\ncontent-length: *([0-9]{1,6})\r\n", re.IGNORECASE)
INTEGER = re.compile(rb"<(?:int|i4)>(-?[0-9]{1,10})</(?:int|i4)>")
MAX_ANSWER_BYTES = 65536


class PidQuery:
    """The method `getPid` of one node, over a connection that is kept; not for several threads.

    The main control asks every node about once a second; `xmlrpc.client` would take much of the
    processor time that it needs at rest.
    """

    def __init__(self, uri: str, caller_id: str, time_limit_s: float) -> None:
        """Connect to nothing yet.

        Args:
            uri: Address of the node's XML-RPC interface.
            caller_id: Name of the node that asks.
            time_limit_s: For each step of a query [s].

        Raises:
            ValueError: The address has no host or no port.
        """
        parts = urlsplit(uri)
        if parts.hostname is None or parts.port is None:
            raise ValueError(f"{uri} has no host or no port")
        self._address = (parts.hostname, parts.port)
        body = REQUEST.format(caller_id=escape(caller_id)).encode()
        header = HEADER.format(host=parts.netloc, length=len(body)).encode()
        self._request = header + body
        self._time_limit_s = time_limit_s
        self._socket: Optional[socket.socket] = None

    def ask(self) -> int:
        """Return the number of the node's process.

        Raises:
            OSError: The node does not answer.
            ValueError: It answers something else.
        """
        if self._socket is not None:
            try:
                return self._ask(self._socket)
            except ConnectionError:
                # Servers may end a connection between two requests.
                self.close()
        self._socket = socket.create_connection(self._address, self._time_limit_s)
        return self._ask(self._socket)

    def close(self) -> None:
        """End the connection, if there is one."""
        connection, self._socket = self._socket, None
        if connection is not None:
            connection.close()

    def _ask(self, connection: socket.socket) -> int:
        try:
            connection.sendall(self._request)
            header, body = self._receive(connection)
        except BaseException:
            # What comes later must not be taken for the answer to another request.
            self.close()
            raise
        if header.startswith(b"HTTP/1.0") or b"connection: close" in header.lower():
            self.close()
        numbers = [int(one) for one in INTEGER.findall(body)]
        # The answer is a code, a text and the number.
        if len(numbers) != 2 or numbers[0] != SUCCESS:
            raise ValueError(f"the answer to getPid is {body[:200]!r}")
        return numbers[1]

    def _receive(self, connection: socket.socket) -> Tuple[bytes, bytes]:
        received = b""
        while END_OF_HEADER not in received:
            received += self._part(connection, received)
        header, body = received.split(END_OF_HEADER, 1)
        found = LENGTH.search(header + b"\r\n")
        if found is None:
            raise ValueError(f"the answer to getPid has no length: {header[:200]!r}")
        while len(body) < int(found[1]):
            body += self._part(connection, body)
        return header, body

    def _part(self, connection: socket.socket, received: bytes) -> bytes:
        if len(received) > MAX_ANSWER_BYTES:
            raise ValueError(f"the answer to getPid has more than {MAX_ANSWER_BYTES} bytes")
        part = connection.recv(MAX_ANSWER_BYTES)
        if not part:
            raise ConnectionResetError("the connection was closed by the other side")
        return part

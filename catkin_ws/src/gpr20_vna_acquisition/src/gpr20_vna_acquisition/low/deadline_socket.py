"""A TCP connection with limits of time and size."""

from __future__ import annotations

import math
import select
import socket
import time

CHUNK_BYTES = 65536
MS_PER_S = 1000.0


class DeadlineSocket:
    """The calls of a socket that python-vxi11's RPC client uses, bounded and complete.

    The time limit of a plain socket restarts with every byte, so a peer that sends single
    bytes can block its caller for ever. Here it covers everything until it is set again. And
    `recv` returns all the bytes that were requested: the RPC client takes a record header that
    arrives in two segments for the end of the stream. What has arrived is received at once,
    because the RPC client requests each record in two parts.
    """

    def __init__(self, address: str, port: int, timeout_s: float, limit_bytes: int) -> None:
        """Connect.

        Args:
            address: Four decimal numbers.
            port: TCP port.
            timeout_s: Time limit [s] for connecting and everything until it is set again.
            limit_bytes: Most that is received [bytes] before the time limit is set again.

        Raises:
            OSError: The connection could not be made in time.
        """
        self._limit_bytes = limit_bytes
        self.settimeout(timeout_s)
        self._socket = socket.create_connection((address, port), timeout=timeout_s)
        # Requests are small and each waits for its answer: collecting them gains nothing.
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # A plain socket with a time limit costs two more system calls for each part.
        self._socket.setblocking(False)
        self._readable, self._writable = select.poll(), select.poll()
        self._readable.register(self._socket, select.POLLIN)
        self._writable.register(self._socket, select.POLLOUT)
        self._received = bytearray()

    def settimeout(self, timeout_s: float) -> None:
        """Restart both limits: `timeout_s` [s] in total from now on, and the full size."""
        self._timeout_s = timeout_s
        self._deadline_s = time.monotonic() + timeout_s
        self._remaining_bytes = self._limit_bytes

    def sendall(self, data: bytes) -> None:
        """Send all data, or raise OSError."""
        unsent = memoryview(data)
        while unsent:
            try:
                unsent = unsent[self._socket.send(unsent) :]
            except BlockingIOError:
                self._wait(self._writable)

    def recv(self, count: int) -> bytes:
        """Return exactly `count` bytes, or fewer if the stream ends before them.

        Raises:
            OSError: The time limit is exceeded, or the peer sends more than allowed.
        """
        if count > self._remaining_bytes:
            raise OSError(
                f"the peer announces {count} bytes where at most {self._remaining_bytes} "
                "more are expected"
            )
        self._remaining_bytes -= count
        while len(self._received) < count:
            self._wait(self._readable)
            try:
                part = self._socket.recv(CHUNK_BYTES)
            except BlockingIOError:
                continue
            if not part:
                break
            self._received += part
        wanted = bytes(self._received[:count])
        del self._received[:count]
        return wanted

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _wait(self, ready: select.poll) -> None:
        """Return when the socket is ready, or at the end of the connection.

        Raises:
            socket.timeout: It was not in time.
        """
        remaining_s = self._deadline_s - time.monotonic()
        if remaining_s <= 0.0 or not ready.poll(math.ceil(MS_PER_S * remaining_s)):
            raise socket.timeout(f"no complete answer within {self._timeout_s:g} s")

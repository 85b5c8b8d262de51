"""A TCP connection with limits of time and size."""

from __future__ import annotations

import socket
import time

CHUNK_BYTES = 65536


class DeadlineSocket:
    """The calls of a socket that python-vxi11's RPC client uses, bounded and complete.

    The time limit of a plain socket restarts with every byte, so a peer that sends single
    bytes can block its caller for ever. Here it covers everything until it is set again. And
    `recv` returns all the bytes that were requested: the RPC client takes a record header that
    arrives in two segments for the end of the stream.
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

    def settimeout(self, timeout_s: float) -> None:
        """Restart both limits: `timeout_s` [s] in total from now on, and the full size."""
        self._timeout_s = timeout_s
        self._deadline_s = time.monotonic() + timeout_s
        self._remaining_bytes = self._limit_bytes

    def sendall(self, data: bytes) -> None:
        """Send all data, or raise OSError."""
        self._socket.settimeout(self._remaining_s())
        self._socket.sendall(data)

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
        received = bytearray()
        while len(received) < count:
            self._socket.settimeout(self._remaining_s())
            part = self._socket.recv(min(count - len(received), CHUNK_BYTES))
            if not part:
                break
            received += part
        return bytes(received)

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _remaining_s(self) -> float:
        remaining_s = self._deadline_s - time.monotonic()
        if remaining_s <= 0.0:
            raise socket.timeout(f"no complete answer within {self._timeout_s:g} s")
        return remaining_s

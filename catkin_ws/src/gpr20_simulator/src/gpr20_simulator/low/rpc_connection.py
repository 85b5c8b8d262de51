"""One TCP connection of RPC, with its record marking."""

from __future__ import annotations

import socket
import struct
from typing import Optional

from gpr20_simulator.low.xdr import XdrError

LAST_FRAGMENT = 0x80000000
MOST_FRAGMENTS = 4096
# A client that does not take its replies for this long loses its connection.
SEND_TIMEOUT_S = 30.0


class RpcConnection:
    """One accepted TCP connection: records in, records out."""

    def __init__(self, sock: socket.socket, longest_record: int) -> None:
        self._socket = sock
        self._longest_record = longest_record
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # Limits sending alone: a client may be silent for as long as it likes.
        seconds = struct.pack("ll", int(SEND_TIMEOUT_S), 0)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, seconds)

    def is_gone(self) -> bool:
        """Return whether the client has closed the connection."""
        try:
            return self._socket.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True

    def drop(self) -> None:
        """Close the connection from any thread; whoever reads from it finds its end."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            # The client was quicker; closed is what it should be.
            return

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()

    def read_record(self) -> Optional[bytes]:
        """Return the next record, put together from its fragments; None at the end.

        Raises:
            XdrError: The record is longer, or in more fragments, than is allowed.
        """
        record = bytearray()
        for _ in range(MOST_FRAGMENTS):
            header = self._read_exactly(4)
            if header is None:
                return None
            word = int.from_bytes(header, "big")
            length = word & ~LAST_FRAGMENT
            if len(record) + length > self._longest_record:
                raise XdrError(f"a record of more than {self._longest_record} bytes")
            fragment = self._read_exactly(length)
            if fragment is None:
                return None
            record += fragment
            if word & LAST_FRAGMENT:
                return bytes(record)
        raise XdrError(f"a record of more than {MOST_FRAGMENTS} fragments")

    def write_record(self, record: bytes) -> bool:
        """Send a record as one fragment; return whether the client took it."""
        try:
            self._socket.sendall((len(record) | LAST_FRAGMENT).to_bytes(4, "big") + record)
        except OSError:
            return False
        return True

    def _read_exactly(self, length: int) -> Optional[bytes]:
        data = bytearray()
        while len(data) < length:
            try:
                piece = self._socket.recv(length - len(data))
            except OSError:
                # A connection that breaks has ended like one that is closed.
                return None
            if not piece:
                return None
            data += piece
        return bytes(data)

"""A VXI-11 server that misbehaves on request, byte by byte.

The portmapper and the core channel listen on the same port: the program number distinguishes them.
"""

from __future__ import annotations

import socket
import struct
import threading
import time
from typing import Callable, List, Optional

from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits

HOST = "127.0.0.1"
# For what comes, for an answer that never comes, and for nothing that ever comes.
PATIENT = LinkLimits(connect_s=30.0, answer_s=30.0)
IMPATIENT = LinkLimits(connect_s=30.0, answer_s=0.5)
QUICK = LinkLimits(connect_s=0.4, answer_s=0.3)
GETPORT, CREATE_LINK, WRITE, READ, CLEAR, DESTROY_LINK = 3, 10, 11, 12, 15, 23
LOCK = 18
END = 4


class HangUp(Exception):
    """Close the connection instead of answering."""


def wait_until(condition) -> None:
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline, "the condition did not come true in time"
        time.sleep(0.005)


def proper(_procedure: int, answer: bytes) -> bytes:
    return answer


def hang_up(_procedure: int, _proper: bytes) -> bytes:
    raise HangUp


def on(procedure: int, what):
    """Return what makes something else of the proper answer to one procedure."""
    return lambda called, answer: what(called, answer) if called == procedure else answer


def body(content: bytes):
    """Return what puts something else behind the head of a proper answer."""
    return lambda _called, answer: record(answer[4:28] + content)


def opaque(data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + data + b"\0" * (-len(data) % 4)


def read_reply(data: bytes, reason: int = END, error: int = 0) -> bytes:
    return struct.pack(">ii", error, reason) + opaque(data)


def record(payload: bytes) -> bytes:
    return struct.pack(">I", 0x80000000 | len(payload)) + payload


class HostileServer:
    """Answers properly, unless `spoil` makes something else of the proper record."""

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.spoil: Callable[[int, bytes], bytes] = proper
        # Sends bytes in its own way; used to drip them.
        self.send: Callable[[socket.socket, bytes], None] = lambda peer, data: peer.sendall(data)
        self.answer: Callable[[bytes], bytes] = lambda question: read_reply(b"<" + question + b">")
        self.mapped_port: Optional[int] = self.port
        self.receive_size = 65536
        self.calls: List[int] = []
        self.open_connections = 0
        self._question = b""
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                peer, _ = self._listener.accept()
            except OSError:
                return
            self.open_connections += 1
            threading.Thread(target=self._serve, args=(peer,), daemon=True).start()

    def _serve(self, peer: socket.socket) -> None:
        with peer:
            stream = peer.makefile("rb")
            try:
                while True:
                    header = stream.read(4)
                    if len(header) < 4:
                        return
                    call = stream.read(struct.unpack(">I", header)[0] & 0x7FFFFFFF)
                    xid, _, _, _, _, procedure = struct.unpack(">6I", call[:24])
                    self.calls.append(procedure)
                    result = self._result(procedure, call[40:])
                    accepted = struct.pack(">6I", xid, 1, 0, 0, 0, 0)
                    self.send(peer, self.spoil(procedure, record(accepted + result)))
            except (HangUp, OSError):
                return
            finally:
                self.open_connections -= 1

    def _result(self, procedure: int, arguments: bytes) -> bytes:
        if procedure == GETPORT:
            return struct.pack(">I", self.mapped_port or 0)
        if procedure == CREATE_LINK:
            return struct.pack(">iiII", 0, 7, 0, self.receive_size)
        if procedure == WRITE:
            length = struct.unpack(">I", arguments[16:20])[0]
            self._question = arguments[20 : 20 + length]
            return struct.pack(">iI", 0, length)
        if procedure == READ:
            return self.answer(self._question)
        return struct.pack(">i", 0)

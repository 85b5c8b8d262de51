"""A client of one socket that writes RPC by hand, rightly or wrongly."""

from __future__ import annotations

import socket
import struct
import time

LAST = 0x80000000
LIMIT_S = 20.0


def words(*values):
    return b"".join(struct.pack(">i" if value < 0 else ">I", value) for value in values)


def opaque(data):
    return words(len(data)) + data + b"\0" * (-len(data) % 4)


def call(program, version, procedure, arguments=b"", xid=7):
    return words(xid, 0, 2, program, version, procedure, 0, 0, 0, 0) + arguments


def record(message):
    return words(len(message) | LAST) + message


def unpack_words(data):
    return list(struct.unpack(f">{len(data) // 4}I", data[: len(data) // 4 * 4]))


class RawClient:
    """Sends any bytes, reads whole records."""

    def __init__(self, port, timeout_s=LIMIT_S):
        self.sock = socket.create_connection(("127.0.0.1", port), timeout=timeout_s)

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        self.sock.close()

    def send(self, data):
        self.sock.sendall(data)

    def exactly(self, length):
        data = b""
        while len(data) < length:
            piece = self.sock.recv(length - len(data))
            if not piece:
                raise EOFError("the server closed the connection")
            data += piece
        return data

    def reply(self):
        header = struct.unpack(">I", self.exactly(4))[0]
        assert header & LAST
        return self.exactly(header & ~LAST)

    def result(self, program, version, procedure, arguments=b""):
        """Call, and return what follows the head of a successful reply."""
        self.send(record(call(program, version, procedure, arguments)))
        reply = self.reply()
        assert unpack_words(reply[:24]) == [7, 1, 0, 0, 0, 0]
        return reply[24:]

    def is_closed(self):
        try:
            return self.sock.recv(1) == b""
        except ConnectionResetError:
            return True


def wait_until(condition, what, limit_s=LIMIT_S):
    deadline_s = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline_s, f"{what} did not happen within {limit_s} s"
        time.sleep(0.002)

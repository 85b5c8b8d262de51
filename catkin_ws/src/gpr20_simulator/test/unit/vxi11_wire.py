"""VXI-11 and RPC written by hand, rightly or wrongly, and a device to talk to."""

from __future__ import annotations

import socket
import struct
import time

from gpr20_simulator.low.message_device import ClearSupport, NetworkFault, Outcome

CORE, ABORT = 0x0607AF, 0x0607B0
END, WAIT_LOCK = 8, 1
REQUEST_COUNT, END_REASON = 1, 4
LAST = 0x80000000
LIMIT_S = 30.0


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


def wait_until(condition, what):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, f"{what} did not happen within {LIMIT_S} s"
        time.sleep(0.002)


class EchoDevice:
    """Answers whatever contains a question mark with itself."""

    def __init__(self):
        self.messages = []
        self.clears = 0
        self.fault = NetworkFault.NONE
        self.open_conduct = NetworkFault.NONE
        self.clear_support = ClearSupport.FULL
        self.reachable = True

    def is_reachable(self):
        return self.reachable

    def opened(self):
        return self.open_conduct

    def execute(self, message):
        self.messages.append(message)
        return Outcome(message if b"?" in message else b"", self.fault)

    def clear(self):
        self.clears += 1
        return self.clear_support

    def set_remote(self, remote):
        """It has no keys."""


class CoreLink(RawClient):
    """A connection to the core channel with one link."""

    def __init__(self, port, lock=0, lock_timeout_ms=0, name=b"inst0"):
        super().__init__(port)
        arguments = words(1, lock, lock_timeout_ms) + opaque(name)
        reply = self.result(CORE, 1, 10, arguments)
        self.error, self.link, self.abort_port, self.receive_size = struct.unpack(">iiII", reply)

    def write(self, data, flags=END, lock_timeout_ms=0, io_timeout_ms=1000):
        arguments = words(self.link, io_timeout_ms, lock_timeout_ms, flags) + opaque(data)
        return struct.unpack(">iI", self.result(CORE, 1, 11, arguments))

    def read(self, size=1000, flags=0, io_timeout_ms=1000, lock_timeout_ms=0):
        arguments = words(self.link, size, io_timeout_ms, lock_timeout_ms, flags, 0)
        reply = self.result(CORE, 1, 12, arguments)
        error, reason, length = struct.unpack(">iiI", reply[:12])
        return error, reason, reply[12 : 12 + length]

    def generic(self, procedure, flags=0, lock_timeout_ms=0, link=None):
        link = self.link if link is None else link
        reply = self.result(CORE, 1, procedure, words(link, flags, lock_timeout_ms, 1000))
        return struct.unpack(f">{len(reply) // 4}i", reply)

    def lock(self, flags=0, lock_timeout_ms=0):
        return struct.unpack(
            ">i", self.result(CORE, 1, 18, words(self.link, flags, lock_timeout_ms))
        )[0]

    def unlock(self):
        return struct.unpack(">i", self.result(CORE, 1, 19, words(self.link)))[0]

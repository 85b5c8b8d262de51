"""Whatever the other side does, the link answers, or fails in time with VnaConnectionError."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
import time
from typing import Callable, List, Optional

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from run_seed import draws
from wait_kit import wait_until

from gpr20_survey.faults import VNA_SILENT, WRONG_VNA
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, connect

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


@pytest.fixture
def server():
    one = HostileServer()
    yield one
    one.close()


@pytest.fixture
def link(server):
    return connect(HOST, PATIENT, server.port)


def test_an_answer_in_many_pieces_is_put_together(server, link):
    parts = [read_reply(b"ab", reason=0), read_reply(b"cd", reason=1), read_reply(b"ef")]
    server.answer = lambda question: parts.pop(0)

    def split(peer: socket.socket, data: bytes) -> None:
        # In the middle of the header of a record.
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        peer.sendall(data[:2])
        time.sleep(0.02)
        peer.sendall(data[2:])

    server.send = split
    assert link.ask_raw("X?") == b"abcdef"


def test_the_portmapper_is_asked_without_an_explicit_port(server):
    link = connect(HOST, PATIENT, portmapper_port=server.port)
    assert server.calls[0] == GETPORT and link.ask_raw("X?") == b"<X?>"
    server.mapped_port = None
    with raises_fault(WRONG_VNA):
        connect(HOST, PATIENT, portmapper_port=server.port)


@each_case("listens, by_portmapper", [(True, False), (True, True), (False, False)])
def test_a_host_that_never_answers_is_given_up_in_time_and_named(listens, by_portmapper):
    with socket.create_server((HOST, 0)) as silent:
        port = silent.getsockname()[1]
        if not listens:
            silent.close()
        with raises_fault(VNA_SILENT, HOST):
            connect(HOST, QUICK, *((None, port) if by_portmapper else (port,)))


@each_case("procedure", [WRITE, READ])
def test_a_dropped_connection_is_our_error_and_a_new_link_works(server, procedure):
    link = connect(HOST, PATIENT, server.port)
    server.spoil = on(procedure, hang_up)
    for _time in range(2):
        with raises_fault(VNA_SILENT, HOST):
            link.ask_raw("X?")
        server.spoil = proper
    wait_until(lambda: not server.open_connections)
    again = connect(HOST, PATIENT, server.port)
    assert again.ask_raw("Y?") == b"<Y?>"
    # Also when the link that has died is only closed.
    server.spoil = on(DESTROY_LINK, hang_up)
    again.close()
    wait_until(lambda: not server.open_connections)


def test_a_hanging_answer_ends_in_time_and_is_never_given_to_the_next_question(server):
    link = connect(HOST, IMPATIENT, server.port)
    release, usual = threading.Event(), server.answer

    def hang(question: bytes) -> bytes:
        release.wait(30.0)
        return read_reply(b"LATE")

    server.answer = hang
    with raises_fault(VNA_SILENT, "'X?'"):
        link.ask_raw("X?")
    server.answer = usual
    release.set()
    with pytest.raises(VnaConnectionError):
        link.ask_raw("Y?")
    assert connect(HOST, PATIENT, server.port).ask_raw("Y?") == b"<Y?>"


def test_a_dripping_answer_does_not_stretch_the_time_limit(server):
    link = connect(HOST, IMPATIENT, server.port)

    def drip(peer: socket.socket, data: bytes) -> None:
        for byte in data:
            peer.sendall(bytes([byte]))
            time.sleep(0.15)

    server.send = drip
    with pytest.raises(VnaConnectionError):
        link.ask_raw("X?")


@each_case(
    "spoil, answer",
    [
        (proper, read_reply(b"x" * 60000, reason=1)),
        # A giant record that is only announced takes no memory.
        (on(READ, lambda _called, _proper: struct.pack(">I", 0xFFFFFFFF) + b"x" * 100), b""),
    ],
)
def test_an_endless_answer_is_stopped(server, spoil, answer):
    server.spoil = proper
    link = connect(HOST, PATIENT, server.port)
    server.spoil, server.answer = spoil, lambda question: answer
    with raises_fault(VNA_SILENT):
        link.ask_raw("X?")
    assert server.calls.count(READ) < 50


@each_case(
    "content, fault, shown",
    [
        ((9, 0, 0, 0), VNA_SILENT, "9: "),
        ((11, 0, 0, 0), errors.LOCKED, "11: "),
        # It takes nothing at once.
        ((0, 7, 0, 0), WRONG_VNA, 1024),
    ],
)
def test_a_link_that_is_refused_or_useless_is_our_error_and_leaves_no_connection(
    server, content, fault, shown
):
    server.spoil = on(CREATE_LINK, body(struct.pack(">iiII", *content)))
    with raises_fault(fault, shown):
        connect(HOST, PATIENT, server.port)
    wait_until(lambda: not server.open_connections)


NO_PROCEDURE = struct.pack(">I", 3)


@each_case("procedure, call", [(CLEAR, "clear"), (LOCK, "lock")])
def test_what_an_instrument_does_not_offer_is_left_out_and_any_other_failure_reported(
    procedure, call
):
    server = HostileServer()
    link = connect(HOST, PATIENT, server.port)
    # A server that lacks a procedure says so in the head of the reply.
    for answer in (
        body(struct.pack(">i", 8)),
        lambda _called, answer: record(answer[4:24] + NO_PROCEDURE),
    ):
        server.spoil = on(procedure, answer)
        getattr(link, call)()
        assert link.ask_raw("X?") == b"<X?>"
    server.spoil = on(procedure, body(struct.pack(">i", 11)))
    with raises_fault(errors.LOCKED):
        getattr(link, call)()
    server.close()


@settings(max_examples=draws(10), suppress_health_check=list(HealthCheck))
@given(
    st.sampled_from([GETPORT, CREATE_LINK, WRITE, READ]),
    st.one_of(
        st.binary(min_size=1, max_size=64),
        st.binary(min_size=1, max_size=64).map(record),
        # A proper RPC header before it, so that the VXI-11 layer sees it.
        st.binary(max_size=40).map(body),
    ),
)
def test_no_garbage_raises_anything_but_our_error(server, procedure, garbage):
    server.spoil = on(procedure, garbage if callable(garbage) else lambda *_proper: garbage)
    with contextlib.suppress(VnaConnectionError):
        answer = connect(HOST, QUICK, portmapper_port=server.port).ask_raw("X?")
        assert isinstance(answer, bytes)


# What python-vxi11 0.9 does wrong does not reach the driver.


def with_xid(answer, change):
    xid = struct.unpack(">I", answer[4:8])[0]
    return answer[:4] + struct.pack(">I", xid + change) + answer[8:]


def test_a_late_reply_to_an_older_call_is_not_taken_for_the_answer(server, link):
    def late_first(_called, answer):
        return record(with_xid(answer, -1)[4:28] + read_reply(b"LATE")) + answer

    server.spoil = on(READ, late_first)
    assert link.ask_raw("X?") == b"<X?>"
    # Nor one to a call that was never made.
    server.spoil = on(READ, lambda _called, answer: with_xid(answer, 1))
    with raises_fault(VNA_SILENT):
        link.ask_raw("X?")

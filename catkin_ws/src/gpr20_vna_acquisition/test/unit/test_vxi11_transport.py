"""Whatever the other side does, the link answers, or fails in time with VnaConnectionError."""

from __future__ import annotations

import socket
import struct
import threading
import time

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hostile_server import (
    CLEAR,
    CREATE_LINK,
    DESTROY_LINK,
    GETPORT,
    HOST,
    LOCK,
    LONGEST_S,
    QUICK,
    READ,
    UNLOCK,
    WRITE,
    HostileServer,
    hang_up,
    on,
    read_reply,
    record,
    wait_until,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low.vxi11_transport import connect


@pytest.fixture
def server():
    one = HostileServer()
    yield one
    one.close()


def test_binary_answers_come_byte_for_byte(server):
    payload = bytes(range(256)) + b"\r\n\n"
    server.answer = lambda question: read_reply(payload)
    link = connect(HOST, QUICK, server.port)
    for _time in range(2):
        assert link.ask_raw("DATA?") == payload
    assert GETPORT not in server.calls


def test_an_answer_in_many_pieces_is_put_together(server):
    parts = [read_reply(b"ab", reason=0), read_reply(b"cd", reason=1), read_reply(b"ef")]
    server.answer = lambda question: parts.pop(0)
    assert connect(HOST, QUICK, server.port).ask_raw("X?") == b"abcdef"


def test_the_portmapper_is_asked_without_an_explicit_port(server):
    link = connect(HOST, QUICK, portmapper_port=server.port)
    assert server.calls[0] == GETPORT and link.ask_raw("X?") == b"<X?>"


def test_a_portmapper_without_the_instrument_is_a_clear_error(server):
    server.mapped_port = None
    with raises_fault(faults.WRONG_INSTRUMENT, "no VXI-11 core channel"):
        connect(HOST, QUICK, portmapper_port=server.port)


def test_nobody_at_the_port_fails_with_the_address(server):
    with socket.create_server((HOST, 0)) as free:
        port = free.getsockname()[1]
    with raises_fault(faults.NO_LINK, "127.0.0.1"):
        connect(HOST, QUICK, port)


@pytest.mark.parametrize("by_portmapper", [True, False])
def test_a_host_that_never_answers_is_given_up_in_time(by_portmapper):
    with socket.create_server((HOST, 0)) as silent:
        port = silent.getsockname()[1]
        begun = time.monotonic()
        with pytest.raises(VnaConnectionError):
            if by_portmapper:
                connect(HOST, QUICK, portmapper_port=port)
            else:
                connect(HOST, QUICK, port)
        assert time.monotonic() - begun < LONGEST_S


def test_a_host_that_takes_no_connection_is_given_up_in_time():
    # A listener whose queue is full drops further requests, as an absent host does.
    with socket.socket() as full:
        full.bind((HOST, 0))
        full.listen(0)
        fillers = [socket.socket() for _ in range(4)]
        for filler in fillers:
            filler.setblocking(False)
            filler.connect_ex(full.getsockname())
        begun = time.monotonic()
        with pytest.raises(VnaConnectionError):
            connect(HOST, QUICK, full.getsockname()[1])
        assert time.monotonic() - begun < LONGEST_S
        for filler in fillers:
            filler.close()


def test_the_time_limit_of_other_sockets_is_left_alone(server):
    connect(HOST, QUICK, server.port).close()
    assert socket.getdefaulttimeout() is None


def test_closing_destroys_the_link(server):
    link = connect(HOST, QUICK, server.port)
    link.close()
    link.close()
    assert server.calls.count(DESTROY_LINK) == 1 and server.links == 0


@pytest.mark.parametrize("procedure", [WRITE, READ])
def test_a_dropped_connection_is_our_error_and_a_new_link_works(server, procedure):
    link = connect(HOST, QUICK, server.port)
    server.spoil = on(procedure, hang_up)
    with raises_fault(faults.NO_LINK, HOST):
        link.ask_raw("X?")
    server.spoil = lambda called, proper: proper
    with raises_fault(faults.NO_LINK, HOST):
        link.ask_raw("X?")
    assert connect(HOST, QUICK, server.port).ask_raw("Y?") == b"<Y?>"


def test_a_hanging_answer_ends_in_time_and_is_never_given_to_the_next_question(server):
    link = connect(HOST, QUICK, server.port)
    release = threading.Event()

    def hang(question: bytes) -> bytes:
        release.wait(5.0)
        return read_reply(b"LATE")

    server.answer = hang
    begun = time.monotonic()
    with raises_fault(faults.NO_ANSWER, "asking 'X?'"):
        link.ask_raw("X?")
    assert time.monotonic() - begun < LONGEST_S
    server.answer = lambda question: read_reply(b"<" + question + b">")
    release.set()
    with pytest.raises(VnaConnectionError):
        link.ask_raw("Y?")
    assert connect(HOST, QUICK, server.port).ask_raw("Y?") == b"<Y?>"


def test_a_dripping_answer_does_not_stretch_the_time_limit(server):
    link = connect(HOST, QUICK, server.port)

    def drip(peer: socket.socket, data: bytes) -> None:
        for byte in data:
            peer.sendall(bytes([byte]))
            time.sleep(0.15)

    server.send = drip
    begun = time.monotonic()
    with pytest.raises(VnaConnectionError):
        link.ask_raw("X?")
    assert time.monotonic() - begun < LONGEST_S


def test_a_record_header_in_two_segments_is_not_the_end(server):
    def split(peer: socket.socket, data: bytes) -> None:
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        peer.sendall(data[:2])
        time.sleep(0.02)
        peer.sendall(data[2:])

    server.send = split
    assert connect(HOST, QUICK, server.port).ask_raw("X?") == b"<X?>"


def test_the_instruments_own_timeout_ends_the_link_properly(server):
    link = connect(HOST, QUICK, server.port)
    server.answer = lambda question: read_reply(b"", reason=0, error=15)
    with raises_fault(faults.NO_ANSWER, "IO timeout"):
        link.ask_raw("X?")
    wait_until(lambda: server.links == 0)


def test_an_endless_answer_is_stopped(server):
    link = connect(HOST, QUICK, server.port)
    server.answer = lambda question: read_reply(b"x" * 60000, reason=1)
    with raises_fault(faults.NO_LINK, "announces"):
        link.ask_raw("X?")
    assert server.calls.count(READ) < 50


def test_an_endless_empty_answer_is_stopped_in_time(server):
    link = connect(HOST, QUICK, server.port)
    server.answer = lambda question: read_reply(b"", reason=0)
    begun = time.monotonic()
    with pytest.raises(VnaConnectionError):
        link.ask_raw("X?")
    assert time.monotonic() - begun < LONGEST_S


def test_an_announced_giant_record_takes_no_memory(server):
    link = connect(HOST, QUICK, server.port)
    server.spoil = on(READ, lambda called, proper: struct.pack(">I", 0xFFFFFFFF) + b"x" * 100)
    with raises_fault(faults.NO_LINK, "announces"):
        link.ask_raw("X?")


def test_an_instrument_that_takes_nothing_at_once_is_refused(server):
    server.receive_size = 0
    with raises_fault(faults.WRONG_INSTRUMENT, 1024):
        connect(HOST, QUICK, server.port)
    wait_until(lambda: server.links == 0)


@pytest.mark.parametrize(
    "error, fault", [(3, faults.NO_LINK), (9, faults.NO_LINK), (11, faults.LOCKED)]
)
def test_a_refused_link_is_our_error(server, error, fault):
    server.spoil = on(
        CREATE_LINK, lambda called, proper: proper[:28] + struct.pack(">iiII", error, 0, 0, 0)
    )
    with raises_fault(fault, f"{error}: "):
        connect(HOST, QUICK, server.port)


def test_clearing_tolerates_an_instrument_that_cannot(server):
    server.spoil = on(CLEAR, lambda called, proper: proper[:28] + struct.pack(">i", 8))
    link = connect(HOST, QUICK, server.port)
    link.clear()
    assert link.ask_raw("X?") == b"<X?>"


def test_clearing_reports_any_other_failure(server):
    server.spoil = on(CLEAR, lambda called, proper: proper[:28] + struct.pack(">i", 17))
    with raises_fault(faults.NO_LINK, "clearing"):
        connect(HOST, QUICK, server.port).clear()


# What follows the record's header and the head of a reply; a server that lacks a procedure says so
# in the head.
@each_case(
    "answer",
    [
        lambda proper: proper[:28] + struct.pack(">i", 8),
        lambda proper: struct.pack(">I", 0x80000018) + proper[4:24] + struct.pack(">I", 3),
    ],
)
def test_an_instrument_without_a_lock_is_used_without_one(server, answer):
    server.spoil = on(LOCK, lambda called, proper: answer(proper))
    link = connect(HOST, QUICK, server.port)
    link.lock()
    assert link.ask_raw("X?") == b"<X?>"
    link.unlock()
    assert UNLOCK not in server.calls


def test_a_lock_of_another_link_is_named(server):
    server.spoil = on(LOCK, lambda called, proper: proper[:28] + struct.pack(">i", 11))
    with raises_fault(faults.LOCKED, "11: "):
        connect(HOST, QUICK, server.port).lock()


def test_a_lock_is_given_back(server):
    link = connect(HOST, QUICK, server.port)
    link.lock()
    link.unlock()
    assert server.calls[-2:] == [LOCK, UNLOCK]


def test_a_failed_link_leaves_no_open_socket(server):
    link = connect(HOST, QUICK, server.port)
    client = link._instrument.client.sock._socket
    server.spoil = on(READ, hang_up)
    with pytest.raises(VnaConnectionError):
        link.ask_raw("X?")
    assert client.fileno() == -1


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(
    st.sampled_from([GETPORT, CREATE_LINK, WRITE, READ]),
    st.one_of(
        st.binary(min_size=1, max_size=64),
        st.binary(min_size=1, max_size=64).map(record),
        st.binary(max_size=40).map(lambda tail: ("body", tail)),
    ),
)
def test_no_garbage_raises_anything_but_our_error(server, procedure, garbage):
    garbled = threading.Event()

    def spoil(called: int, proper: bytes) -> bytes:
        if called != procedure:
            return proper
        if isinstance(garbage, tuple):
            # A proper RPC header before it, so that the VXI-11 layer sees it.
            return record(proper[4:28] + garbage[1])
        garbled.set()
        return garbage

    def send(peer: socket.socket, data: bytes) -> None:
        peer.sendall(data)
        if garbled.is_set():
            # Without an end of the stream each example would last its whole time limit.
            peer.shutdown(socket.SHUT_WR)

    server.spoil, server.send = spoil, send
    try:
        link = connect(HOST, QUICK, portmapper_port=server.port)
        answer = link.ask_raw("X?")
        assert isinstance(answer, bytes)
    except VnaConnectionError:
        pass

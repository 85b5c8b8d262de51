"""Whatever the other side does, the link answers, or fails in time with VnaConnectionError."""

from __future__ import annotations

import random
import socket
import struct
import threading
import time

import pytest
import vxi11
from case_kit import each_case
from fault_kit import raises_fault
from hostile_server import (
    CLEAR,
    CREATE_LINK,
    DESTROY_LINK,
    GETPORT,
    HOST,
    IMPATIENT,
    LOCK,
    PATIENT,
    QUICK,
    READ,
    WRITE,
    HostileServer,
    body,
    hang_up,
    on,
    proper,
    read_reply,
    record,
    wait_until,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from run_seed import draws
from vxi11 import rpc

from gpr20_survey.faults import VNA_SILENT, WRONG_VNA
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low.vxi11_transport import NO_AUTHENTICATION, Packer, connect

READ_PIECE_BYTES = 1024
LIBRARY = vxi11.vxi11


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


def test_nobody_at_the_port_fails_with_the_address():
    with socket.create_server((HOST, 0)) as free:
        port = free.getsockname()[1]
    with raises_fault(VNA_SILENT, HOST):
        connect(HOST, PATIENT, port)


@each_case("by_portmapper", [False, True])
def test_a_host_that_never_answers_is_given_up_in_time(by_portmapper):
    with socket.create_server((HOST, 0)) as silent, pytest.raises(VnaConnectionError):
        port = silent.getsockname()[1]
        connect(HOST, QUICK, *((None, port) if by_portmapper else (port,)))


def test_a_host_that_takes_no_connection_is_given_up_in_time():
    # A listener whose queue is full drops further requests, as an absent host does.
    with socket.socket() as full:
        full.bind((HOST, 0))
        full.listen(0)
        fillers = [socket.socket() for _ in range(4)]
        for filler in fillers:
            filler.setblocking(False)
            filler.connect_ex(full.getsockname())
        with pytest.raises(VnaConnectionError):
            connect(HOST, QUICK, full.getsockname()[1])
        for filler in fillers:
            filler.close()


@each_case("procedure", [WRITE, READ])
def test_a_dropped_connection_is_our_error_and_a_new_link_works(server, procedure):
    link = connect(HOST, PATIENT, server.port)
    client = link._instrument.client.sock._socket
    server.spoil = on(procedure, hang_up)
    for _time in range(2):
        with raises_fault(VNA_SILENT, HOST):
            link.ask_raw("X?")
        server.spoil = proper
    assert client.fileno() == -1
    assert connect(HOST, PATIENT, server.port).ask_raw("Y?") == b"<Y?>"


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


def test_an_instrument_that_takes_nothing_at_once_is_refused(server):
    server.receive_size = 0
    with raises_fault(WRONG_VNA, 1024):
        connect(HOST, PATIENT, server.port)
    wait_until(lambda: server.links == 0)


@each_case("error, fault", [(9, VNA_SILENT), (11, faults.LOCKED)])
def test_a_refused_link_is_our_error(server, error, fault):
    server.spoil = on(CREATE_LINK, body(struct.pack(">iiII", error, 0, 0, 0)))
    with raises_fault(fault, f"{error}: "):
        connect(HOST, PATIENT, server.port)


def test_clearing_tolerates_an_instrument_that_cannot_and_reports_any_other_failure(server, link):
    server.spoil = on(CLEAR, body(struct.pack(">i", 8)))
    link.clear()
    assert link.ask_raw("X?") == b"<X?>"
    server.spoil = on(CLEAR, body(struct.pack(">i", 17)))
    with raises_fault(VNA_SILENT):
        link.clear()


# A server that lacks a procedure says so in the head of the reply.
@each_case(
    "answer",
    [
        body(struct.pack(">i", 8)),
        lambda _called, answer: record(answer[4:24] + struct.pack(">I", 3)),
    ],
)
def test_an_instrument_without_a_lock_is_used_without_one(server, answer):
    server.spoil = on(LOCK, answer)
    link = connect(HOST, PATIENT, server.port)
    link.lock()
    assert link.ask_raw("X?") == b"<X?>"


def test_a_lock_of_another_link_is_named(server, link):
    link.lock()
    assert server.calls[-1] == LOCK
    server.spoil = on(LOCK, body(struct.pack(">i", 11)))
    with raises_fault(faults.LOCKED):
        link.lock()


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
    garbled = threading.Event()

    def spoil(called: int, answer: bytes) -> bytes:
        if called != procedure:
            return answer
        if callable(garbage):
            return garbage(called, answer)
        garbled.set()
        return garbage

    def send(peer: socket.socket, data: bytes) -> None:
        peer.sendall(data)
        if garbled.is_set():
            # Without an end of the stream each example would last its whole time limit.
            peer.shutdown(socket.SHUT_WR)

    server.spoil, server.send = spoil, send
    try:
        answer = connect(HOST, QUICK, portmapper_port=server.port).ask_raw("X?")
        assert isinstance(answer, bytes)
    except VnaConnectionError:
        pass


# What python-vxi11 0.9 does wrong does not reach the driver.


def socket_of(link):
    return link._instrument.client.sock._socket


def test_a_command_that_was_taken_in_part_is_our_error(server, link):
    server.spoil = on(WRITE, body(struct.pack(">iI", 0, 1)))
    with raises_fault(VNA_SILENT):
        link.write(":INIT:IMM")


@each_case("ending", [hang_up, body(struct.pack(">iiII", 9, 0, 0, 0))])
def test_a_link_that_was_not_made_leaves_no_open_connection(server, monkeypatch, ending):
    opened = []
    create = socket.create_connection

    def note(*arguments, **options):
        opened.append(create(*arguments, **options))
        return opened[-1]

    with monkeypatch.context() as patch:
        patch.setattr(socket, "create_connection", note)
        server.spoil = on(CREATE_LINK, ending)
        with pytest.raises(VnaConnectionError):
            connect(HOST, PATIENT, server.port)
    assert [one.fileno() for one in opened] == [-1]


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


def test_a_reply_cut_in_mid_record_ends_the_link(server):
    link = connect(HOST, IMPATIENT, server.port)
    server.spoil = on(READ, lambda _called, answer: answer[:-4])
    with pytest.raises(VnaConnectionError):
        link.ask_raw("X?")
    server.spoil = proper
    with raises_fault(VNA_SILENT, HOST):
        link.ask_raw("Y?")
    wait_until(lambda: server.links == 0)


def test_the_longest_trace_in_the_smallest_pieces_is_whole(server):
    # 4001 points in ASCII of 20 characters, from an instrument that takes 1024 bytes at once.
    server.receive_size = READ_PIECE_BYTES
    whole = bytes(range(256)) * 657
    left = [whole]

    def answer(_question):
        piece, left[0] = left[0][:READ_PIECE_BYTES], left[0][READ_PIECE_BYTES:]
        return read_reply(piece, reason=0 if left[0] else 4)

    server.answer = answer
    assert connect(HOST, PATIENT, server.port).ask_raw("X?") == whole


# Calls and replies of each exchange are packed in one piece, with the bytes of the library.


def packed(packer, procedure, authentication, pack, parameters):
    packer.reset()
    head = (7, LIBRARY.DEVICE_CORE_PROG, LIBRARY.DEVICE_CORE_VERS, procedure)
    packer.pack_callheader(*head, authentication, authentication)
    getattr(packer, pack)(parameters)
    return packer.get_buf()


def test_a_call_has_the_bytes_of_the_library():
    for seed in range(draws(12)):
        chance = random.Random(seed)
        link, flags = chance.randint(-(2**31), 2**31 - 1), chance.randint(0, 255)
        limits = [chance.randint(0, 2**32 - 1) for _ in range(3)]
        data = bytes(chance.randrange(256) for _ in range(chance.randint(0, 30)))
        authentication = chance.choice([NO_AUTHENTICATION, (rpc.AUTH_NULL, b"abcd")])
        for procedure, pack, parameters in (
            (LIBRARY.DEVICE_WRITE, "pack_device_write_parms", (link, *limits[:2], flags, data)),
            (LIBRARY.DEVICE_READ, "pack_device_read_parms", (link, *limits, flags, 10)),
        ):
            call = (procedure, authentication, pack, parameters)
            assert packed(Packer(), *call) == packed(LIBRARY.Packer(), *call), f"seed {seed}"


def test_a_link_that_died_unnoticed_can_be_closed_and_made_again(server, link):
    dead = socket_of(link)
    server.spoil = on(DESTROY_LINK, hang_up)
    link.close()
    assert dead.fileno() == -1
    server.spoil = proper
    assert connect(HOST, PATIENT, server.port).ask_raw("X?") == b"<X?>"

"""What python-vxi11 0.9 does wrong does not reach the driver."""

from __future__ import annotations

import gc
import socket
import struct
import time

import pytest
import vxi11
from fault_kit import raises_fault
from hostile_server import (
    CREATE_LINK,
    DESTROY_LINK,
    HOST,
    LONGEST_S,
    QUICK,
    READ,
    WRITE,
    HangUp,
    HostileServer,
    hang_up,
    on,
    read_reply,
    wait_until,
)

from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low.vxi11_transport import connect

READ_PIECE_BYTES = 1024


@pytest.fixture
def server():
    one = HostileServer()
    yield one
    one.close()


def socket_of(link):
    return link._instrument.client.sock._socket


def test_the_library_is_the_one_whose_faults_are_known():
    assert vxi11.__version__ == "0.9"


def test_small_requests_are_sent_at_once(server):
    link = connect(HOST, QUICK, server.port)
    assert socket_of(link).getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_link_is_one_connection_and_needs_no_abort_channel(server):
    # The library would look for the abort channel at the portmapper: its port is 0 here.
    link = connect(HOST, QUICK, server.port)
    link.ask_raw("X?")
    link.clear()
    link.close()
    assert server.connections == 1


def test_nothing_is_appended_to_a_message(server):
    questions = []

    def answer(question):
        questions.append(question)
        return read_reply(b"1")

    server.answer = answer
    connect(HOST, QUICK, server.port).ask_raw("X?")
    assert questions == [b"X?"]


def test_a_command_that_was_taken_in_part_is_our_error(server):
    server.spoil = on(WRITE, lambda called, proper: proper[:28] + struct.pack(">iI", 0, 1))
    with raises_fault(faults.NO_LINK, "complete block"):
        connect(HOST, QUICK, server.port).write(":INIT:IMM")


def test_a_link_that_died_unnoticed_can_be_closed_and_made_again(server):
    link = connect(HOST, QUICK, server.port)
    dead = socket_of(link)
    server.spoil = on(DESTROY_LINK, hang_up)
    link.close()
    assert dead.fileno() == -1
    server.spoil = lambda called, proper: proper
    assert connect(HOST, QUICK, server.port).ask_raw("X?") == b"<X?>"


def test_a_link_that_is_forgotten_does_not_talk_to_the_instrument(server):
    link = connect(HOST, QUICK, server.port)
    calls = len(server.calls)
    del link
    gc.collect()
    assert len(server.calls) == calls


@pytest.mark.parametrize("ending", ["refused", "dropped"])
def test_a_link_that_was_not_made_leaves_no_open_connection(server, ending, monkeypatch):
    opened = []
    create = socket.create_connection

    def note(*arguments, **options):
        opened.append(create(*arguments, **options))
        return opened[-1]

    monkeypatch.setattr(socket, "create_connection", note)

    def refuse(_called, proper):
        if ending == "dropped":
            raise HangUp
        return proper[:28] + struct.pack(">iiII", 9, 0, 0, 0)

    server.spoil = on(CREATE_LINK, refuse)
    with pytest.raises(VnaConnectionError):
        connect(HOST, QUICK, server.port)
    assert [one.fileno() for one in opened] == [-1]


def with_xid(proper, change):
    xid = struct.unpack(">I", proper[4:8])[0]
    return proper[:4] + struct.pack(">I", xid + change) + proper[8:]


def test_a_late_reply_to_an_older_call_is_not_taken_for_the_answer(server):
    link = connect(HOST, QUICK, server.port)

    def late_first(_called, proper):
        late = read_reply(b"LATE")
        header = with_xid(proper, -1)[4:28]
        return struct.pack(">I", 0x80000000 | len(header + late)) + header + late + proper

    server.spoil = on(READ, late_first)
    assert link.ask_raw("X?") == b"<X?>"


def test_a_reply_to_a_call_that_was_never_made_is_our_error(server):
    link = connect(HOST, QUICK, server.port)
    server.spoil = on(READ, lambda called, proper: with_xid(proper, 1))
    with raises_fault(faults.NO_LINK, "wrong xid"):
        link.ask_raw("X?")


def test_a_reply_cut_in_mid_record_ends_the_link(server):
    link = connect(HOST, QUICK, server.port)
    server.spoil = on(READ, lambda called, proper: proper[:-4])
    begun = time.monotonic()
    with pytest.raises(VnaConnectionError):
        link.ask_raw("X?")
    assert time.monotonic() - begun < LONGEST_S
    server.spoil = lambda called, proper: proper
    with raises_fault(faults.NO_LINK, HOST):
        link.ask_raw("Y?")
    wait_until(lambda: server.links == 0)


def test_the_longest_trace_in_the_smallest_pieces_is_whole_and_quick(server):
    # 4001 points in ASCII of 20 characters, from an instrument that takes 1024 bytes at once.
    server.receive_size = READ_PIECE_BYTES
    whole = bytes(range(256)) * 657
    left = [whole]

    def answer(_question):
        piece, left[0] = left[0][:READ_PIECE_BYTES], left[0][READ_PIECE_BYTES:]
        return read_reply(piece, reason=0 if left[0] else 4)

    server.answer = answer
    link = connect(HOST, QUICK, server.port)
    begun = time.monotonic()
    assert link.ask_raw("X?") == whole
    # The time limit of one answer covers all its pieces.
    assert time.monotonic() - begun < LONGEST_S

"""What python-vxi11 0.9 does wrong does not reach the driver; what it packs, is packed alike."""

from __future__ import annotations

import random
import socket
import struct

import pytest
import vxi11
from case_kit import each_case
from fault_kit import raises_fault
from hostile_server import (
    CREATE_LINK,
    DESTROY_LINK,
    HOST,
    IMPATIENT,
    PATIENT,
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
from run_seed import draws
from vxi11 import rpc

from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaConnectionError
from gpr20_vna_acquisition.low import vxi11_packing
from gpr20_vna_acquisition.low.vxi11_packing import NO_AUTHENTICATION, SUCCESS, Packer, Unpacker
from gpr20_vna_acquisition.low.vxi11_transport import connect

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


def socket_of(link):
    return link._instrument.client.sock._socket


def test_a_command_that_was_taken_in_part_is_our_error(server, link):
    server.spoil = on(WRITE, body(struct.pack(">iI", 0, 1)))
    with raises_fault(faults.NO_LINK):
        link.write(":INIT:IMM")


def test_a_link_that_died_unnoticed_can_be_closed_and_made_again(server, link):
    dead = socket_of(link)
    server.spoil = on(DESTROY_LINK, hang_up)
    link.close()
    assert dead.fileno() == -1
    server.spoil = proper
    assert connect(HOST, PATIENT, server.port).ask_raw("X?") == b"<X?>"


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
    with raises_fault(faults.NO_LINK):
        link.ask_raw("X?")


def test_a_reply_cut_in_mid_record_ends_the_link(server):
    link = connect(HOST, IMPATIENT, server.port)
    server.spoil = on(READ, lambda _called, answer: answer[:-4])
    with pytest.raises(VnaConnectionError):
        link.ask_raw("X?")
    server.spoil = proper
    with raises_fault(faults.NO_LINK, HOST):
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


def test_a_reply_is_unpacked_or_refused_as_by_the_library():
    reply = struct.pack(">I", 7) + SUCCESS + b"rest"
    for unpacker in (Unpacker(reply), LIBRARY.Unpacker(reply)):
        assert unpacker.unpack_replyheader() == (7, (rpc.AUTH_NULL, b""))
        assert unpacker.get_position() == vxi11_packing.SUCCESS_HEAD_BYTES
    for size in range(vxi11_packing.SUCCESS_HEAD_BYTES):
        with pytest.raises(EOFError):
            print(size, Unpacker(reply[:size]).unpack_replyheader())
    failure = struct.pack(">6I", 7, rpc.REPLY, rpc.MSG_ACCEPTED, 0, 0, rpc.PROC_UNAVAIL)
    with pytest.raises(rpc.RPCUnpackError, match="PROC_UNAVAIL"):
        Unpacker(failure).unpack_replyheader()

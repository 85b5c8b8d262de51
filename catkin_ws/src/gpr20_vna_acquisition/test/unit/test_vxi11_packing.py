"""Calls and replies of each exchange: the bytes of python-vxi11, packed in one piece."""

import os
import random
import struct

import pytest
from vxi11 import rpc, vxi11

from gpr20_vna_acquisition.low import vxi11_packing
from gpr20_vna_acquisition.low.vxi11_packing import NO_AUTHENTICATION, SUCCESS, Packer, Unpacker

DRAWS = int(os.environ.get("GPR20_PACKING_DRAWS", "50"))


def packed(packer, procedure, authentication, pack, parameters):
    packer.reset()
    head = (7, vxi11.DEVICE_CORE_PROG, vxi11.DEVICE_CORE_VERS, procedure)
    packer.pack_callheader(*head, authentication, authentication)
    getattr(packer, pack)(parameters)
    return packer.get_buf()


def test_a_call_has_the_bytes_of_the_library():
    for seed in range(DRAWS):
        check_calls(seed)


def check_calls(seed):
    chance = random.Random(seed)
    link, flags = chance.randint(-(2**31), 2**31 - 1), chance.randint(0, 255)
    limits = [chance.randint(0, 2**32 - 1) for _ in range(3)]
    data = bytes(chance.randrange(256) for _ in range(chance.randint(0, 30)))
    authentication = chance.choice([NO_AUTHENTICATION, (rpc.AUTH_NULL, b"abcd")])
    calls = (
        (vxi11.DEVICE_WRITE, "pack_device_write_parms", (link, *limits[:2], flags, data)),
        (vxi11.DEVICE_READ, "pack_device_read_parms", (link, *limits, flags, 10)),
    )
    for procedure, pack, parameters in calls:
        ours, theirs = (
            packed(packer, procedure, authentication, pack, parameters)
            for packer in (Packer(), vxi11.Packer())
        )
        assert ours == theirs, f"seed {seed}"


def test_a_reply_of_a_success_is_unpacked_as_by_the_library():
    reply = struct.pack(">I", 7) + SUCCESS + b"rest"
    for unpacker in (Unpacker(reply), vxi11.Unpacker(reply)):
        assert unpacker.unpack_replyheader() == (7, (rpc.AUTH_NULL, b""))
        assert unpacker.get_position() == vxi11_packing.SUCCESS_HEAD_BYTES


def test_a_reply_that_is_cut_off_is_refused_as_by_the_library():
    reply = struct.pack(">I", 7) + SUCCESS
    for size in range(vxi11_packing.SUCCESS_HEAD_BYTES):
        with pytest.raises(EOFError):
            print(size, Unpacker(reply[:size]).unpack_replyheader())


def test_a_reply_of_a_failure_is_refused_as_by_the_library():
    reply = struct.pack(">6I", 7, rpc.REPLY, rpc.MSG_ACCEPTED, 0, 0, rpc.PROC_UNAVAIL)
    with pytest.raises(rpc.RPCUnpackError, match="PROC_UNAVAIL"):
        Unpacker(reply).unpack_replyheader()

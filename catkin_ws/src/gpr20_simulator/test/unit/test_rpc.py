from __future__ import annotations

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from rpc_wire import call, opaque, unpack_words, words

from gpr20_simulator.low.rpc import (
    RpcProgram,
    XdrError,
    XdrReader,
    answer_call,
    pack_int,
    pack_opaque,
    pack_uint,
)

PROGRAM, VERSION, ADD, SILENT = 400000, 3, 1, 2


class Nobody:
    def is_gone(self):
        return False


def add(arguments, _caller):
    return pack_uint((arguments.uint() + arguments.uint()) & 0xFFFFFFFF)


OFFERED = RpcProgram(PROGRAM, VERSION, {ADD: add, SILENT: lambda _a, _c: None})


def answered(message):
    return answer_call(OFFERED, message, Nobody())


@given(st.binary(max_size=50))
def test_opaque_data_survive_packing(data):
    packed = pack_opaque(data)
    assert len(packed) % 4 == 0
    reader = XdrReader(packed)
    assert reader.opaque(50) == data
    assert reader.remaining == 0


@given(st.integers(0, 2**32 - 1), st.integers(-(2**31), 2**31 - 1))
def test_integers_survive_packing(unsigned, signed):
    reader = XdrReader(pack_uint(unsigned) + pack_int(signed))
    assert (reader.uint(), reader.sint()) == (unsigned, signed)


def test_opaque_longer_than_allowed_is_refused():
    with pytest.raises(XdrError, match="at most 2"):
        XdrReader(pack_opaque(b"abc")).opaque(2)


def test_opaque_without_its_padding_is_refused():
    with pytest.raises(XdrError, match="expected"):
        XdrReader(words(3) + b"abc").opaque(10)


def test_call_is_answered_with_its_own_number():
    reply = answered(call(PROGRAM, VERSION, ADD, words(40, 2), xid=0xDEADBEEF))
    assert unpack_words(reply) == [0xDEADBEEF, 1, 0, 0, 0, 0, 42]


def test_procedure_zero_answers_on_every_program():
    assert unpack_words(answered(call(PROGRAM, VERSION, 0))) == [7, 1, 0, 0, 0, 0]


def test_credentials_of_any_flavour_are_accepted():
    unix = words(1) + opaque(b"machine and user ids")
    message = words(7, 0, 2, PROGRAM, VERSION, ADD) + unix + words(0, 0) + words(1, 2)
    assert unpack_words(answered(message))[-1] == 3


@pytest.mark.parametrize(
    ("message", "rest"),
    [
        (call(PROGRAM + 1, VERSION, ADD), [1]),
        (call(PROGRAM, VERSION + 1, ADD), [2, VERSION, VERSION]),
        (call(PROGRAM, VERSION, 99), [3]),
        (call(PROGRAM, VERSION, ADD, words(1)), [4]),
    ],
    ids=["program unavailable", "version mismatch", "procedure unavailable", "garbage arguments"],
)
def test_wrong_calls_are_told_what_is_wrong(message, rest):
    assert unpack_words(answered(message)) == [7, 1, 0, 0, 0, *rest]


def test_other_rpc_versions_are_denied():
    message = words(7, 0, 3, PROGRAM, VERSION, ADD, 0, 0, 0, 0)
    assert unpack_words(answered(message)) == [7, 1, 1, 0, 2, 2]


def test_procedure_may_leave_a_call_without_reply():
    assert answered(call(PROGRAM, VERSION, SILENT)) is None


@each_case("message", [b"", b"\0\0\0", words(7, 1, 0), words(7, 0, 2, PROGRAM)])
def test_what_is_no_call_is_refused(message):
    with pytest.raises(XdrError):
        answered(message)


@given(st.one_of(st.binary(max_size=200), st.binary(max_size=60).map(lambda d: words(7, 0, 2) + d)))
def test_no_bytes_do_anything_but_get_an_answer_or_an_xdr_error(message):
    try:
        reply = answered(message)
    except XdrError:
        return
    assert reply is None or reply[:8] == message[:4] + words(1)

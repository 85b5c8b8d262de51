"""Nothing but a complete block with the right count of finite numbers is data."""

from __future__ import annotations

import contextlib
import itertools
import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid.block_parser import (
    TransferFormat,
    parse_frequencies,
    parse_numbers,
)

REAL32, ASCII = TransferFormat.REAL32, TransferFormat.ASCII


def block(payload: bytes, width: int = 0) -> bytes:
    length = str(len(payload)).zfill(width)
    return f"#{len(length)}{length}".encode() + payload


def real32(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}f", *numbers)


def test_reads_real32_with_any_header_width_and_newline():
    numbers = [0.5, -0.25, float(np.float32(1e-7))]
    answers = [
        block(real32(*numbers), width) + ending
        for width, ending in itertools.product([1, 2, 4, 9], [b"", b"\n", b"\r\n"])
    ]
    assert [one for one in answers if parse_numbers(one, REAL32, 3).tolist() != numbers] == []


def test_keeps_every_number_of_ascii_with_and_without_trailing_comma():
    texts = [b"1,-2.5E-03,+3.e2", b" 1 , -.0025,300"]
    endings = [b"", b",", b"\n", b",\n", b",\r\n"]
    answers = [
        block(text + inside, width)
        for width, inside, text in itertools.product([1, 2, 9], endings, texts)
    ]
    # Not counted in the length.
    answers += [block(texts[0]) + after for after in endings]
    numbers = [1.0, -0.0025, 300.0]
    assert [one for one in answers if parse_numbers(one, ASCII, 3).tolist() != numbers] == []


NO_PLAIN_FINITE_NUMBERS = [
    b"1,nan", b"1,inf", b"1,-Infinity", b"1,1e999", b"1,1_0", b"1,0x10", b"1,", b",1", b"1,,",
    b"1,2,,", b"1;2", b"1,2\n3", b"1,\xd9\xa1", b"1, ", b"1,2 3", b"1,+-2", b"1,.", b"1", b"1,2,3",
]  # fmt: skip
NO_BLOCK = [
    b"", b"#", b"#0", b"#01,2", b"#x", b"1,2", b"#2", b"#21", b"#1x1,2", b"# 31,2", b"#-11,2",
    b"#13" + b"1,", b"#9", b"#13" + b"1,2" + b"9", b"#13" + b"1,2" + b"\n\n", b"#11" + b"1,2",
    b"#12" + b"1,2", b"#14" + b"1,2", b"#13" + b"1,2,3", block(real32(1)), block(real32(1, 2, 3)),
]  # fmt: skip


def test_refuses_a_broken_block_and_another_count():
    accepted = []
    for answer in [*map(block, NO_PLAIN_FINITE_NUMBERS), *NO_BLOCK]:
        for transfer in TransferFormat:
            # Eight bytes of any text are two binary numbers.
            if transfer is REAL32 and len(answer) == 11:
                continue
            with contextlib.suppress(VnaDataError):
                accepted.append((answer, transfer, parse_numbers(answer, transfer, 2)))
    assert accepted == []
    for number in (math.nan, math.inf, -math.inf):
        with pytest.raises(VnaDataError):
            parse_numbers(block(real32(1.0, number)), REAL32, 2)


@given(st.binary(max_size=60), st.integers(0, 20), st.binary(max_size=3), st.integers(0, 5))
def test_no_bytes_raise_another_error_nor_give_a_wrong_number(payload, count, after, width):
    for transfer in TransferFormat:
        for answer in (payload, block(payload, width) + after):
            try:
                numbers = parse_numbers(answer, transfer, count)
            except VnaDataError:
                continue
            assert len(numbers) == count and np.isfinite(numbers).all()
            if transfer is REAL32:
                assert real32(*numbers) in answer


def test_reads_frequencies_in_either_format():
    for answer in (block(real32(1e9, 2e9, 3e9)), block(b"1.0E+09,2.0E+09,3.0E+09,\n")):
        assert parse_frequencies(answer, 3).tolist() == [1e9, 2e9, 3e9]

"""Strict reading of the instrument's numbers and data blocks.

Block: `#`, one digit A, A digits that give the number X of bytes, X bytes of numbers
(MS20xxC programming manual, `:CALCulate:DATA?` and `:FORMat`). The instrument pads X with
zeros as it likes and may end an ASCII block with a comma and any answer with a newline;
whether X counts those is not documented, so both are taken. Nothing else is.
"""

from __future__ import annotations

import enum
import math
import re
from typing import Collection, Tuple

import numpy as np

from gpr20_vna_acquisition.errors import VnaDataError

_HEADER_START = b"#"
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_NEWLINES = (b"", b"\n", b"\r\n")
_ASCII_ENDINGS = _NEWLINES + (b",", b",\n", b",\r\n")
# IEEE 754 single precision, little-endian, whatever the machine that runs this.
_REAL32 = np.dtype("<f4")


class TransferFormat(enum.Enum):
    """How numbers travel; the value is what `:FORMat` takes and answers."""

    REAL32 = "REAL,32"
    ASCII = "ASC"


def number(answer: str) -> float:
    """Return a numeric answer.

    Raises:
        VnaDataError: It is not a finite number.
    """
    text = answer.strip(" ")
    # float() alone would take 'nan', '1_0' and digits of other scripts as well.
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value):
        raise VnaDataError(f"the instrument answers {answer[:40]!r} where a number is expected")
    return value


def whole_number(answer: str) -> int:
    """Return a numeric answer that must be whole.

    Raises:
        VnaDataError: It is anything else.
    """
    value = number(answer)
    if value != int(value):
        raise VnaDataError(f"the instrument answers {answer[:40]!r} where a whole number must be")
    return int(value)


def parse_numbers(answer: bytes, transfer: TransferFormat, count: int) -> np.ndarray:
    """Return the numbers of a block [float64].

    Args:
        answer: The whole answer of the instrument.
        transfer: Format of the numbers.
        count: How many there must be.

    Raises:
        VnaDataError: The answer is anything but a complete block of so many finite numbers.
    """
    payload, rest = _split(answer)
    if transfer is TransferFormat.REAL32:
        numbers = _real32(payload, rest, count)
    else:
        numbers = _ascii(payload, rest, count)
    finite = np.isfinite(numbers)
    if not finite.all():
        raise VnaDataError(
            f"{count - int(finite.sum())} of {count} numbers of the instrument are not finite"
        )
    return numbers


def parse_frequencies(answer: bytes, count: int) -> np.ndarray:
    """Return the frequencies [Hz] of a block in either format.

    The manual does not say whether `:FORMat` governs this answer. The length tells: text
    of a frequency with its comma is longer than four bytes.

    Raises:
        VnaDataError: The answer is anything but a complete block of so many finite numbers.
    """
    payload, _ = _split(answer)
    real32 = len(payload) == count * _REAL32.itemsize
    return parse_numbers(answer, TransferFormat.REAL32 if real32 else TransferFormat.ASCII, count)


def _split(answer: bytes) -> Tuple[bytes, bytes]:
    if answer[:1] != _HEADER_START:
        raise VnaDataError(f"a data block must begin with '#', this one does with {answer[:16]!r}")
    width = _digits(answer[1:2], "header")
    if width == 0:
        raise VnaDataError("the data block has no length in its header")
    length_text = answer[2 : 2 + width]
    if len(length_text) < width:
        raise VnaDataError(f"the data block ends within its header {answer[:16]!r}")
    start = 2 + width
    length = _digits(length_text, "length")
    payload = answer[start : start + length]
    if len(payload) < length:
        raise VnaDataError(
            f"the data block is cut: {len(payload)} of {length} announced bytes arrived"
        )
    return payload, answer[start + length :]


def _digits(text: bytes, what: str) -> int:
    # isdigit() of bytes is true for the ASCII digits alone.
    if not text.isdigit():
        raise VnaDataError(f"the {what} of the data block is {text!r}, not a number")
    return int(text)


def _real32(payload: bytes, rest: bytes, count: int) -> np.ndarray:
    _check_ending(rest, _NEWLINES)
    if len(payload) != count * _REAL32.itemsize:
        raise VnaDataError(
            f"the data block holds {len(payload)} bytes; {count} numbers of four bytes "
            f"are {count * _REAL32.itemsize}"
        )
    return np.frombuffer(payload, dtype=_REAL32).astype(np.float64)


def _ascii(payload: bytes, rest: bytes, count: int) -> np.ndarray:
    _check_ending(rest, _ASCII_ENDINGS)
    text = payload + rest
    for newline in (b"\r\n", b"\n"):
        if text.endswith(newline):
            text = text[: -len(newline)]
            break
    if text.endswith(b","):
        text = text[:-1]
    words = text.decode("latin-1").split(",") if text else []
    if len(words) != count:
        raise VnaDataError(f"the data block holds {len(words)} numbers; {count} were measured")
    return np.array([number(word) for word in words], dtype=np.float64)


def _check_ending(rest: bytes, allowed: Collection[bytes]) -> None:
    if rest not in allowed:
        raise VnaDataError(f"{len(rest)} bytes follow the data block: {rest[:16]!r}")

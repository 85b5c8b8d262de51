"""Strict parsing of the instrument's numbers and data blocks.

Block: `#`, one digit A, A digits that give the number X of bytes, X bytes of numbers
(MS20xxC programming manual, `:CALCulate:DATA?` and `:FORMat`). The instrument may pad X with
zeros, end an ASCII block with a comma, and end any answer with a newline; whether X counts
those is not documented, so both are accepted. Nothing else is.
"""

from __future__ import annotations

import enum
import math
import re
from typing import Collection, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_vna_acquisition.errors import VnaDataError

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_NEWLINES = (b"", b"\n", b"\r\n")
_ASCII_ENDINGS = _NEWLINES + (b",", b",\n", b",\r\n")
# IEEE 754 single precision, little-endian on every computer.
_REAL32 = np.dtype("<f4")


class TransferFormat(enum.Enum):
    """How numbers are transferred; the value is the argument and the answer of `:FORMat`."""

    REAL32 = "REAL,32"
    ASCII = "ASC"


def unquoted(answer: str) -> str:
    """Return a text answer without the quotation marks that some answers have."""
    return answer.strip().strip('"').strip()


def number(answer: str) -> float:
    """Return a numeric answer.

    Raises:
        VnaDataError: It is not a finite number.
    """
    text = answer.strip(" ")
    # float() alone would take 'nan', '1_0' and digits of other scripts as well.
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value):
        raise VnaDataError(
            Message("an answer of the VNA is not a number", details=repr(answer[:40]))
        )
    return value


def whole_number(answer: str) -> int:
    """Return a numeric answer that must be whole.

    Raises:
        VnaDataError: It is anything else.
    """
    value = number(answer)
    if value != int(value):
        raise VnaDataError(
            Message("an answer of the VNA is not a whole number", details=repr(answer[:40]))
        )
    return int(value)


def parse_numbers(answer: bytes, transfer: TransferFormat, count: int) -> np.ndarray:
    """Return the numbers of a block [float64].

    Raises:
        VnaDataError: The answer is anything but a complete block of so many finite numbers.
    """
    payload, rest = _split(answer)
    if transfer is TransferFormat.REAL32:
        _check_ending(rest, _NEWLINES)
        _check_count(len(payload) / _REAL32.itemsize, count)
        numbers = np.frombuffer(payload, dtype=_REAL32).astype(np.float64)
    else:
        _check_ending(rest, _ASCII_ENDINGS)
        # The ending may be counted as part of the block, or not; a number is between two commas.
        text = re.sub(r",?(\r?\n)?\Z", "", (payload + rest).decode("latin-1"))
        words = text.split(",") if text else []
        _check_count(len(words), count)
        numbers = np.array([number(word) for word in words], dtype=np.float64)
    bad = count - int(np.isfinite(numbers).sum())
    if bad:
        raise VnaDataError(
            Message("{bad} of {count} numbers from the VNA are not finite", bad=bad, count=count)
        )
    return numbers


def parse_frequencies(answer: bytes, count: int) -> np.ndarray:
    """Return the frequencies [Hz] of a block in either format, as `parse_numbers` does.

    The manual does not define whether `:FORMat` applies to this answer. The length shows it:
    a frequency as text with its comma is longer than four bytes.
    """
    real32 = len(_split(answer)[0]) == count * _REAL32.itemsize
    return parse_numbers(answer, TransferFormat.REAL32 if real32 else TransferFormat.ASCII, count)


def text_block(answer: bytes) -> str:
    """Return the text of a block.

    Raises:
        VnaDataError: The answer is anything but a complete block.
    """
    payload, rest = _split(answer)
    _check_ending(rest, _NEWLINES)
    # Latin-1 decodes every byte; some answers contain characters beyond ASCII.
    return payload.decode("latin-1")


def _split(answer: bytes) -> Tuple[bytes, bytes]:
    """Return the content of a block, and what follows it."""
    width = int(answer[1:2]) if re.match(rb"#[1-9]", answer) else 0
    start = 2 + width
    length_text = answer[2:start]
    # isdigit() of bytes is true for the ASCII digits alone.
    if not width or len(length_text) < width or not length_text.isdigit():
        raise VnaDataError(
            Message("the VNA's data have an invalid header", details=f"{answer[:16]!r}")
        )
    length = int(length_text)
    payload = answer[start : start + length]
    if len(payload) < length:
        raise VnaDataError(
            Message(
                "the VNA's data are incomplete: {received} of {announced} bytes arrived",
                received=len(payload),
                announced=length,
            )
        )
    return payload, answer[start + length :]


def _check_count(received: float, expected: int) -> None:
    if received != expected:
        raise VnaDataError(
            Message(
                "the VNA sent {received:g} numbers instead of {expected}",
                received=received,
                expected=expected,
            )
        )


def _check_ending(rest: bytes, allowed: Collection[bytes]) -> None:
    if rest not in allowed:
        raise VnaDataError(
            Message(
                "the VNA sent {extra} unexpected bytes after its data",
                extra=len(rest),
                details=repr(rest[:16]),
            )
        )

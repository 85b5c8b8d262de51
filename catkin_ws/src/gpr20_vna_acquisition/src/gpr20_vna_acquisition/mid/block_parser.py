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
from typing import Tuple

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
        raise _no_number(answer)
    return value


def whole_number(answer: str) -> int:
    """Return a numeric answer that must be whole; raises as `number` does."""
    value = number(answer)
    if value != int(value):
        raise _no_number(answer)
    return int(value)


def parse_numbers(answer: bytes, transfer: TransferFormat, count: int) -> np.ndarray:
    """Return the numbers of a block [float64].

    Raises:
        VnaDataError: The answer is anything but a complete block of so many finite numbers.
    """
    payload, rest = _split(answer)
    broken = f"{len(payload)} bytes, then {rest[:16]!r}; {count} numbers expected"
    if transfer is TransferFormat.REAL32:
        if len(payload) != count * _REAL32.itemsize or rest not in _NEWLINES:
            raise _broken(answer, broken)
        numbers = np.frombuffer(payload, dtype=_REAL32).astype(np.float64)
    else:
        # The ending may be counted as part of the block, or not; a number is between two commas.
        text = re.sub(r",?(\r?\n)?\Z", "", (payload + rest).decode("latin-1"))
        words = text.split(",") if text else []
        if len(words) != count or rest not in _ASCII_ENDINGS:
            raise _broken(answer, broken)
        numbers = np.array([number(word) for word in words])
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
    if rest not in _NEWLINES:
        raise _broken(answer, f"then {rest[:16]!r}")
    # Latin-1 decodes every byte; some answers contain characters beyond ASCII.
    return payload.decode("latin-1")


def _split(answer: bytes) -> Tuple[bytes, bytes]:
    """Return the content of a block, and what follows it."""
    width = int(answer[1:2]) if re.match(rb"#[1-9]", answer) else 0
    start = 2 + width
    length_text = answer[2:start]
    # isdigit() of bytes is true for the ASCII digits alone.
    if not width or len(length_text) < width or not length_text.isdigit():
        raise _broken(answer, "the header is invalid")
    length = int(length_text)
    payload = answer[start : start + length]
    if len(payload) < length:
        raise _broken(answer, f"{len(payload)} of {length} bytes arrived")
    return payload, answer[start + length :]


def _broken(answer: bytes, reason: str) -> VnaDataError:
    return VnaDataError(
        Message("the VNA did not send a whole block of data", details=f"{answer[:16]!r}: {reason}")
    )


def _no_number(answer: str) -> VnaDataError:
    return VnaDataError(Message("an answer of the VNA is not a number", details=repr(answer[:40])))

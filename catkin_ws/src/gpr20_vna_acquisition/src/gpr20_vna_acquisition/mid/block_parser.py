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

_HEADER_START = b"#"
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
            Message(
                "{bad} of {count} numbers from the VNA are not finite",
                bad=count - int(finite.sum()),
                count=count,
            )
        )
    return numbers


def parse_frequencies(answer: bytes, count: int) -> np.ndarray:
    """Return the frequencies [Hz] of a block in either format.

    The manual does not define whether `:FORMat` applies to this answer. The length shows it:
    a frequency as text with its comma is longer than four bytes.

    Raises:
        VnaDataError: The answer is anything but a complete block of so many finite numbers.
    """
    payload, _ = _split(answer)
    real32 = len(payload) == count * _REAL32.itemsize
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
    if answer[:1] != _HEADER_START:
        raise _invalid_header(f"begins with {answer[:16]!r} instead of '#'")
    width = _digits(answer[1:2], "width")
    if width == 0:
        raise _invalid_header("has no length")
    length_text = answer[2 : 2 + width]
    if len(length_text) < width:
        raise _invalid_header(f"is cut off: {answer[:16]!r}")
    start = 2 + width
    length = _digits(length_text, "length")
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


def _digits(text: bytes, what: str) -> int:
    # isdigit() of bytes is true for the ASCII digits alone.
    if not text.isdigit():
        raise _invalid_header(f"has the {what} {text!r}, not a number")
    return int(text)


def _invalid_header(fault: str) -> VnaDataError:
    return VnaDataError(
        Message("the VNA's data have an invalid header", details=f"the header {fault}")
    )


def _real32(payload: bytes, rest: bytes, count: int) -> np.ndarray:
    _check_ending(rest, _NEWLINES)
    if len(payload) != count * _REAL32.itemsize:
        raise VnaDataError(
            Message(
                "the VNA sent {received} bytes of data instead of {expected}",
                received=len(payload),
                expected=count * _REAL32.itemsize,
            )
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
        raise VnaDataError(
            Message(
                "the VNA sent {received} numbers instead of {expected}",
                received=len(words),
                expected=count,
            )
        )
    return np.array([number(word) for word in words], dtype=np.float64)


def _check_ending(rest: bytes, allowed: Collection[bytes]) -> None:
    if rest not in allowed:
        raise VnaDataError(
            Message(
                "the VNA sent {extra} unexpected bytes after its data",
                extra=len(rest),
                details=repr(rest[:16]),
            )
        )

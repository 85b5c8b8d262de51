"""Blocks of numbers as the instrument sends them: `#`, digits, length, payload."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np

# INT,32 has no documented scale for these data; this one is the simulator's own.
INTEGER_STEPS_PER_UNIT = 1_000_000
FREQUENCY_DIGITS = 12


class DataFormat(enum.Enum):
    """How numbers are sent; the values are what the instrument calls them."""

    ASCII = "ASC"
    INTEGER_32 = "INT,32"
    REAL_32 = "REAL,32"


@dataclass(frozen=True)
class BlockStyle:
    """Details of a block that no public document fixes.

    Attributes:
        trailing_comma: Whether ASCII numbers end with a comma; the length counts it.
        header_digits: Digits of the length, zero padded; 0: as few as it needs.
        ascii_digits: Digits after the point of an ASCII number.
    """

    trailing_comma: bool = True
    header_digits: int = 0
    ascii_digits: int = 8


def payload(values: np.ndarray, data_format: DataFormat, style: BlockStyle, digits: int) -> bytes:
    """Return real numbers as the bytes of a block without its header.

    Args:
        values: The numbers, in the order in which they are sent.
        data_format: How.
        style: Details.
        digits: Digits after the point in ASCII.
    """
    if data_format is DataFormat.REAL_32:
        return values.astype("<f4").tobytes()
    if data_format is DataFormat.INTEGER_32:
        limits = np.iinfo(np.int32)
        steps = np.nan_to_num(np.rint(values * INTEGER_STEPS_PER_UNIT))
        return np.clip(steps, limits.min, limits.max).astype("<i4").tobytes()
    numbers = values.tolist()
    text = ",".join([f"%.{digits}E"] * len(numbers)) % tuple(numbers)
    return (text + ("," if style.trailing_comma else "")).encode("ascii")


def block_header(length: int, style: BlockStyle) -> bytes:
    """Return the header of a block of so many bytes."""
    digits = str(length).zfill(style.header_digits)
    return f"#{len(digits)}{digits}".encode("ascii")


def interleaved(values: np.ndarray) -> np.ndarray:
    """Return real and imaginary parts in turns."""
    return np.column_stack((values.real, values.imag)).ravel()

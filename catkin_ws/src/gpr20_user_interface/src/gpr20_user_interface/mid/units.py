"""Numbers as operators write them."""

from __future__ import annotations

from decimal import Decimal
from typing import Tuple

HERTZ_EXPONENT_OF_MEGAHERTZ = 6


def hertz_from_megahertz(text: str) -> float:
    """Return the frequency [Hz] nearest to a decimal number of megahertz.

    A product of floats would be off by a fraction of a hertz for many inputs.

    Raises:
        ValueError: The text is not a number.
    """
    try:
        return float(Decimal(text.strip()).scaleb(HERTZ_EXPONENT_OF_MEGAHERTZ))
    except ArithmeticError:
        raise ValueError(f"'{text}' is not a number of MHz, such as 600 or 5999.5") from None


def rotations_from_text(text: str) -> Tuple[float, ...]:
    """Return the rotations [deg] of a list with commas, such as "0, 90".

    Raises:
        ValueError: A part of the list is not a number.
    """
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f"'{text}' is not a list of rotations in degrees, such as 0,90") from None

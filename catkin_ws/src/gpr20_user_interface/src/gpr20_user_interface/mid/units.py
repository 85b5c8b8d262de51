"""Numbers as operators write them."""

from __future__ import annotations

from decimal import Decimal
from typing import Iterable, Tuple

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


def megahertz_text(frequency_hz: float) -> str:
    """Return a frequency [Hz] as a decimal number of megahertz, exactly."""
    number = Decimal(repr(frequency_hz)).scaleb(-HERTZ_EXPONENT_OF_MEGAHERTZ)
    text = f"{number:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def rotations_text(rotations_deg: Iterable[float]) -> str:
    """Return rotations [deg] as a list with commas."""
    return ", ".join(f"{rotation_deg:.12g}" for rotation_deg in rotations_deg)

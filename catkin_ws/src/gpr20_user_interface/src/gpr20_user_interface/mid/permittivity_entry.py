"""A permittivity as it is entered; empty: it is estimated."""

from __future__ import annotations

from typing import Optional

from gpr20_common.message import Message

LOWEST_PERMITTIVITY, HIGHEST_PERMITTIVITY = 1.0, 100.0
ESTIMATE = 0.0
"""What is sent for an empty entry."""
PERMITTIVITY_RANGE = Message(
    "{lowest:g} to {highest:g}; empty: estimate it from the survey",
    lowest=LOWEST_PERMITTIVITY,
    highest=HIGHEST_PERMITTIVITY,
)


def check_permittivity(text: str) -> Optional[Message]:
    """Return what is allowed if a permittivity that was entered is wrong."""
    try:
        value = float(text.strip().replace(",", ".") or LOWEST_PERMITTIVITY)
    except ValueError:
        return PERMITTIVITY_RANGE
    # Written so that NaN is refused too.
    right = LOWEST_PERMITTIVITY <= value <= HIGHEST_PERMITTIVITY
    return None if right else PERMITTIVITY_RANGE


def entered_permittivity(text: str) -> float:
    """Return the value of an entry that was checked."""
    return float(text.strip().replace(",", ".") or ESTIMATE)

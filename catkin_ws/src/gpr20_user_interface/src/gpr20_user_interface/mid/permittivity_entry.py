"""A permittivity as it is entered; empty: it is not known."""

from __future__ import annotations

from typing import Optional

from gpr20_common.message import Message
from gpr20_survey.radar.soils import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY

ESTIMATE = 0.0
"""What is sent for an empty entry."""
PERMITTIVITY_RANGE = Message(
    "{lowest:g} to {highest:g}; empty: not known",
    lowest=MIN_PERMITTIVITY,
    highest=LARGEST_PERMITTIVITY,
)


def check_permittivity(text: str) -> Optional[Message]:
    """Return what is allowed if a permittivity that was entered is wrong."""
    try:
        value = float(text.strip().replace(",", ".") or MIN_PERMITTIVITY)
    except ValueError:
        return PERMITTIVITY_RANGE
    # Written so that NaN is refused too.
    right = MIN_PERMITTIVITY <= value <= LARGEST_PERMITTIVITY
    return None if right else PERMITTIVITY_RANGE


def entered_permittivity(text: str) -> float:
    """Return the value of an entry that was checked."""
    return float(text.strip().replace(",", ".") or ESTIMATE)

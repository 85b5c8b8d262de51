"""The delay of cables and antennas, as survey.json records it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.codec import bounded, record_from
from gpr20_survey import faults

SECTION, KEY = "analyzer", "antenna_delay_ns"
ANTENNA_DELAYS_NS = (-100.0, 100.0)
"""Smallest and largest delay [ns]; 100 ns are 20 m of cable."""


@dataclass(frozen=True)
class _Section:
    antenna_delay_ns: float = bounded(*ANTENNA_DELAYS_NS, 0.0)


def recorded_delay_ns(description: Mapping[str, Any]) -> float:
    """Return the delay in the description; 0 if it has none [ns].

    Raises:
        InvalidValueError: It is not a number within its range.
    """
    try:
        section = record_from(_Section, description.get(SECTION, {}), SECTION, others=True)
    except InvalidValueError as error:
        raise InvalidValueError(error.message, fault=faults.PLAN_UNREADABLE) from error
    return section.antenna_delay_ns

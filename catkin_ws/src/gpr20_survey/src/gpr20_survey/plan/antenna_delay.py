"""The delay of cables and antennas, as survey.json records it."""

from __future__ import annotations

import math
from typing import Any, Mapping

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.checks import number_between
from gpr20_survey import faults

SECTION, KEY = "analyzer", "antenna_delay_ns"
ANTENNA_DELAYS_NS = (-100.0, 100.0)
"""Smallest and largest delay [ns]; 100 ns are 20 m of cable."""


def recorded_delay_ns(description: Mapping[str, Any]) -> float:
    """Return the delay in the content of survey.json; 0 if it has none [ns].

    Raises:
        InvalidValueError: It is not a number within its range.
    """
    section = description.get(SECTION)
    value = section.get(KEY, 0.0) if isinstance(section, Mapping) else 0.0
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        value = math.nan
    try:
        return float(number_between(KEY, value, *ANTENNA_DELAYS_NS, "ns"))
    except InvalidValueError as error:
        raise InvalidValueError(error.message, fault=faults.PLAN_UNREADABLE) from error

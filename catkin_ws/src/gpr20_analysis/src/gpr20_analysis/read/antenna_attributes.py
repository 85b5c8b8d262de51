"""The delay of cables and antennas as an attribute of a survey's Dataset."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.plan.antenna_delay import recorded_delay_ns

ANTENNA_DELAY = "antenna_delay_s"
"""Attribute: delay of cables and antennas that the spectra contain [s]; 0 if there is none."""
ANTENNA_SEPARATION = "antenna_separation_m"
"""Attribute: distance between the antennas [m]; images use it unless another one is given."""
WIDEST_SEPARATION_M = 2.0
S_PER_NS = 1e-9


def antenna_attributes(description: Mapping[str, Any], notes: List[Message]) -> Dict[str, Any]:
    """Return the attribute; without it, as in surveys of earlier versions, the delay is 0.

    Args:
        description: Content of survey.json.
        notes: A remark on a delay that is not allowed is added here.
    """
    try:
        delay_ns = recorded_delay_ns(description)
    except InvalidValueError as error:
        notes.append(
            Message(
                "the delay of cables and antennas in survey.json is not valid ({reason}); 0 is "
                "used",
                reason=error.message,
            )
        )
        return {}
    return {ANTENNA_DELAY: delay_ns * S_PER_NS} if delay_ns else {}

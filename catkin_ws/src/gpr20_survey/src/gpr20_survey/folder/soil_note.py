"""The permittivity of the ground of a survey: that of its plan, or a later decision in its log."""

from __future__ import annotations

from typing import Any, Dict, Mapping, NamedTuple, Optional

from gpr20_survey.folder.log_record import Kind, log_values
from gpr20_survey.radar.soils import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY
from gpr20_survey.trace import utc_time

PLANNED = "permittivity"
"""Key of the description; only in a survey whose plan names the permittivity."""
FORMAT = "gpr20-soil/1"
KIND = Kind.DECISION
OF_PLAN, ENTERED = "of the plan", "entered later"
"""Where the permittivity of a survey is from."""


class KnownSoil(NamedTuple):
    """What a survey knows of its ground."""

    permittivity: float
    source: str


def soil_values(permittivity: Optional[float], time_us: int) -> Dict[str, Any]:
    """Return the values of the record at a moment [us since 1970]; None: not known after all."""
    return {"format": FORMAT, "permittivity": permittivity, "time": utc_time.iso_text(time_us)}


def soil_of_survey(description: Mapping[str, Any]) -> Optional[KnownSoil]:
    """Return what a survey knows of its ground: the last decision in its log, or else its plan.

    Of its records the decisions are enough. None: it is not known, or not known after all.
    """
    found, source = description.get(PLANNED), OF_PLAN
    for values in log_values(description, KIND):
        if values.get("format") == FORMAT:
            found, source = values.get("permittivity"), ENTERED
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        return None
    # Written so that NaN is refused too.
    is_ground = MIN_PERMITTIVITY <= found <= LARGEST_PERMITTIVITY
    return KnownSoil(float(found), source) if is_ground else None

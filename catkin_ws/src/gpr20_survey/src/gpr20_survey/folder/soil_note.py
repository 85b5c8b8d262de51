"""The permittivity of the ground of a survey, as people entered it: a decision in its log."""

from __future__ import annotations

from typing import Any, Dict, Iterable, Mapping, Optional

from gpr20_survey.folder.log_record import Kind
from gpr20_survey.radar.soils import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY
from gpr20_survey.trace import utc_time

PLANNED = "permittivity"
"""Key of survey.json; only in a survey whose plan names the permittivity."""
FORMAT = "gpr20-soil/1"
KIND = Kind.DECISION


def soil_values(permittivity: Optional[float], time_us: int) -> Dict[str, Any]:
    """Return the values of the record.

    Args:
        permittivity: Relative permittivity of the ground; None: it is not known after all.
        time_us: The present moment [us since 1970].
    """
    return {"format": FORMAT, "permittivity": permittivity, "time": utc_time.iso_text(time_us)}


def noted_permittivity(
    records: Iterable[Mapping[str, Any]], planned: object = None
) -> Optional[float]:
    """Return what the last record of a log says, or else the plan; None: it is not known.

    Args:
        records: Records of survey.json.
        planned: What survey.json has under PLANNED.
    """
    found = planned
    for record in records:
        values = record.get("values") or {}
        if record.get("kind") == KIND.value and values.get("format") == FORMAT:
            found = values.get("permittivity")
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        return None
    # Written so that NaN is refused too.
    return float(found) if MIN_PERMITTIVITY <= found <= LARGEST_PERMITTIVITY else None

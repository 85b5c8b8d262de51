"""Between the spacing of the stops and their number."""

from __future__ import annotations

import math
from typing import Optional

from gpr20_common.errors import InvalidValueError
from gpr20_operator.plan.parameter_form import MAX_GRID_POINTS
from gpr20_operator.words import number_from_text
from gpr20_survey.plan.survey_parameters import MIN_GRID_POINTS

# Of a spacing; a derived spacing is shown with six digits.
ROUNDING = 1.0e-5


def points_for(length_mm: float, spacing_mm: float) -> int:
    """Return the fewest points along a length that are not farther apart than a spacing.

    Args:
        length_mm: From the first to the last point [mm].
        spacing_mm: Wanted spacing [mm], above 0.
    """
    intervals = length_mm / (spacing_mm * (1.0 + ROUNDING))
    return max(MIN_GRID_POINTS, math.ceil(min(intervals, MAX_GRID_POINTS)) + 1)


def spacing_text(start: str, stop: str, points: str) -> str:
    """Return the spacing [mm] that follows from the texts of a form; empty if one is wrong."""
    length_mm, count = length_from_texts(start, stop), _number(points)
    if length_mm is None or count is None or count < 2:
        return ""
    return f"{length_mm / (count - 1):.6g}"


def length_from_texts(start: str, stop: str) -> Optional[float]:
    """Return the distance of two coordinates [mm]; None if one is no number."""
    first, last = _number(start), _number(stop)
    return None if first is None or last is None else abs(last - first)


def spacing_from_text(text: str) -> Optional[float]:
    """Return a spacing [mm]; None if the text is no number above 0."""
    value = _number(text)
    return value if value is not None and value > 0.0 else None


def _number(text: str) -> Optional[float]:
    try:
        value = number_from_text(text)
    except InvalidValueError:
        return None
    return value if math.isfinite(value) else None

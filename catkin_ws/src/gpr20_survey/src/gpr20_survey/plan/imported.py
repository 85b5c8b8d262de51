"""Surveys that were imported: what other instruments or programs measured, without a plan.

Their description has the entry `imported` in place of `parameters` and `axes`. It holds the grid of
the source; a trace's index is its place there, in the order in which the robot would visit it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.plan.survey_parameters import MAX_TRACES
from gpr20_survey.plan.survey_points import SurveyPoint, visits

IMPORTED = "imported"
"""Key of the description, and the outcome of these surveys."""
TIMES_KNOWN = "times_known"
"""Key of the entry: whether the times of the traces are those of the source."""
# Of a position; the values of a grid are those of its traces.
TOLERANCE = 1e-6


@dataclass(frozen=True)
class ImportedGrid:
    """The places of an imported survey, each axis ascending."""

    polarization_deg: Tuple[float, ...]
    y_mm: Tuple[float, ...]
    x_mm: Tuple[float, ...]

    def __post_init__(self) -> None:
        axes = (self.polarization_deg, self.y_mm, self.x_mm)
        ascend = all(one < other for axis in axes for one, other in zip(axis, axis[1:]))
        if not ascend or not 1 <= math.prod(map(len, axes)) <= MAX_TRACES:
            raise InvalidValueError(Message("the axes of the grid are empty or do not ascend"))

    def points(self) -> List[SurveyPoint]:
        """Return the places in the order of their indices."""
        return visits(self.x_mm, self.y_mm, self.polarization_deg)


def is_imported(description: Mapping[str, Any]) -> bool:
    return IMPORTED in description


def import_of(description: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the entry of an imported survey; an empty one of any other."""
    found = description.get(IMPORTED)
    return found if isinstance(found, Mapping) else {}


def imported_grid(description: Mapping[str, Any]) -> ImportedGrid:
    """Return the grid of an imported survey.

    Raises:
        InvalidValueError: The description does not hold one.
    """
    try:
        return record_from(ImportedGrid, import_of(description), IMPORTED, others=True)
    except InvalidValueError as error:
        raise InvalidValueError(
            Message("the log does not hold the grid of the imported survey", details=error),
            fault=faults.DAMAGED,
        ) from error


def measured_area(description: Mapping[str, Any]) -> Any:
    """Return the entry `parameters`, as it was read; of an imported survey what its grid gives."""
    if not is_imported(description):
        return description.get("parameters")
    try:
        grid = imported_grid(description)
    except InvalidValueError:
        return None
    area: Dict[str, Any] = {"polarizations_deg": list(grid.polarization_deg)}
    for name, axis_mm in (("x", grid.x_mm), ("y", grid.y_mm)):
        area[f"{name}_start_mm"], area[f"{name}_stop_mm"] = axis_mm[0], axis_mm[-1]
        area[f"{name}_points"] = len(axis_mm)
    return area


def import_sentence(description: Mapping[str, Any]) -> Message:
    """Return from what a survey was imported, for people."""
    found = import_of(description)
    return Message(
        "imported from {source} ({format})",
        source=printable(str(found.get("source"))),
        format=printable(str(found.get("format"))),
    )

"""Area and coverage of a stored survey, small enough for a list."""

from __future__ import annotations

import math
from typing import Any, List, Mapping, Sequence

import numpy as np

from gpr20_survey.results.survey_summary import NO_THUMBNAIL, Thumbnail

MOST_CELLS = 24
MOST_PLANNED = 1 << 24


def thumbnail_of(parameters: Any, stored: Sequence[int]) -> Thumbnail:
    """Return the thumbnail of a survey; an empty one if its parameters cannot be read.

    Args:
        parameters: Of its survey.json, as they were read.
        stored: Places in the plan of the stored traces.
    """
    if not isinstance(parameters, Mapping):
        return NO_THUMBNAIL
    ends: List[Any] = [
        parameters.get(f"{axis}_{end}_mm") for axis in "xy" for end in ("start", "stop")
    ]
    if not all(_is_number(one) for one in ends):
        return NO_THUMBNAIL
    x_start_mm, x_stop_mm, y_start_mm, y_stop_mm = ends
    rotations = parameters.get("polarizations_deg")
    counts: List[Any] = [
        parameters.get("x_points"),
        parameters.get("y_points"),
        len(rotations) if isinstance(rotations, list) else None,
    ]
    width_mm, height_mm = abs(x_stop_mm - x_start_mm), abs(y_stop_mm - y_start_mm)
    if not all(type(one) is int and 0 < one <= MOST_PLANNED for one in counts):
        return Thumbnail(width_mm, height_mm)
    x_points, y_points, turns = counts
    if x_points * y_points * turns > MOST_PLANNED:
        return Thumbnail(width_mm, height_mm)
    indices = np.asarray([one for one in stored if one < x_points * y_points * turns], np.int64)
    row, column = np.divmod(indices // turns, x_points)
    # Every second row is measured in the other direction.
    backwards = (row % 2 == 1) != (x_start_mm > x_stop_mm)
    column = np.where(backwards, x_points - 1 - column, column)
    if y_start_mm > y_stop_mm:
        row = y_points - 1 - row
    columns, rows = min(x_points, MOST_CELLS), min(y_points, MOST_CELLS)
    found = np.zeros((rows, columns), np.int64)
    np.add.at(found, (row * rows // y_points, column * columns // x_points), 1)
    planned = np.outer(_share(y_points, rows), _share(x_points, columns)) * turns
    percent = np.clip(found * 100 // planned, (found > 0).astype(np.int64), 100)
    return Thumbnail(width_mm, height_mm, columns, rows, percent.astype(np.uint8).tobytes())


def _share(points: int, cells: int) -> np.ndarray:
    """Return how many of the points belong to each cell."""
    return np.bincount(np.arange(points) * cells // points, minlength=cells)


def _is_number(value: Any) -> bool:
    return (
        isinstance(value, (int, float))
        and not isinstance(value, bool)
        and math.isfinite(value)
        and abs(value) <= 1e6
    )

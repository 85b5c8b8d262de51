"""Where a mine could hide, as areas of the map."""

from __future__ import annotations

from typing import List, Tuple

import numpy as np

from gpr20_operator.ground.geometry import Area
from gpr20_survey.results.hiding_map import MM_PER_M, HidingMap


def hidden_areas(found: HidingMap) -> List[Tuple[Area, float]]:
    """Return the cells where a target could hide, and from which share of the tried depths on.

    Args:
        found: The map.
    """
    x_mm, y_mm = MM_PER_M * found.x_m, MM_PER_M * found.y_m
    half_x_mm, half_y_mm = (MM_PER_M * size_m / 2.0 for size_m in found.cell_m)
    missed_m = found.missed_m
    return [
        (
            Area(
                float(x_mm[column]) - half_x_mm,
                float(x_mm[column]) + half_x_mm,
                float(y_mm[row]) - half_y_mm,
                float(y_mm[row]) + half_y_mm,
            ),
            float(np.mean(found.depth_m < missed_m[row, column])),
        )
        for row, column in np.argwhere(np.isfinite(missed_m))
    ]

"""The path of a wave from an antenna in air to a point in the soil, by Fermat's principle.

Of all points of the surface the wave crosses at the one with the shortest time. Nothing else is
assumed, neither Snell's law nor an angle: the analysis uses those, so the two can disagree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Union

import numpy as np

SPEED_OF_LIGHT_M_S = 299_792_458.0
# Each round compares the times at so many crossings and continues between the neighbours of the
# best: 1e-5 of the horizontal distance at the end.
CROSSINGS, ROUNDS = 40, 4


@dataclass(frozen=True)
class RefractedPath:
    """One way from the antenna to each of several points.

    Attributes:
        air_m: Length in air [m].
        soil_m: Length in soil [m].
        cos_air: Cosine of the angle to the vertical in air.
        across_air_m: Horizontal distance to where the path meets the surface [m].
    """

    air_m: np.ndarray
    soil_m: np.ndarray
    cos_air: np.ndarray
    across_air_m: np.ndarray


def refracted_path(
    height_m: Union[float, np.ndarray],
    depth_m: np.ndarray,
    distance_m: np.ndarray,
    permittivity: float,
) -> RefractedPath:
    """Find the quickest paths through a flat surface.

    Args:
        height_m: Height of the antenna above the surface of each point [m], more than 0.
        depth_m: Depth of each point below the surface [m], more than 0.
        distance_m: Horizontal distance of each point [m].
        permittivity: Relative permittivity of the soil, 1 or more.
    """
    across_m = _quickest_crossing_m(height_m, depth_m, distance_m, math.sqrt(permittivity))
    air_m = np.hypot(height_m, across_m)
    return RefractedPath(
        air_m, np.hypot(depth_m, distance_m - across_m), height_m / air_m, across_m
    )


def _quickest_crossing_m(
    height_m: Union[float, np.ndarray], depth_m: np.ndarray, distance_m: np.ndarray, index: float
) -> np.ndarray:
    """Return where the sum of the path in air and index times that in soil is smallest."""
    above, below = np.square(height_m), np.square(depth_m)
    places = np.arange(CROSSINGS)[:, np.newaxis]
    columns = np.arange(distance_m.size)
    first_m, step_m = np.zeros_like(distance_m), distance_m / (CROSSINGS - 1)
    for _ in range(ROUNDS):
        across_m = first_m + places * step_m
        times_m = np.sqrt(above + across_m**2)
        times_m += index * np.sqrt(below + (distance_m - across_m) ** 2)
        # The time has one minimum, so that it is between the neighbours of the smallest.
        best = np.clip(times_m.argmin(axis=0), 1, CROSSINGS - 2)
        middle_m, spacing_m = across_m[best, columns], step_m
        first_m, step_m = middle_m - spacing_m, 2.0 * spacing_m / (CROSSINGS - 1)
    # The vertex of the parabola through the last three.
    before, here, after = (times_m[best + one, columns] for one in (-1, 0, 1))
    bend = before - 2.0 * here + after
    offset = np.divide(before - after, 2.0 * bend, out=np.zeros_like(bend), where=bend > 0.0)
    return middle_m + spacing_m * np.clip(offset, -1.0, 1.0)

"""Delays of refracted paths, tabulated so that millions of them can be looked up."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gpr20_analysis.mid.imaging.refraction import one_way_delay_s, surface_delay_s_per_m

# Linear interpolation over the distance is off by less than step^2 / 8 times the second
# derivative of the delay: 0.5 mrad at 6 GHz and 0.1 m of height.
DISTANCE_STEP_M = 0.002
# A trace takes the nearest height and is corrected along the vertical, which is off by half a step
# times (1 - cos) of the angle at most: 0.13 mm at 60 deg.
HEIGHT_STEP_M = 0.0005
MOST_HEIGHTS = 200


@dataclass(frozen=True)
class DelayTable:
    """One-way delays by height, distance and depth.

    Attributes:
        delay_s: Delays (height, distance, depth) [s].
        lowest_m: First height [m].
        height_step_m: Distance of two heights [m].
        distance_step_m: Distance of two distances, which start at 0 [m].
        surface_s_per_m: What is added per metre that the surface is lower below the antenna than
            at the point (distance, depth), at the mean height [s/m].
    """

    delay_s: np.ndarray
    lowest_m: float
    height_step_m: float
    distance_step_m: float
    surface_s_per_m: np.ndarray


def tabulate_delays(
    height_m: np.ndarray, depth_m: np.ndarray, furthest_m: float, permittivity: float
) -> DelayTable:
    """Tabulate the delays between all of some heights, and points in the soil.

    Args:
        height_m: Heights of the antennas [m], any shape.
        depth_m: Depths of the points [m].
        furthest_m: Largest horizontal distance [m].
        permittivity: Relative permittivity of the soil.
    """
    lowest_m, range_m = float(np.min(height_m)), float(np.ptp(height_m))
    step_m = max(HEIGHT_STEP_M, range_m / MOST_HEIGHTS)
    heights = 1 + math.ceil(range_m / step_m)
    # Two beyond the furthest, so that its right neighbour is there.
    distances = 3 + math.ceil(furthest_m / DISTANCE_STEP_M)
    distance_m = (DISTANCE_STEP_M * np.arange(distances))[:, None]
    delay_s = one_way_delay_s(
        (lowest_m + step_m * np.arange(heights))[:, None, None],
        depth_m[None, None, :],
        distance_m[None, :, :],
        permittivity,
    )
    surface_s_per_m = surface_delay_s_per_m(
        float(np.mean(height_m)), depth_m[None, :], distance_m, permittivity
    )
    return DelayTable(delay_s, lowest_m, step_m, DISTANCE_STEP_M, surface_s_per_m)

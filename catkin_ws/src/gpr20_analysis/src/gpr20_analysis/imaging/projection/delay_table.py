"""A table of the delays between antennas in air and points in the soil, for back-projection."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S, Number
from gpr20_survey.radar.refraction import one_way_delay_s, tangent_in_air

# The error of linear interpolation over the distance is less than step^2 / 8 times the second
# derivative of the delay: 0.5 mrad at 6 GHz and 0.1 m of height.
DISTANCE_STEP_M = 0.002
# A trace uses the nearest height with a vertical correction; its error is at most half a step times
# (1 - cos) of the angle: 0.13 mm at 60 deg.
HEIGHT_STEP_M = 0.0005
MOST_HEIGHTS = 200


def surface_delay_s_per_m(
    height_m: Number, depth_m: Number, distance_m: Number, permittivity: float
) -> np.ndarray:
    """Return the delay added per metre that the surface is lower below the antenna [s/m].

    Lower than at the point, that is; between the two it is assumed to be a plane. By Fermat's
    principle the change of the path does not change the delay to the first order. What counts is
    how much lower the surface is where the path crosses it: that much more of the path is in air
    instead of soil.

    Args:
        height_m: Height of the antenna above the surface at the point [m], more than 0.
        depth_m: Depth of the point below the surface there [m], 0 or more.
        distance_m: Horizontal distance of the point [m], 0 or more.
        permittivity: Relative permittivity of the soil, 1 or more.
    """
    height_m, depth_m, distance_m = np.broadcast_arrays(height_m, depth_m, distance_m)
    tangent = tangent_in_air(height_m, depth_m, distance_m, permittivity)
    root = np.sqrt(permittivity + (permittivity - 1.0) * tangent**2)
    # Share of the horizontal distance beyond the crossing.
    beyond = (depth_m / root) / (height_m + depth_m / root)
    secant = np.sqrt(1.0 + tangent**2)
    # The wave number along the vertical is cos(angle) in air, sqrt(permittivity - sin^2) in soil.
    in_soil = np.sqrt(permittivity - (tangent / secant) ** 2)
    return beyond * (1.0 / secant - in_soil) / SPEED_OF_LIGHT_M_S


@dataclass(frozen=True)
class DelayTable:
    """One-way delays by height, distance and depth.

    Attributes:
        delay_s: Delays (height, distance, depth), float32 [s].
        lowest_m: First height [m].
        height_step_m: Step of the heights [m].
        distance_step_m: Step of the distances, which start at 0 [m].
        surface_s_per_m: Delay added per metre that the surface is lower below the antenna than at
            the point (distance, depth), at the mean height [s/m].
    """

    delay_s: np.ndarray
    lowest_m: float
    height_step_m: float
    distance_step_m: float
    surface_s_per_m: np.ndarray


def tabulate_delays(
    height_m: np.ndarray, depth_m: np.ndarray, furthest_m: float, permittivity: float
) -> DelayTable:
    """Tabulate the delays between antennas at some heights and points in the soil.

    Args:
        height_m: Heights of the antennas [m], any shape.
        depth_m: Depths of the points [m].
        furthest_m: Largest horizontal distance [m].
        permittivity: Relative permittivity of the soil.
    """
    lowest_m, range_m = float(np.min(height_m)), float(np.ptp(height_m))
    step_m = max(HEIGHT_STEP_M, range_m / MOST_HEIGHTS)
    heights = 1 + math.ceil(range_m / step_m)
    # Two beyond the furthest, so that its right neighbour exists.
    distances = 3 + math.ceil(furthest_m / DISTANCE_STEP_M)
    distance_m = (DISTANCE_STEP_M * np.arange(distances))[:, None]
    # Height by height, because the iterations need several times the memory of their result.
    delay_s = np.empty((heights, distances, len(depth_m)), dtype=np.float32)
    for one, own in enumerate(delay_s):
        own[:] = one_way_delay_s(
            lowest_m + step_m * one, depth_m[None, :], distance_m, permittivity
        )
    surface_s_per_m = surface_delay_s_per_m(
        float(np.mean(height_m)), depth_m[None, :], distance_m, permittivity
    )
    return DelayTable(delay_s, lowest_m, step_m, DISTANCE_STEP_M, surface_s_per_m)

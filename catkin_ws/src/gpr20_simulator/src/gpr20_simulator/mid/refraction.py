"""The path of a wave from an antenna in air to a point in the soil, by Snell's law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Union

import numpy as np

SPEED_OF_LIGHT_M_S = 299_792_458.0
MOST_ITERATIONS = 60
# Of the horizontal distance; far below what any phase of interest resolves.
RELATIVE_TOLERANCE = 1e-13


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
    """Find the paths that Snell's law allows through a flat surface.

    Args:
        height_m: Height of the antenna above the surface of each point [m], more than 0.
        depth_m: Depth of each point below the surface [m], more than 0.
        distance_m: Horizontal distance of each point [m].
        permittivity: Relative permittivity of the soil, 1 or more.
    """
    tan_air = np.zeros_like(distance_m)
    for _ in range(MOST_ITERATIONS):
        # With t the tangent in air, sin_soil = sin_air / sqrt(er) makes the tangent in soil
        # t / sqrt(er + (er - 1) t^2). The distance reached grows with t and is concave, so
        # Newton's steps from t = 0 never overshoot.
        under_root = permittivity + (permittivity - 1.0) * tan_air**2
        missing_m = distance_m - height_m * tan_air - depth_m * tan_air / np.sqrt(under_root)
        if np.all(np.abs(missing_m) <= RELATIVE_TOLERANCE * distance_m):
            break
        tan_air = tan_air + missing_m / (height_m + depth_m * permittivity * under_root**-1.5)
    cos_air = 1.0 / np.sqrt(1.0 + tan_air**2)
    sin_soil_squared = (1.0 - cos_air**2) / permittivity
    return RefractedPath(
        height_m / cos_air,
        depth_m / np.sqrt(1.0 - sin_soil_squared),
        cos_air,
        height_m * tan_air,
    )

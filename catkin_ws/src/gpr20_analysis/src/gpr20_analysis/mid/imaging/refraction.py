"""Delays between an antenna in air and a point in the soil, by Snell's law at a flat surface."""

from __future__ import annotations

from typing import Union

import numpy as np

SPEED_OF_LIGHT_M_S = 299_792_458.0
MOST_ITERATIONS = 60
# Of the horizontal distance: 1e-12 m of 1 m, far below any wavelength.
RELATIVE_TOLERANCE = 1e-12

Floats = Union[float, np.ndarray]


def one_way_delay_s(
    height_m: Floats, depth_m: Floats, distance_m: Floats, permittivity: float
) -> np.ndarray:
    """Return the delay of the refracted path, once through it [s].

    By Fermat's principle an error of the angle enters the delay squared only.

    Args:
        height_m: Height of the antenna above the surface [m], more than 0.
        depth_m: Depth of the point below the surface [m], 0 or more.
        distance_m: Horizontal distance of the point [m], 0 or more.
        permittivity: Relative permittivity of the soil, 1 or more.
    """
    height_m, depth_m, distance_m = np.broadcast_arrays(height_m, depth_m, distance_m)
    tangent = _tangent_in_air(height_m, depth_m, distance_m, permittivity)
    secant = np.sqrt(1.0 + tangent**2)
    sine_in_soil = tangent / secant / np.sqrt(permittivity)
    air_m = height_m * secant
    soil_m = depth_m / np.sqrt(1.0 - sine_in_soil**2)
    return (air_m + np.sqrt(permittivity) * soil_m) / SPEED_OF_LIGHT_M_S


def surface_delay_s_per_m(
    height_m: Floats, depth_m: Floats, distance_m: Floats, permittivity: float
) -> np.ndarray:
    """Return what is added per metre that the surface is lower below the antenna [s/m].

    Lower than at the point, that is; between the two it is taken as a plane. By Fermat's
    principle the path moves along with it without a change of the delay to the first order, so
    what counts is how much lower the surface lies where the path crosses it: so much more of the
    way is in air, less in soil.

    Args:
        height_m: Height of the antenna above the surface at the point [m], more than 0.
        depth_m: Depth of the point below the surface there [m], 0 or more.
        distance_m: Horizontal distance of the point [m], 0 or more.
        permittivity: Relative permittivity of the soil, 1 or more.
    """
    height_m, depth_m, distance_m = np.broadcast_arrays(height_m, depth_m, distance_m)
    tangent = _tangent_in_air(height_m, depth_m, distance_m, permittivity)
    root = np.sqrt(permittivity + (permittivity - 1.0) * tangent**2)
    # Of the horizontal distance, what lies beyond the crossing.
    beyond = (depth_m / root) / (height_m + depth_m / root)
    secant = np.sqrt(1.0 + tangent**2)
    # The wave number along the vertical is cos(angle) in air, sqrt(permittivity - sin^2) in soil.
    in_soil = np.sqrt(permittivity - (tangent / secant) ** 2)
    return beyond * (1.0 / secant - in_soil) / SPEED_OF_LIGHT_M_S


def _tangent_in_air(
    height_m: np.ndarray, depth_m: np.ndarray, distance_m: np.ndarray, permittivity: float
) -> np.ndarray:
    # The distance that a ray reaches grows with the tangent t in air and is concave in it, so
    # Newton's iteration from t = 0 approaches the root from below and cannot overshoot.
    tangent = np.zeros(np.shape(distance_m))
    for _ in range(MOST_ITERATIONS):
        root = np.sqrt(permittivity + (permittivity - 1.0) * tangent**2)
        missing_m = distance_m - tangent * (height_m + depth_m / root)
        if np.all(np.abs(missing_m) <= RELATIVE_TOLERANCE * distance_m):
            break
        tangent += missing_m / (height_m + depth_m * permittivity / root**3)
    return tangent

"""Delays between an antenna in air and a point in the soil, by Snell's law at a flat surface.

The simulator, which must agree with this, finds its paths by another method.
"""

from __future__ import annotations

import numpy as np

from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S, Number

MOST_ITERATIONS = 60
# Of the horizontal distance: 1e-12 m of 1 m, far below any wavelength.
RELATIVE_TOLERANCE = 1e-12


def one_way_delay_s(
    height_m: Number, depth_m: Number, distance_m: Number, permittivity: float
) -> np.ndarray:
    """Return the one-way delay of the refracted path [s].

    By Fermat's principle an error of the angle affects the delay only to the second order.
    The height above the surface must be more than 0, depth and horizontal distance 0 or more.
    """
    height_m, depth_m, distance_m = np.broadcast_arrays(height_m, depth_m, distance_m)
    tangent = tangent_in_air(height_m, depth_m, distance_m, permittivity)
    secant = np.sqrt(1.0 + tangent**2)
    sine_in_soil = tangent / secant / np.sqrt(permittivity)
    air_m = height_m * secant
    soil_m = depth_m / np.sqrt(1.0 - sine_in_soil**2)
    return (air_m + np.sqrt(permittivity) * soil_m) / SPEED_OF_LIGHT_M_S


def tangent_in_air(
    height_m: np.ndarray, depth_m: np.ndarray, distance_m: np.ndarray, permittivity: Number
) -> np.ndarray:
    """Return the tangent of the angle to the vertical in air; the arguments broadcast."""
    # The distance that a ray reaches grows with the tangent t in air and is concave in it, so
    # Newton's iteration from t = 0 approaches the root from below and cannot overshoot.
    tangent = np.zeros(np.broadcast(height_m, depth_m, distance_m, permittivity).shape)
    for _ in range(MOST_ITERATIONS):
        root = np.sqrt(permittivity + (permittivity - 1.0) * tangent**2)
        missing_m = distance_m - tangent * (height_m + depth_m / root)
        if np.all(np.abs(missing_m) <= RELATIVE_TOLERANCE * distance_m):
            break
        tangent += missing_m / (height_m + depth_m * permittivity / root**3)
    return tangent

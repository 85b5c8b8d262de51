"""Delay and depth: how far a wave comes in air and in ground, straight down and refracted.

Refracted paths follow Snell's law at a flat surface. The simulator, which must agree with this,
finds its paths by another method.
"""

from __future__ import annotations

import math
from typing import Any, TypeVar, Union

import numpy as np

SPEED_OF_LIGHT_M_S = 299_792_458.0

Number = Union[float, np.ndarray]
# A number, an array of numpy or one of xarray.
Values = TypeVar("Values")


def two_way_delay_s(path_m: Values) -> Values:
    """Return the delay of a wave that goes so far in air, and returns [s]."""
    metres: Any = path_m
    return 2.0 * metres / SPEED_OF_LIGHT_M_S


def one_way_path_m(delay_s: Values, permittivity: float = 1.0) -> Values:
    """Return how far away an echo of a delay comes from in air, or in ground [m].

    Of 1 / frequency step it is the unambiguous range, of 1 / bandwidth the resolution.
    """
    seconds: Any = delay_s
    return seconds * SPEED_OF_LIGHT_M_S / 2.0 / math.sqrt(permittivity)


def delay_of_depth(depth_m: Number, height_m: Number, permittivity: float) -> Number:
    """Return the two-way delay [s] of an echo straight below the antennas.

    Above the surface, where the depth is negative, the wave runs in air.
    """
    slowness = np.where(np.asarray(depth_m) < 0.0, 1.0, math.sqrt(permittivity))
    return two_way_delay_s(height_m + depth_m * slowness)


def depth_of_delay_m(delay_s: float, height_m: float, permittivity: float) -> float:
    """Return the depth [m] of an echo straight below the antennas; 0 if it is above the surface."""
    return max(0.0, one_way_path_m(delay_s - two_way_delay_s(height_m), permittivity))


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

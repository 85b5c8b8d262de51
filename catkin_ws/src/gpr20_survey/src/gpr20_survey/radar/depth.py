"""Delay and depth: how far a wave comes in air and in ground."""

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

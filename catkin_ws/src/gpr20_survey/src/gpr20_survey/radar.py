"""The physics of the radar: soils, delay and depth, and from a sweep to echoes over delay.

Refracted paths follow Snell's law at a flat surface. The simulator, which must agree with this,
finds its paths by another method.

Convention: S21 ~ exp(-2j pi f tau), so that the sum over exp(2j pi f t) shows an echo at its delay
tau. The band is weighted with a window whose weights sum to 1: an echo of level 1 has a peak of 1.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Any, Callable, Dict, Optional, TypeVar, Union

import numpy as np

from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between

# Air, and water at 20 °C: no soil lies outside of these.
MIN_PERMITTIVITY, MAX_PERMITTIVITY = 1.0, 81.0
# What images accept: some more, since water has 88 near its freezing point.
LARGEST_PERMITTIVITY = 100.0
SPEED_OF_LIGHT_M_S = 299_792_458.0

Number = Union[float, np.ndarray]
# A number, an array of numpy or one of xarray.
Values = TypeVar("Values")
# Two samples per reciprocal of the bandwidth: the Hann window's main lobe, four of these wide,
# gets eight samples, which straight lines join without visible corners.
SAMPLES_PER_RESOLUTION = 2
# 0.5 m of ground of permittivity 9 below antennas 0.5 m high.
MAX_DELAY_S = 15e-9
SMALLEST_LEVEL = 1e-9  # [linear], -180 dB: below any instrument's floor


@dataclass(frozen=True)
class Soil:
    """A kind of ground, with its relative permittivity and the range that is usual."""

    name: Message
    permittivity: float
    lowest: float
    highest: float


class Soils(enum.Enum):
    """The soils to choose from, in the order of their permittivity but for clay, which is last.

    The values lie within the ranges at 100 MHz of Davis and Annan, "Ground-penetrating radar for
    high-resolution mapping of soil and rock stratigraphy", Geophysical Prospecting 37 (1989), table
    1: dry sand 3 to 5, saturated sand 20 to 30, clay 5 to 40. Between dry and saturated the
    equation of Topp, Davis and Annan, "Electromagnetic determination of soil water content", Water
    Resources Research 16 (1980), gives 5 for 9 %, 8 for 16 % and 12 for 23 % water by volume.
    """

    DRY_SAND = Soil(Message("Dry sand"), 4.0, 3.0, 5.0)
    MOIST_SAND = Soil(Message("Moist sand"), 8.0, 5.0, 12.0)
    WET_SAND = Soil(Message("Wet sand"), 20.0, 12.0, 30.0)
    CLAY = Soil(Message("Clay"), 15.0, 5.0, 40.0)


ANY_SOIL = Soil(Message("Any soil"), 5.0, 2.0, 16.0)
"""What is assumed if nothing is known: the soils that surveys for mines have met."""


def soil_of(permittivity: float) -> Optional[Soils]:
    """Return the soil that has exactly this permittivity; None if it is the operator's own."""
    return next((one for one in Soils if one.value.permittivity == permittivity), None)


def requested_permittivity(value: float) -> Optional[float]:
    """Return the permittivity of a request; None: it is 0, not known.

    Raises:
        InvalidValueError: It is that of no ground.
    """
    name = "permittivity (0: not known)"
    return number_between(name, value, MIN_PERMITTIVITY, LARGEST_PERMITTIVITY) if value else None


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


class Window(enum.Enum):
    """Weights over the band: lower sidelobes mean a wider main lobe."""

    NONE = "none"
    HANN = "hann"
    HAMMING = "hamming"
    BLACKMAN = "blackman"

    def weights(self, count: int) -> np.ndarray:
        """Return symmetric weights with a maximum of about 1."""
        # A symmetric Hann window is 0 at both ends, which would discard two frequencies.
        return WEIGHTS[self](count + 2)[1:-1]

    def shares(self, count: int) -> np.ndarray:
        weights = self.weights(count)
        return weights / weights.sum()


WEIGHTS: Dict[Window, Callable[[int], np.ndarray]] = {
    Window.NONE: np.ones,
    Window.HANN: np.hanning,
    Window.HAMMING: np.hamming,
    Window.BLACKMAN: np.blackman,
}


def phase_advance(frequency_hz: np.ndarray, delays_s: np.ndarray) -> np.ndarray:
    """Return the factors that take delays out of spectra (..., frequency): exp(2j pi f t)."""
    turns: np.ndarray = np.asarray(delays_s)[..., np.newaxis] * frequency_hz
    return np.exp(2j * np.pi * turns)


def delay_kernel(
    frequency_hz: np.ndarray, delays_s: np.ndarray, window: Window = Window.HANN
) -> np.ndarray:
    """Return the matrix (frequency, delay) that turns spectra into A-scans: spectra @ kernel.

    Frequencies need not be evenly spaced, nor delays.
    """
    return phase_advance(frequency_hz, delays_s).T * window.shares(len(frequency_hz))[:, np.newaxis]


class FrequencyToDelay:
    """Turns sweeps of one set of frequencies into echoes over delay, in single precision.

    The carrier (centre frequency) is taken out, which changes no magnitude, so that the echoes
    vary slowly and can be interpolated.

    The frequencies ascend and are at least two; the delays begin at 0.
    """

    def __init__(self, frequency_hz: np.ndarray, step_s: float, samples: int) -> None:
        self.step_s, self.samples = step_s, samples
        self.centre_hz = float(frequency_hz[0] + frequency_hz[-1]) / 2.0
        self._frequency_hz = frequency_hz
        kernel = delay_kernel(frequency_hz - self.centre_hz, self.delays_s)
        self._kernel = kernel.astype(np.complex64)

    @classmethod
    def resolved(cls, frequency_hz: np.ndarray, max_samples: int) -> FrequencyToDelay:
        """Return a transform to as many delays as the bandwidth resolves, until 15 ns."""
        bandwidth_hz = float(frequency_hz[-1] - frequency_hz[0])
        step_s = 1.0 / (SAMPLES_PER_RESOLUTION * bandwidth_hz)
        span_s = min(MAX_DELAY_S, unambiguous_s(frequency_hz))
        return cls(frequency_hz, step_s, max(2, min(max_samples, math.ceil(span_s / step_s))))

    @property
    def delays_s(self) -> np.ndarray:
        """Two-way delay of each sample [s], from 0."""
        return np.arange(self.samples) * self.step_s

    def fits(self, frequency_hz: np.ndarray) -> bool:
        """Return whether a sweep has the frequencies of this transform."""
        # Nearly always they are equal, which is found out much faster.
        return np.array_equal(frequency_hz, self._frequency_hz) or (
            len(frequency_hz) == len(self._frequency_hz)
            and bool(np.allclose(frequency_hz, self._frequency_hz, rtol=1e-9, atol=0.0))
        )

    def transform(self, s21: np.ndarray) -> np.ndarray:
        """Return the echoes of sweeps (..., frequency) as complex64 (..., samples)."""
        return s21.astype(np.complex64) @ self._kernel

    def carrier(self, delays_s: np.ndarray) -> np.ndarray:
        """Return the carrier at delays; echoes times the carrier have the phase of the wave."""
        turns = np.asarray(self.centre_hz * delays_s)
        return np.exp(2j * np.pi * (turns - np.floor(turns))).astype(np.complex64)


def unambiguous_s(frequency_hz: np.ndarray) -> float:
    """Return the delay after which A-scans of evenly spaced frequencies repeat [s]."""
    return (len(frequency_hz) - 1) / float(frequency_hz[-1] - frequency_hz[0])


def decibels(level: Number, floor: float = SMALLEST_LEVEL) -> np.ndarray:
    """Return a linear amplitude in dB, not less than that of a floor; NaN stays NaN."""
    return 20.0 * np.log10(np.maximum(level, floor))

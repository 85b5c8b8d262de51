"""From a sweep to echoes over delay and depth; plain numpy, for pictures only.

Convention: S21 ~ exp(-2j pi f tau), so that the inverse transform shows an echo at its delay tau.
"""

from __future__ import annotations

import math
from typing import Union

import numpy as np

SPEED_OF_LIGHT_M_S = 299_792_458.0
# Two samples per reciprocal of the bandwidth: the Hann window's main lobe, four of these wide,
# gets eight samples, which straight lines join without visible corners.
SAMPLES_PER_RESOLUTION = 2
# 0.5 m of ground of permittivity 9 below antennas 0.5 m high.
MAX_DELAY_S = 15e-9
SMALLEST_LEVEL = 1e-9  # [linear], -180 dB: below any instrument's floor
# Delays at which only noise is expected, for the noise floor. They begin at this part of the
# unambiguous delay and end before its end, where sidelobes of delay 0 are wrapped to. Their
# distance is that of independent samples below a Hann window, in reciprocals of the bandwidth.
LATE_PART = 0.5
LATE_MARGIN, LATE_STEP = 10.0, 2.0
MAX_LATE_SAMPLES, MIN_LATE_SAMPLES = 48, 4

Number = Union[float, np.ndarray]


class FrequencyToDelay:
    """Turns sweeps of one set of frequencies into echoes over delay.

    The transform is made at the true, one-sided frequencies: a sum over exp(2j pi f t) weighted
    with a Hann window and normalized so that a single echo of level 1 has a peak of 1. The
    carrier (centre frequency) is taken out, which changes no magnitude, so that the result varies
    slowly and can be interpolated. Frequencies need not be evenly spaced.

    Args:
        frequency_hz: Ascending frequencies [Hz], at least two.
        max_samples: Largest number of delays.
    """

    def __init__(self, frequency_hz: np.ndarray, max_samples: int) -> None:
        bandwidth_hz = float(frequency_hz[-1] - frequency_hz[0])
        self.step_s = 1.0 / (SAMPLES_PER_RESOLUTION * bandwidth_hz)
        unambiguous_s = (len(frequency_hz) - 1) / bandwidth_hz
        span_s = min(MAX_DELAY_S, unambiguous_s)
        self.samples = max(2, min(max_samples, math.ceil(span_s / self.step_s)))
        self._frequency_hz = frequency_hz
        centre_hz = (frequency_hz[0] + frequency_hz[-1]) / 2.0
        # Without its zero ends, so that even two frequencies have a weight.
        window = np.hanning(len(frequency_hz) + 2)[1:-1]
        self._weighted = (window / window.sum())[:, np.newaxis]
        self._centre_hz = float(centre_hz)
        self._kernel = self._kernel_at(self.delays_s)
        self._late_kernel = self._kernel_at(_late_delays_s(bandwidth_hz, unambiguous_s))

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
        """Return the echoes of a sweep (complex64, shape `samples`)."""
        return s21.astype(np.complex64) @ self._kernel

    def late(self, s21: np.ndarray) -> np.ndarray:
        """Return the samples of a sweep at delays too late for echoes of the ground."""
        return s21.astype(np.complex64) @ self._late_kernel

    def carrier(self, delays_s: np.ndarray) -> np.ndarray:
        """Return the carrier at delays; echoes times the carrier have the phase of the wave."""
        turns = np.asarray(self._centre_hz * delays_s)
        return np.exp(2j * np.pi * (turns - np.floor(turns))).astype(np.complex64)

    @property
    def centre_hz(self) -> float:
        """Centre frequency [Hz]."""
        return self._centre_hz

    def _kernel_at(self, delays_s: np.ndarray) -> np.ndarray:
        turns = np.outer(self._frequency_hz - self._centre_hz, delays_s)
        return (np.exp(2j * np.pi * turns) * self._weighted).astype(np.complex64)


def delay_of_depth(depth_m: Number, height_m: Number, permittivity: float) -> Number:
    """Return the two-way delay [s] of an echo straight below the antennas.

    Args:
        depth_m: Depth below the surface [m]; above it, where it is negative, the wave runs in air.
        height_m: Height of the antennas above the surface [m].
        permittivity: Relative permittivity of the ground.
    """
    slowness = np.where(np.asarray(depth_m) < 0.0, 1.0, math.sqrt(permittivity))
    return 2.0 / SPEED_OF_LIGHT_M_S * (height_m + depth_m * slowness)


def deepest_m(max_delay_s: float, height_m: float, permittivity: float) -> float:
    """Return the depth [m] of the last delay; 0 if it lies above the surface."""
    in_air_s = 2.0 * height_m / SPEED_OF_LIGHT_M_S
    return max(0.0, (max_delay_s - in_air_s) * SPEED_OF_LIGHT_M_S / 2.0 / math.sqrt(permittivity))


def echoes_at(
    echoes: np.ndarray, rows: np.ndarray, step_s: float, delays_s: np.ndarray
) -> np.ndarray:
    """Return echoes between the samples by linear interpolation; NaN outside of them.

    Args:
        echoes: Complex samples, shape (n, samples).
        rows: Which of them, shape (m,).
        step_s: Delay between two samples [s].
        delays_s: Delays of the result, shape (m, k) [s].
    """
    place = delays_s / step_s
    last = echoes.shape[1] - 1
    below = np.clip(np.floor(place), 0, last - 1).astype(np.intp)
    part = (place - below).astype(np.float32)
    of_row = rows[:, np.newaxis]
    values = echoes[of_row, below] * (1.0 - part) + echoes[of_row, below + 1] * part
    values[~((place >= 0.0) & (place <= last))] = np.nan
    return values


def _late_delays_s(bandwidth_hz: float, unambiguous_s: float) -> np.ndarray:
    first_s = LATE_PART * unambiguous_s
    last_s = unambiguous_s - LATE_MARGIN / bandwidth_hz
    count = int((last_s - first_s) * bandwidth_hz / LATE_STEP)
    if count < MIN_LATE_SAMPLES:
        # Few frequencies: echoes may arrive here, so that the noise is rather overestimated.
        return np.linspace(first_s, unambiguous_s, MIN_LATE_SAMPLES, endpoint=False)
    return np.linspace(first_s, last_s, min(count, MAX_LATE_SAMPLES))


def decibels(level: np.ndarray) -> np.ndarray:
    """Return a linear amplitude in dB; NaN stays NaN."""
    return 20.0 * np.log10(np.maximum(level, SMALLEST_LEVEL))

"""From a sweep to echoes over delay.

Convention: S21 ~ exp(-2j pi f tau), so that the sum over exp(2j pi f t) shows an echo at its delay
tau. The band is weighted with a window whose weights sum to 1: an echo of level 1 has a peak of 1.
"""

from __future__ import annotations

import enum
import math
from typing import Callable, Dict

import numpy as np

from gpr20_survey.radar.depth import Number

# Two samples per reciprocal of the bandwidth: the Hann window's main lobe, four of these wide,
# gets eight samples, which straight lines join without visible corners.
SAMPLES_PER_RESOLUTION = 2
# 0.5 m of ground of permittivity 9 below antennas 0.5 m high.
MAX_DELAY_S = 15e-9
SMALLEST_LEVEL = 1e-9  # [linear], -180 dB: below any instrument's floor


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

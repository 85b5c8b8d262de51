"""The noise of a survey, and the one scale of levels that is anchored at it.

Levels are in dB above the noise floor, which is measured where no echo arrives. The darkest shade
is just below the level that noise alone does not exceed, the brightest one at the strongest echoes
of the whole survey: both are the same at each depth and on each line. Noise alone reaches less
than a tenth of the scale.

Complex noise has magnitudes of a Rayleigh distribution: they exceed r times their root mean square
with the probability exp(-r^2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gpr20_survey.radar.frequency_to_delay import (
    SMALLEST_LEVEL,
    decibels,
    delay_kernel,
    unambiguous_s,
)

# Delays at which only noise is expected. They begin at this part of the unambiguous delay and end
# before its end, where sidelobes of delay 0 are wrapped to. Their distance is that of independent
# samples below a Hann window, in reciprocals of the bandwidth.
LATE_PART = 0.5
LATE_MARGIN, LATE_STEP = 10.0, 2.0
MAX_LATE_SAMPLES, MIN_LATE_SAMPLES = 48, 4
# The lower quartile: some late delays may hold echoes of walls and trees, which only add power.
QUANTILE = 0.25
QUANTILE_OF_POWER = -math.log(1.0 - QUANTILE)
# Probability that noise alone exceeds the threshold anywhere in a whole survey.
FALSE_ALARM = 0.01
# The noise floor is an estimate: how far it may be off, with the hysteresis [dB].
ESTIMATE_MARGIN_DB = 0.8
# The darkest shade is so much below the highest level of noise, so that what comes close to it is
# not lost, and the brightest one at least so much above it [dB].
BELOW_THRESHOLD_DB = 2.0
MIN_SPAN_DB = 26.0
# The brightest level is a multiple of this, so that it changes rarely [dB].
TOP_STEP_DB, TICK_STEP_DB = 5.0, 10.0
# Smaller changes of the noise floor are not followed [dB].
HYSTERESIS_DB = 0.5


def late_delays_s(frequency_hz: np.ndarray) -> np.ndarray:
    """Return delays at which only noise is expected [s]."""
    bandwidth_hz = float(frequency_hz[-1] - frequency_hz[0])
    end_s = unambiguous_s(frequency_hz)
    first_s, last_s = LATE_PART * end_s, end_s - LATE_MARGIN / bandwidth_hz
    count = int((last_s - first_s) * bandwidth_hz / LATE_STEP)
    if count < MIN_LATE_SAMPLES:
        # Few frequencies: echoes may arrive here, so that the noise is rather overestimated.
        return np.linspace(first_s, end_s, MIN_LATE_SAMPLES, endpoint=False)
    return np.linspace(first_s, last_s, min(count, MAX_LATE_SAMPLES))


def late_kernel(frequency_hz: np.ndarray) -> np.ndarray:
    """Return what turns sweeps into samples at late delays: complex64 (frequency, delay)."""
    return delay_kernel(frequency_hz, late_delays_s(frequency_hz)).astype(np.complex64)


def noise_of_traces(late: np.ndarray) -> np.ndarray:
    """Return the root mean square of the noise of each trace.

    Args:
        late: Complex samples at delays where no echo is expected (..., delay).
    """
    # Much faster than numpy's quantile, which interpolates between two of the samples.
    place = int(QUANTILE * late.shape[-1])
    power = np.partition(late.real**2 + late.imag**2, place, axis=-1)[..., place]
    return np.sqrt(power / QUANTILE_OF_POWER)


def noise_of_survey(noises: np.ndarray) -> float:
    """Return the noise floor: that of the noisier polarization; 0 if nothing is known.

    Args:
        noises: Noise of each trace, first axis polarization; NaN where there is no trace.
    """
    flat = noises.reshape(len(noises), -1)
    known = [row[np.isfinite(row)] for row in flat]
    return max((float(np.median(row)) for row in known if row.size), default=0.0)


def noise_threshold_db(samples: int) -> float:
    """Return the level above the noise floor [dB] that noise alone does not exceed.

    Args:
        samples: How many values of noise there are in all.
    """
    ratio = math.sqrt(-math.log(FALSE_ALARM / max(samples, 1)))
    return float(decibels(ratio)) + ESTIMATE_MARGIN_DB


@dataclass(frozen=True)
class LevelScale:
    """How levels become shades.

    Args:
        noise: Root mean square of the noise, as an amplitude.
        threshold_db: Level that noise alone does not exceed [dB above noise].
        top_db: Level of the brightest shade [dB above noise].
    """

    noise: float
    threshold_db: float
    top_db: float

    def levels_db(self, amplitudes: np.ndarray) -> np.ndarray:
        """Return levels of amplitudes [dB above noise]; NaN stays NaN."""
        return decibels(amplitudes) - float(decibels(self.noise))

    def shades(self, levels_db: np.ndarray) -> np.ndarray:
        """Return shades of levels [dB above noise] from 0, noise, to 1 (float32); NaN stays NaN."""
        dark_db = self.threshold_db - BELOW_THRESHOLD_DB
        parts = (np.asarray(levels_db) - dark_db) / (self.top_db - dark_db)
        return np.clip(parts, 0.0, 1.0).astype(np.float32)

    def ticks(self) -> np.ndarray:
        """Return round levels [dB above noise] and their shades, the lowest first (n x 2)."""
        first = math.ceil((self.threshold_db - BELOW_THRESHOLD_DB) / TICK_STEP_DB) * TICK_STEP_DB
        levels_db = np.arange(first, self.top_db + 1.0, TICK_STEP_DB)
        return np.stack((levels_db, self.shades(levels_db)), axis=1)


class SteadyScale:
    """The scale of a survey while its traces arrive: it changes rarely and its top only rises.

    Args:
        samples: How many values of noise the planned survey has.
    """

    def __init__(self, samples: int) -> None:
        self._threshold_db = noise_threshold_db(samples)
        self._noise = 0.0
        self._strongest = 0.0

    def update(self, noise: float, strongest: float) -> None:
        """Take what is known now.

        Args:
            noise: Noise floor, as an amplitude.
            strongest: Amplitude of the strong echoes of the survey.
        """
        noise = max(noise, SMALLEST_LEVEL)
        if self._noise == 0.0 or abs(decibels(noise / self._noise)) > HYSTERESIS_DB:
            self._noise = noise
        self._strongest = max(self._strongest, strongest)

    def scale(self) -> LevelScale:
        """Return the scale now."""
        noise = max(self._noise, SMALLEST_LEVEL)
        strongest_db = float(decibels(max(self._strongest, SMALLEST_LEVEL) / noise))
        top_db = max(strongest_db, self._threshold_db + MIN_SPAN_DB)
        top_db = math.ceil(top_db / TOP_STEP_DB) * TOP_STEP_DB
        return LevelScale(noise, self._threshold_db, top_db)

"""The noise of a survey, measured where no echo arrives, and how high noise alone can reach.

Complex noise has magnitudes of a Rayleigh distribution: they exceed r times their root mean square
with the probability exp(-r^2).
"""

from __future__ import annotations

import math

import numpy as np

from gpr20_survey.radar.frequency_to_delay import decibels, delay_kernel, unambiguous_s

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


def late_kernel(frequency_hz: np.ndarray) -> np.ndarray:
    """Return what turns sweeps into samples at late delays: complex64 (frequency, delay)."""
    return delay_kernel(frequency_hz, late_delays_s(frequency_hz)).astype(np.complex64)


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

"""The noise of a survey, measured where no echo arrives, and how high noise alone can reach.

Complex noise has magnitudes of a Rayleigh distribution: they exceed r times their root mean square
with the probability exp(-r^2).
"""

from __future__ import annotations

import math

import numpy as np

# The lower quartile: some late delays may hold echoes of walls and trees, which only add power.
QUANTILE = 0.25
QUANTILE_OF_POWER = -math.log(1.0 - QUANTILE)
# Probability that noise alone exceeds the threshold anywhere in a whole survey.
FALSE_ALARM = 0.01
# The noise floor is an estimate: how far it may be off, with the hysteresis [dB].
ESTIMATE_MARGIN_DB = 0.8


def noise_of_trace(late: np.ndarray) -> float:
    """Return the root mean square of the noise of one trace.

    Args:
        late: Its complex samples at delays where no echo is expected.
    """
    # Much faster than numpy's quantile, which interpolates between two of the samples.
    place = int(QUANTILE * len(late))
    power = np.partition(late.real**2 + late.imag**2, place)[place]
    return math.sqrt(float(power) / QUANTILE_OF_POWER)


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
    ratio = math.sqrt(math.log(max(samples, 1) / FALSE_ALARM))
    return 20.0 * math.log10(ratio) + ESTIMATE_MARGIN_DB

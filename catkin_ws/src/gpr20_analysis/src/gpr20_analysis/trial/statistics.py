"""Statistics of a trial: 95 % intervals of shares and densities.

Clopper and Pearson (1934) for a share, Garwood (1936) for a Poisson count.
"""

from __future__ import annotations

import math
from typing import Tuple

from scipy.stats import beta, chi2

OUTSIDE, ONE_SIDED = 0.025, 0.05


def detection_interval(found: int, targets: int, outside: float = OUTSIDE) -> Tuple[float, float]:
    """Return the interval of a probability of detection, with a chance outside on each side."""
    low = 0.0 if found == 0 else float(beta.ppf(outside, found, targets - found + 1))
    high = 1.0 if found == targets else float(beta.ppf(1.0 - outside, found + 1, targets - found))
    return low, high


def shown_detection(found: int, targets: int) -> float:
    """Return the probability of detection that is shown: the one-sided lower limit of 95 %."""
    return detection_interval(found, targets, ONE_SIDED)[0]


def alarm_interval(count: int, area_m2: float) -> Tuple[float, float]:
    """Return the interval of a density of false alarms [1/m2]; nothing is known of no ground."""
    if not area_m2 > 0.0:
        return 0.0, math.inf
    low = 0.0 if count == 0 else float(chi2.ppf(OUTSIDE, 2 * count)) / (2.0 * area_m2)
    return low, float(chi2.ppf(1.0 - OUTSIDE, 2 * count + 2)) / (2.0 * area_m2)

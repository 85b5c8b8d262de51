"""Statistics of a trial: intervals of shares and densities, and tests of few counts.

Clopper and Pearson (1934) for a share, Garwood (1936) for a Poisson count, and McNemar's test in
its exact form, the binomial test of the targets that only one of two methods found.
"""

from __future__ import annotations

import math
from typing import Tuple

from scipy.stats import beta, binom, chi2

CONFIDENCE = 0.95
MOST_TARGETS = 10_000_000
"""No trial has more: what needs more cannot be shown."""


def detection_interval(
    found: int, targets: int, confidence: float = CONFIDENCE
) -> Tuple[float, float]:
    """Return the two-sided interval of a probability of detection; (0, 1) without a target."""
    outside = (1.0 - confidence) / 2.0
    low = 0.0 if found == 0 else float(beta.ppf(outside, found, targets - found + 1))
    high = 1.0 if found == targets else float(beta.ppf(1.0 - outside, found + 1, targets - found))
    return low, high


def shown_detection(found: int, targets: int, confidence: float = CONFIDENCE) -> float:
    """Return the probability of detection that is shown: the one-sided lower limit."""
    return detection_interval(found, targets, 2.0 * confidence - 1.0)[0]


def alarm_interval(
    count: int, area_m2: float, confidence: float = CONFIDENCE
) -> Tuple[float, float]:
    """Return the two-sided interval of a density of false alarms [1/m2].

    Args:
        count: Number of false alarms.
        area_m2: Searched ground outside all halos [m2]; of none, nothing is known.
        confidence: Of the interval.
    """
    if not area_m2 > 0.0:
        return 0.0, math.inf
    outside = (1.0 - confidence) / 2.0
    low = 0.0 if count == 0 else float(chi2.ppf(outside, 2 * count)) / (2.0 * area_m2)
    return low, float(chi2.ppf(1.0 - outside, 2 * count + 2)) / (2.0 * area_m2)


def targets_needed(detection: float, missed: int = 0, confidence: float = CONFIDENCE) -> int:
    """Return how many targets can show a probability of detection, one-sided.

    Args:
        detection: The probability to show, above 0 and below 1.
        missed: How many of the targets are missed.
        confidence: Of the one-sided limit.
    """
    too_few, enough = missed, MOST_TARGETS
    while enough - too_few > 1:
        middle = (too_few + enough) // 2
        shows = binom.cdf(missed, middle, 1.0 - detection) <= 1.0 - confidence
        too_few, enough = (too_few, middle) if shows else (middle, enough)
    return enough


def mcnemar(only_first: int, only_second: int) -> float:
    """Return the two-sided exact p-value of the targets that only one of two methods found."""
    both = only_first + only_second
    return min(1.0, 2.0 * float(binom.cdf(min(only_first, only_second), both, 0.5)))

"""Round numbers for an axis."""

from __future__ import annotations

import math

import numpy as np

STEPS = (1.0, 2.0, 5.0, 10.0, 20.0)


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """Return multiples of 1, 2 or 5 times a power of ten, from `low` to `high`.

    Args:
        low: First end of the axis.
        high: Other end, larger.
        most: How many there may be, at least one.
    """
    if not (math.isfinite(high - low) and high > low):
        return np.zeros(0)
    power = 10.0 ** math.floor(math.log10((high - low) / (most + 1)))
    for factor in STEPS:
        ticks = _multiples(low, high, factor * power)
        if len(ticks) <= most:
            return ticks
    return np.zeros(0)


def _multiples(low: float, high: float, step: float) -> np.ndarray:
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.arange(first, last + 1) * step

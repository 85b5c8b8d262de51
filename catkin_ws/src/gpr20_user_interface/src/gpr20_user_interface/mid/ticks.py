"""Round numbers for an axis."""

from __future__ import annotations

import math

import numpy as np

STEPS = (1.0, 2.0, 5.0, 10.0)


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """Return multiples of 1, 2 or 5 times a power of ten, from `low` to `high`.

    Args:
        low: First end of the axis.
        high: Other end, larger.
        most: How many there may be, at least 2.
    """
    least_step = (high - low) / max(most - 1, 1)
    if not (math.isfinite(least_step) and least_step > 0.0):
        return np.zeros(0)
    power = 10.0 ** math.floor(math.log10(least_step))
    step = next(one * power for one in STEPS if one * power >= least_step * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.arange(first, last + 1) * step

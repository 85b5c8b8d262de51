"""How often the clutter of a survey's own ground is as strong as an echo.

The weak echoes of a survey, which are left when the strongest were taken away, are its clutter.
Above their median their levels in dB fall off about exponentially; two of their quantiles give the
slope, and with it the number per m2 that a level is exceeded. Of ground without bodies that is the
density of false alarms. The bodies themselves hardly move these quantiles, because they are few
among the hundreds of maxima of a volume.
"""

from __future__ import annotations

import math
from typing import Optional, Tuple

import numpy as np

# Share of the weak echoes that is stronger than the two quantiles.
HALF, FEW = 0.5, 0.05
DECAY = math.log(HALF / FEW)
# With fewer weak echoes nothing is said, nor of a smaller area: it has nothing beside one body.
FEWEST_ECHOES, LEAST_M2 = 40, 0.036
# A single line sees that much of the ground beside it, and so does a narrow area.
STRIP_M = 0.3
TWO_SIDED_95 = 1.96


class FalseAlarms:
    """The density of the clutter of a survey.

    Args:
        weak_db: Levels of the weak echoes above the clutter around them [dB].
        area_m2: Surveyed area [m2].
    """

    def __init__(self, weak_db: np.ndarray, area_m2: float) -> None:
        self.are_known = len(weak_db) >= FEWEST_ECHOES and area_m2 >= LEAST_M2
        if self.are_known:
            self._count, self._density = len(weak_db), len(weak_db) * HALF / area_m2
            self._median_db, few_db = np.quantile(weak_db, [1.0 - HALF, 1.0 - FEW])
            self._slope_db = max(float(few_db - self._median_db), 1e-6) / DECAY

    def per_m2(self, above_db: float) -> Optional[float]:
        """Return how many echoes of the clutter are as strong [1/m2]; None if not known."""
        if not self.are_known:
            return None
        slopes = (above_db - self._median_db) / self._slope_db
        return self._density * math.exp(-max(slopes, 0.0))

    def range_per_m2(self, above_db: float) -> Tuple[Optional[float], Optional[float]]:
        """Return the 95 % interval of that number, by the scatter of the two quantiles."""
        per_m2 = self.per_m2(above_db)
        if per_m2 is None:
            return None, None
        slopes = max((above_db - self._median_db) / self._slope_db, 0.0)
        # Of an exponential distribution: the variance of a quantile with a share p above it is
        # (1 / p - 1) / n, in units of its mean.
        scatter = math.sqrt((1.0 / FEW - 1.0 / HALF) / self._count) / DECAY
        factor = math.exp(TWO_SIDED_95 * scatter * slopes)
        return per_m2 / factor, per_m2 * factor

    def level_db(self, per_m2: float) -> float:
        """Return the level that so many echoes of the clutter exceed [dB]."""
        return float(self._median_db + self._slope_db * math.log(max(self._density / per_m2, 1.0)))


def surveyed_m2(x_m: np.ndarray, y_m: np.ndarray) -> float:
    """Return the area of the ground that a survey sees, at least a strip as of a line [m2]."""
    shorter_m, longer_m = sorted(float(np.ptp(axis_m)) for axis_m in (x_m, y_m))
    return longer_m * max(shorter_m, STRIP_M)

"""How probable it is that noise alone has a maximum as bright as one that was found.

Adjacent voxels of an image are similar, so it has fewer independent ones than voxels. The number of
local maxima of noise above a level is computed from the correlation of adjacent voxels, as Taylor,
Worsley and Gosselin do for discretely sampled random fields (Biometrika 94, 2007), and applied here
to the magnitude of complex noise. Levels of other distributions are first replaced by the level
that complex noise exceeds with the same probability.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from scipy.special import ndtr

FURTHEST = 12.0
STEPS = 1200
ANGLES = 64


class FalseAlarms:
    """Probability of false alarms in an image of noise.

    Args:
        voxels: Number of voxels of all polarizations.
        correlation: Magnitude of the correlation of adjacent voxels along each axis, 0 to 1.
    """

    def __init__(self, voxels: int, correlation: Sequence[float]) -> None:
        self._level = np.linspace(0.0, FURTHEST, STEPS)
        share = np.ones(STEPS)
        for one in correlation:
            share *= _above_neighbors(self._level, min(max(float(one), 0.0), 0.9999))
        self._log_voxels = math.log(voxels)
        # The share of the voxels above a level that are local maxima, averaged over all above it.
        density = self._level * np.exp(-(self._level**2) / 2.0)
        step = self._level[1]
        above = np.cumsum((density * share)[::-1])[::-1] * step
        self._log_share = np.log(above) + self._level**2 / 2.0
        # The last sums have too few steps.
        last = int(0.97 * STEPS)
        self._log_share[last:] = self._log_share[last]

    def log_expected(self, log_tail: np.ndarray) -> np.ndarray:
        """Return the logarithm of the expected number of maxima of noise as bright.

        Args:
            log_tail: Logarithm of the probability that one voxel of noise is as bright.
        """
        level = np.sqrt(-2.0 * np.minimum(log_tail, 0.0))
        return self._log_voxels + np.interp(level, self._level, self._log_share) + log_tail

    def probability(self, log_tail: float) -> float:
        """Return the probability that noise alone has any maximum as bright, 0 to 1."""
        expected = float(self.log_expected(np.asarray(log_tail)))
        return 1.0 if expected > 30.0 else -math.expm1(-math.exp(expected))

    def log_tail_at(self, probability: float) -> float:
        """Return the logarithm of the tail of one voxel at a false-alarm probability."""
        wanted = math.log(-math.log1p(-probability))
        tails = -(self._level**2) / 2.0
        # Beyond the table the share is constant.
        expected = self.log_expected(tails)
        if wanted < expected[-1]:
            return float(tails[-1] + wanted - expected[-1])
        falling = np.minimum.accumulate(expected)
        return float(np.interp(-wanted, -falling, tails))


def _above_neighbors(level: np.ndarray, correlation: float) -> np.ndarray:
    """Return the probability that a voxel at a level is brighter than both neighbors on an axis."""
    if correlation == 0.0:
        return np.ones(level.shape)
    slope = math.sqrt((1.0 - correlation) / (1.0 + correlation))
    largest = math.asin(math.sqrt((1.0 - correlation**2) / 2.0))
    angle = (np.arange(ANGLES) + 0.5) / ANGLES * largest
    power = -0.5 * (slope * level[:, None] / np.sin(angle)) ** 2
    both = np.exp(power).mean(axis=1) * largest / math.pi
    return np.maximum(1.0 - 2.0 * ndtr(-slope * level) + both, 1e-12)

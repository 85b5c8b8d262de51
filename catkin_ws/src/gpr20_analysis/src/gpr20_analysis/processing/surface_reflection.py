"""The permittivity of the soil at its surface, from how strongly the surface reflects.

At normal incidence soil reflects (1 - n) / (1 + n) of what a metal plate reflects, with the
refractive index n. A rough surface reflects exp(-2 (k sigma)^2) of that, with the wave number k in
air and the standard deviation sigma of the heights (Ament, "Toward a theory of reflection by a
rough surface", Proceedings of the IRE 41 (1953), 142 to 146): it is extrapolated to frequency 0.
"""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from gpr20_analysis.processing.antenna_model import AntennaModel
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S

BLOCKS = 8
# Half of a 95 % range, as a share of the reflection: plate and antennas are not perfect.
OF_MODEL = 0.01
# Over wave number and path, squared: near a dipole the reflection of soil is smaller by that much.
OF_NEAR_FIELD = 3.0
LEAST, MOST = 0.02, 0.85
WIDEST_RATIO = 2.25
"""Of the ends of a measured range: depths are then known to a factor of 1.5."""


def surface_permittivity(
    ground: np.ndarray, path_m: np.ndarray, model: AntennaModel, separation_m: float
) -> Optional[Tuple[float, float, float]]:
    """Return lowest, best and highest permittivity, or None if the reflection is not clear enough.

    Args:
        ground: What comes back from the ground (trace, frequency).
        path_m: Path over the surface of each trace, by the delay of its echo [m].
        model: The antennas.
        separation_m: Distance between the antennas [m].
    """
    ratio = ground / model.mirror(path_m)
    weights = np.abs(model.transmission) * np.hanning(len(model.frequency_hz) + 2)[1:-1]
    wave = 2.0 * np.pi * model.frequency_hz / SPEED_OF_LIGHT_M_S
    blocks = np.array_split(np.arange(len(ratio)), min(BLOCKS, len(ratio)))
    sums = np.stack([ratio[block].sum(axis=0) for block in blocks])
    counts = np.array([len(block) for block in blocks])
    total, count = sums.sum(axis=0), int(counts.sum())
    at_once, level = _reflection(total / count, wave, weights)
    left_out = [
        _reflection((total - one) / (count - number), wave, weights)[0]
        for one, number in zip(sums, counts)
        if number < count
    ]
    # Jackknife: neighbouring traces see the same ground.
    scatter = np.sqrt((len(left_out) - 1.0) * np.var(left_out)) if left_out else level
    mean_m = float(np.mean(path_m))
    aslant = (separation_m / mean_m) ** 2
    near = (OF_NEAR_FIELD / (float(np.average(wave, weights=weights)) * mean_m)) ** 2
    share = OF_MODEL + aslant + max(near, model.misfit)
    half = at_once * share + 2.0 * float(scatter) + 0.5 * abs(at_once - level)
    ends = at_once - half, at_once, at_once + half
    # Written so that NaN is refused too.
    if not (ends[0] > LEAST and ends[2] < MOST):
        return None
    lowest, best, highest = (((1.0 + one) / (1.0 - one)) ** 2 for one in ends)
    if highest > WIDEST_RATIO * lowest:
        return None
    return lowest, best, highest


def _reflection(mean: np.ndarray, wave: np.ndarray, weights: np.ndarray) -> Tuple[float, float]:
    """Return the reflection at frequency 0, and its mean over the band."""
    level = float(np.abs(np.average(mean, weights=weights)))
    # Of the logarithm, by the square of the wave number; each weighted by its amplitude.
    weights = weights * np.abs(mean)
    squared = wave**2 - np.average(wave**2, weights=weights)
    logarithm = np.log(np.maximum(np.abs(mean), 1e-12))
    middle = float(np.average(logarithm, weights=weights))
    slope = float(np.sum(weights * squared * logarithm) / np.sum(weights * squared**2))
    if not slope < 0.0:
        return level, level
    return float(np.exp(middle - slope * np.average(wave**2, weights=weights))), level

"""The far-field model of the antennas, fitted to measurements over a metal plate.

Lambot, Slob, van den Bosch, Stockbroeckx and Vanclooster, "Modeling of ground-penetrating radar
for accurate characterization of subsurface electric properties", IEEE Transactions on Geoscience
and Remote Sensing 42 (2004), 2555 to 2568: at each frequency

    S21 = internal + transmission * ground / (1 - feedback * ground),

where `ground` is what comes back from below an isotropic source. Internal are the coupling and the
ringing of the antennas, feedback is what they reflect back to the ground. Over a metal plate the
ground is known: a mirror at the known height. So measurements at several heights give all three.

The permittivity of the soil at its surface, from how strongly the surface reflects.

At normal incidence soil reflects (1 - n) / (1 + n) of what a metal plate reflects, with the
refractive index n. A rough surface reflects exp(-2 (k sigma)^2) of that, with the wave number k in
air and the standard deviation sigma of the heights (Ament, "Toward a theory of reflection by a
rough surface", Proceedings of the IRE 41 (1953), 142 to 146): it is extrapolated to frequency 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Tuple

import numpy as np

from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S

FEWEST_HEIGHTS = 4
# Three unknowns of each frequency are not determined if the heights look alike to it.
SMALLEST_SHARE = 1e-3
# Of the path: where waves seem to come from, above or below the plane of the antennas.
CENTRES_M = np.linspace(-0.08, 0.08, 9)
MOST_ROUNDS = 40
SETTLED_M = 2e-6
BLOCKS = 8
# Half of a 95 % range, as a share of the reflection: plate and antennas are not perfect.
OF_MODEL = 0.01
# Over wave number and path, squared: near a dipole the reflection of soil is smaller by that much.
OF_NEAR_FIELD = 3.0
LEAST, MOST = 0.02, 0.85
WIDEST_RATIO = 2.25
"""Of the ends of a measured range: depths are then known to a factor of 1.5."""


@dataclass(frozen=True)
class AntennaModel:
    """What the antennas add to what comes back from the ground, for one rotation.

    Attributes:
        frequency_hz: Frequencies [Hz].
        internal: Coupling and ringing (frequency,).
        transmission: Through cables and antennas (frequency,) [m].
        feedback: Of the antennas to the ground (frequency,) [m].
        centre_m: Added to the length of a path, whose inverse is the spreading of a wave [m].
        misfit: Root mean square of what the model leaves, as a share of what differs between the
            heights.
        moved_m: By how much each recorded height had to be corrected [m]; their mean is 0.
    """

    frequency_hz: np.ndarray
    internal: np.ndarray
    transmission: np.ndarray
    feedback: np.ndarray
    centre_m: float = 0.0
    misfit: float = 0.0
    moved_m: Tuple[float, ...] = ()

    def mirror(self, path_m: np.ndarray) -> np.ndarray:
        """Return what comes back from a plate (path, frequency), by the length of its path [m]."""
        turns = np.outer(path_m, self.frequency_hz) / SPEED_OF_LIGHT_M_S
        spread: np.ndarray = -np.exp(-2j * np.pi * turns) / (path_m + self.centre_m)[:, None]
        return spread

    def ground(self, s21: np.ndarray) -> np.ndarray:
        """Return what comes back from the ground, of spectra (..., frequency)."""
        received = s21 - self.internal
        found: np.ndarray = received / (self.transmission + self.feedback * received)
        return found

    def s21(self, ground: np.ndarray) -> np.ndarray:
        """Return the spectra of what comes back from the ground (..., frequency)."""
        found: np.ndarray = self.internal + self.transmission * ground / (
            1.0 - self.feedback * ground
        )
        return found


def fit_antenna(s21: np.ndarray, path_m: np.ndarray, frequency_hz: np.ndarray) -> AntennaModel:
    """Return the model that explains measurements over a plate.

    The recorded heights are corrected, since an error of 1 mm turns the phase at 6 GHz by 14
    degrees; their mean is kept.

    Args:
        s21: Mean spectra at each height (height, frequency), of at least `FEWEST_HEIGHTS`.
        path_m: From one antenna over the plate to the other, at each height [m].
        frequency_hz: Frequencies [Hz].
    """
    centres_m = CENTRES_M[-0.5 * float(path_m.min()) < CENTRES_M]
    fits = [_of_centre(s21, path_m, frequency_hz, float(one)) for one in centres_m]
    return min(fits, key=lambda one: one.misfit)


def _of_centre(
    s21: np.ndarray, path_m: np.ndarray, frequency_hz: np.ndarray, centre_m: float
) -> AntennaModel:
    differing = float(np.sum(np.abs(s21 - s21.mean(axis=0)) ** 2))
    wave = 2.0 * np.pi * frequency_hz / SPEED_OF_LIGHT_M_S
    moved_m = np.zeros(len(path_m))
    for _ in range(MOST_ROUNDS):
        model = _solved(s21, path_m + moved_m, frequency_hz, centre_m)
        explained = model.s21(model.mirror(path_m + moved_m)) - model.internal
        left = s21 - model.internal - explained
        # By how much each path is longer, from the phase that is left.
        level = np.abs(explained) ** 2
        turned = np.angle((s21 - model.internal) * explained.conj())
        weight = np.maximum(np.sum(level * wave**2, axis=1), 1e-300)
        step_m = -np.sum(level * turned * wave, axis=1) / weight
        step_m -= step_m.mean()
        moved_m = moved_m + step_m
        if np.abs(step_m).max() < SETTLED_M:
            break
    # Surveys that do not differ are explained by anything, which explains nothing.
    alike = differing <= 1e-20 * float(np.sum(np.abs(s21) ** 2))
    misfit = 1.0 if alike else float(np.sqrt(np.sum(np.abs(left) ** 2) / differing))
    return replace(model, misfit=misfit, moved_m=tuple((0.5 * moved_m).tolist()))


def _solved(
    s21: np.ndarray, path_m: np.ndarray, frequency_hz: np.ndarray, centre_m: float
) -> AntennaModel:
    """Return the model by least squares at each frequency, with the heights given.

    Times the denominator, the equation is linear in internal, in feedback, and in transmission
    less the product of both.
    """
    nothing = np.zeros(len(frequency_hz), dtype=np.complex128)
    mirror = AntennaModel(frequency_hz, nothing, nothing, nothing, centre_m).mirror(path_m)
    columns = np.stack([np.ones_like(s21), mirror, s21 * mirror], axis=-1).transpose(1, 0, 2)
    scale = np.maximum(np.linalg.norm(columns, axis=1), 1e-300)
    inverse = np.linalg.pinv(columns / scale[:, None], rcond=SMALLEST_SHARE)
    found = np.einsum("fkh,hf->kf", inverse, s21) / scale.T
    transmission = found[1] + found[0] * found[2]
    return AntennaModel(frequency_hz, found[0], transmission, found[2], centre_m)


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

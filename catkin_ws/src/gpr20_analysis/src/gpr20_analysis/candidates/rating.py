"""How bright the voxels of an image are, compared with its noise and its clutter."""

from __future__ import annotations

import math
from typing import Optional, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.special import ndtr

from gpr20_analysis.dataset import DEPTH, NOISE, NOISE_OVER_X, NOISE_OVER_Y, POLARIZATION, X, Y
from gpr20_analysis.imaging.methods import law_of
from gpr20_analysis.imaging.noise import Law
from gpr20_survey.radar.depth import one_way_path_m

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


# -3 dB width of a peak whose correlation has a Gaussian shape, in units of its curvature.
WIDTH = 2.0 * math.sqrt(math.log(2.0))
# Highest local maxima beside targets, measured: -33 dB for points, -20 dB for larger ones; products
# of the Kirchhoff method: -9 dB.
SIDELOBE_DB = {Law.RAYLEIGH: 20.0, Law.PRODUCT: 8.0, Law.HALF_NORMAL: 8.0}
# The noise may be this much higher than measured, on small grids. Rare values of a product are so
# large that this decides how often they seem to occur.
NOISE_UP_TO = {Law.RAYLEIGH: 1.0, Law.PRODUCT: 1.1, Law.HALF_NORMAL: 1.0}
# Clutter this much above noise over the whole area; a candidate must be brighter than it.
CLUTTER, CLUTTER_ALARM = 2.0, 0.01
# Errors of a peak between voxels, as a share of the step, where noise is negligible. The Kirchhoff
# methods take the nearest samples and angles, and can lose the first sample.
SHARE_OF_STEP = {Law.RAYLEIGH: 0.1, Law.PRODUCT: 0.5, Law.HALF_NORMAL: 0.5}
# Errors of depth, y and x where each line along X is migrated alone: it shows targets beside it,
# and shows them deeper.
BESIDE_LINE_M = (0.015, 0.07, 0.0)
# Resolution without a measurement, and the band for it.
ACROSS_M, BAND_HZ = 0.03, 5.4e9


class Rating:
    """The brightness of the voxels of an image.

    Args:
        image: Dataset of `image_survey`.
        magnitude: Its magnitudes (polarization, depth, y, x).
    """

    def __init__(self, image: xr.Dataset, magnitude: np.ndarray) -> None:
        self._magnitude = magnitude
        self._law = law_of(str(image.attrs["method"]))
        self.is_rated = NOISE in image
        correlation: Tuple[float, ...] = (0.0, 0.0, 0.0)
        steps_m = np.array([_step_m(image[name].values) for name in (DEPTH, Y, X)])
        if self.is_rated:
            noise = image[NOISE].transpose(POLARIZATION, DEPTH)
            self._noise = noise.values
            self._over = image[NOISE_OVER_Y].values[:, None] * image[NOISE_OVER_X].values
            correlation = tuple(float(noise.attrs[f"correlation_{name}"]) for name in (DEPTH, Y, X))
        self._alarms = FalseAlarms(magnitude.size, correlation)
        self._plane_alarms = FalseAlarms(max(1, magnitude[0, 0].size), (0.0, *correlation[1:]))
        self._steps_m = steps_m
        usual_m = np.array([_usual_depth_resolution_m(image), ACROSS_M, ACROSS_M])
        width_m = WIDTH * _curvature_m(correlation, steps_m)
        self.resolution_m = np.maximum(np.where(np.isnan(width_m), usual_m, width_m), steps_m)
        """-3 dB width of a peak along depth, y and x, at least one voxel [m]."""

    @property
    def polarizations(self) -> int:
        """Number of polarizations."""
        return len(self._magnitude)

    @property
    def sidelobe_db(self) -> float:
        """A peak that much fainter than one near it may be a sidelobe [dB]."""
        return SIDELOBE_DB[self._law]

    def magnitude(self, turn: int) -> np.ndarray:
        """Return the magnitudes (depth, y, x) of a polarization."""
        return self._magnitude[turn]

    def level(self, turn: int) -> np.ndarray:
        """Return magnitudes (depth, y, x) above noise; bare magnitudes if it is not known."""
        if not self.is_rated:
            return self._magnitude[turn]
        return self._magnitude[turn] / (self._noise[turn][:, None, None] * self._over)

    def threshold(self, false_alarm_rate: float) -> float:
        """Return the level that noise exceeds anywhere with a probability; 0 if not known."""
        if not self.is_rated:
            return 0.0
        ratio = self._law.ratio_at(self._alarms.log_tail_at(false_alarm_rate))
        return ratio * NOISE_UP_TO[self._law]

    def magnitudes_at(self, place: np.ndarray) -> np.ndarray:
        """Return the magnitudes of voxels (voxel, 4): polarization, depth, y, x."""
        found: np.ndarray = self._magnitude[tuple(place.T)]
        return found

    def above_noise_db(self, level: np.ndarray) -> np.ndarray:
        """Return levels of voxels above noise [dB]; NaN if the noise is not known."""
        if not self.is_rated:
            return np.full(np.shape(level), np.nan)
        return self._law.level_db(level)

    def false_alarm_probability(self, level: float) -> float:
        """Return the probability that noise alone has a voxel of a level; 1 if not known."""
        if not self.is_rated:
            return 1.0
        ratio = np.asarray(level) / NOISE_UP_TO[self._law]
        return self._alarms.probability(float(self._law.log_tail(ratio)))

    def polarization_ratio_db(self, place: Sequence[int]) -> Optional[float]:
        """Return the level of the first polarization above the second around a voxel [dB]."""
        if self.polarizations != 2:
            return None
        reach = np.rint(self.resolution_m / 2.0 / np.maximum(self._steps_m, 1e-6)).astype(int)
        around = tuple(
            slice(max(0, at - some), at + some + 1) for at, some in zip(place, reach.tolist())
        )
        first, second = (float(one[around].max()) for one in self._magnitude)
        if first == 0.0 or second == 0.0:
            return None
        return float(self._law.level_db(np.asarray(first / second)))

    def is_clutter(self, place: np.ndarray, level: np.ndarray) -> np.ndarray:
        """Return whether voxels are no brighter than what the whole area shows at their depth.

        The median of a plane is hardly moved by a target. If it is clearly above that of noise,
        the plane shows clutter, and a voxel must be brighter than the brightest of such a plane.

        Args:
            place: Their indices (voxel, 4): polarization, depth, y, x.
            level: Their levels above noise.
        """
        found = np.zeros(len(place), dtype=bool)
        if not self.is_rated:
            return found
        planes, of_plane = np.unique(place[:, :2], axis=0, return_inverse=True)
        medians = [np.median(self._plane_level(turn, depth)) for turn, depth in planes]
        usual = (np.array(medians) / self._law.median)[of_plane.ravel()]
        doubtful = np.flatnonzero(usual >= CLUTTER)
        tails = self._law.log_tail(level[doubtful] / usual[doubtful])
        alarms = [self._plane_alarms.probability(tail) for tail in tails.tolist()]
        found[doubtful] = np.array(alarms) > CLUTTER_ALARM
        return found

    def picking_m(self, above_noise_db: float) -> np.ndarray:
        """Return standard deviations of depth, y and x of a peak by noise and voxels [m].

        Args:
            above_noise_db: Its level; NaN if it is not known.
        """
        of_voxels_m = SHARE_OF_STEP[self._law] * self._steps_m
        if self._law is Law.HALF_NORMAL and self._steps_m[1] > 0.0:
            of_voxels_m = np.maximum(of_voxels_m, BESIDE_LINE_M)
        if math.isnan(above_noise_db):
            return np.hypot(of_voxels_m, self.resolution_m / 2.0)
        curvature_m = self.resolution_m / WIDTH
        return np.hypot(of_voxels_m, curvature_m / math.sqrt(2.0) * 10 ** (-above_noise_db / 20))

    def _plane_level(self, turn: int, depth: int) -> np.ndarray:
        level: np.ndarray = self._magnitude[turn, depth] / (self._noise[turn, depth] * self._over)
        return level


def _step_m(axis_m: np.ndarray) -> float:
    return float(np.ptp(axis_m)) / (len(axis_m) - 1) if len(axis_m) > 1 else 0.0


def _curvature_m(correlation: Sequence[float], step_m: np.ndarray) -> np.ndarray:
    """Return the width of the Gaussian through the correlation of adjacent voxels [m].

    NaN along an axis whose voxels are independent or only one.
    """
    fall = -2.0 * np.log(np.clip(correlation, 1e-3, 1.0 - 1e-9))
    known = (np.asarray(correlation) > 0.1) & (step_m > 0.0)
    return np.where(known, step_m / np.sqrt(fall), np.nan)


def _usual_depth_resolution_m(image: xr.Dataset) -> float:
    permittivity = float(image.attrs["permittivity"])
    return 1.44 * one_way_path_m(1.0 / BAND_HZ, permittivity)

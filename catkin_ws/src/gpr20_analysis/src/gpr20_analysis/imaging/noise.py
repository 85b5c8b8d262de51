"""The noise of an image, measured from the data at delays where no echo can arrive.

A survey covers delays up to 1 / frequency step, about 46 ns, and its image uses the first 5 to 10
ns. A phase ramp over the spectra brings a late part of the delays to the front. The image of that,
by the same method with the same options, holds noise alone: as much as the image itself has, since
noise does not depend on the delay. So the reference does not depend on what the image shows.

Noise varies slowly over an image, because the method collects it from more or fewer traces. It is
fitted by a product of smooth functions of depth, y and x, through the logarithms of the voxels,
which a few bright ones hardly move.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Callable, List, Optional, Sequence, Tuple

import numpy as np
from scipy.special import erfc, k0, log_ndtr

from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.processing.sweep import a_scans
from gpr20_survey.radar.depth import delay_of_depth
from gpr20_survey.radar.frequency_to_delay import decibels, phase_advance
from gpr20_survey.radar.noise import rayleigh_ratio

Imager = Callable[[Traces, Focus], Tuple[np.ndarray, np.ndarray]]
"""Returns the image (depth, y, x) of traces and its depths [m]."""

TRACES_LOOKED_AT = 400
# Fewest planes and voxels that are imaged for the measurement, and least depth that they cover [m].
PLANES, VOXELS, DEEPEST_M = 6, 40_000, 0.3
# Small grids, of which so many planes have fewer voxels than that, use two late parts.
MANY = 12
# Longest delay of the voxels, relative to that of the vertical path, since waves arrive aslant too,
# and delays around those of echoes that their sidelobes reach, in periods of the band. The second
# pair is for sweeps with few frequencies.
MARGINS = ((1.3, 10.0), (1.1, 4.0))
# Power of a part of the delays relative to the quietest, and number of parts that are used.
ABOUT, WINDOWS = 1.1, 2
EULER = 0.5772156649015329


class Law(enum.Enum):
    """How the magnitudes of a voxel of noise are distributed."""

    RAYLEIGH = "rayleigh"
    """A sum of complex noise; the unit is its root mean square."""
    HALF_NORMAL = "half-normal"
    """A sum of real noise; the unit is its root mean square."""
    PRODUCT = "product"
    """The product of two independent half-normal ones; the unit is the product of theirs."""

    @property
    def mean_log(self) -> float:
        """Mean of the natural logarithm of a magnitude in its unit."""
        return -EULER / 2.0 if self is Law.RAYLEIGH else self._factors * -(EULER + math.log(2)) / 2

    @property
    def median(self) -> float:
        """Median magnitude in its unit."""
        return self.ratio_at(math.log(0.5))

    @property
    def _factors(self) -> int:
        return 2 if self is Law.PRODUCT else 1

    @property
    def depth_degree(self) -> int:
        """Degree of the logarithm of the noise over depth: the group's gain is no exponential."""
        return 1 if self is Law.RAYLEIGH else 3

    def log_tail(self, ratio: np.ndarray) -> np.ndarray:
        """Return the logarithm of the probability that noise exceeds a magnitude.

        Args:
            ratio: Magnitudes in the unit of the law.
        """
        if self is Law.RAYLEIGH:
            return -(np.asarray(ratio, dtype=np.float64) ** 2)
        if self is Law.HALF_NORMAL:
            return np.log(2.0) + log_ndtr(-np.asarray(ratio, dtype=np.float64))
        ratios, tails = _product_tail()
        within = np.interp(ratio, ratios, tails)
        beyond = tails[-1] - (ratio - ratios[-1]) - 0.5 * np.log(np.maximum(ratio, 1) / ratios[-1])
        return np.where(ratio > ratios[-1], beyond, within)

    def ratio_at(self, log_tail: float) -> float:
        """Return the magnitude in the unit of the law that noise exceeds with a probability."""
        if self is Law.RAYLEIGH:
            return rayleigh_ratio(log_tail)
        from scipy.optimize import brentq  # its import takes 0.2 s

        return float(brentq(lambda ratio: float(self.log_tail(ratio)) - log_tail, 0.0, 1e4))

    def level_db(self, ratio: np.ndarray) -> np.ndarray:
        """Return levels above the unit on the scale of amplitudes [dB]."""
        with np.errstate(divide="ignore"):
            return decibels(ratio, 0.0) / self._factors


@lru_cache(maxsize=None)
def _product_tail() -> Tuple[np.ndarray, np.ndarray]:
    """Return ratios and log P(|XY| > ratio) for standard normal X and Y."""
    ratios = np.concatenate(([0.0], np.geomspace(1e-6, 60.0, 4000)))
    density = 2.0 / np.pi * k0(np.maximum(ratios, 1e-9))
    steps = np.diff(ratios) * (density[1:] + density[:-1]) / 2.0
    beyond = (
        2.0 / np.pi * math.sqrt(math.pi / 2.0) * erfc(math.sqrt(ratios[-1])) * math.sqrt(math.pi)
    )
    tail = np.append(np.cumsum(steps[::-1])[::-1], 0.0) + beyond
    return ratios, np.log(np.minimum(tail / tail[0], 1.0))


@dataclass(frozen=True)
class NoiseReference:
    """The noise of an image: a product of functions of depth, y and x.

    Attributes:
        depth: Magnitude at each polarization and depth (polarization, depth), in the unit of the
            law; its mean over the area is that of the image.
        over_y: Factor at each position along Y.
        over_x: Factor at each position along X.
        correlation: Magnitude of the correlation of adjacent voxels along depth, y and x, 0 to 1;
            0 along an axis with one position.
        late_s: Delay from which on the noise was taken [s].
    """

    depth: np.ndarray
    over_y: np.ndarray
    over_x: np.ndarray
    correlation: Tuple[float, ...]
    late_s: float


def measured_noise(
    traces: Sequence[Traces], focus: Focus, depth_m: np.ndarray, law: Law, imager: Imager
) -> Optional[NoiseReference]:
    """Return the noise of an image; None if its delays leave no room for a measurement.

    Args:
        traces: One item per polarization.
        focus: How the image was focused.
        depth_m: Depths of the image [m].
        law: Distribution of its noise.
        imager: The method.
    """
    some = _reference_focus(focus, depth_m, traces[0].height_m.size)
    starts_s = late_delays_s(traces, some)
    if not starts_s:
        some = replace(some, depth_m=focus.depth_m)
        starts_s = late_delays_s(traces, some)
    if not starts_s:
        return None
    if traces[0].height_m.size * MANY >= VOXELS:
        starts_s = starts_s[:1]
    per_trace = [
        [_measured(advanced(one, late_s), some, law, imager) for late_s in starts_s]
        for one in traces
    ]
    every = [one for ones in per_trace for one in ones]
    if not all(np.all(np.isfinite(one.over_depth)) for one in every):
        return None
    logarithm = np.stack([np.mean([one.over_depth for one in ones], axis=0) for ones in per_trace])
    found_m = every[0].depth_m
    return NoiseReference(
        np.exp(np.stack([_curve(found_m, one, depth_m, law) for one in logarithm])),
        np.exp(np.mean([one.over_y for one in every], axis=0)),
        np.exp(np.mean([one.over_x for one in every], axis=0)),
        tuple(float(one) for one in np.mean([one.correlation for one in every], axis=0)),
        starts_s[0],
    )


def late_delays_s(traces: Sequence[Traces], focus: Focus) -> List[float]:
    """Return delays after which as many quiet delays follow as the image uses, the latest first.

    Late echoes arrive in some parts of the delays, so only those are returned that are about as
    quiet as the quietest; at most two. Empty if there is no such part.
    """
    sweep = traces[0].sweep
    height_m = max(float(np.max(one.height_m)) for one in traces)
    deepest_s = float(delay_of_depth(float(focus.depth_m[-1]), height_m, focus.permittivity))
    for aslant, guard in MARGINS:
        longest_s = aslant * deepest_s
        guard_s = guard / (sweep.step_hz * sweep.count)
        first_s, last_s = longest_s + guard_s, sweep.unambiguous_s - longest_s - guard_s
        if first_s <= last_s:
            return _quiet_s(traces, focus, max(first_s, last_s / 2.0), last_s, longest_s)
    return []


def _quiet_s(
    traces: Sequence[Traces], focus: Focus, first_s: float, last_s: float, length_s: float
) -> List[float]:
    power = np.mean([_power_over_delay(one, focus) for one in traces], axis=0)
    delay_s = traces[0].sweep.unambiguous_s * np.arange(len(power)) / len(power)
    starts_s = last_s - length_s * np.arange(1 + int((last_s - first_s) / length_s))
    loudness = np.array(
        [np.mean(power[(delay_s >= start) & (delay_s <= start + length_s)]) for start in starts_s]
    )
    # Not the quietest alone: of equal ones that is always below the mean.
    quiet = starts_s[loudness <= ABOUT * loudness.min()]
    return [float(one) for one in quiet[:WINDOWS]]


def advanced(traces: Traces, late_s: float) -> Traces:
    """Return traces whose delay 0 was at a later delay."""
    shift = phase_advance(traces.sweep.frequency_hz, np.asarray(late_s)).astype(np.complex64)
    return replace(traces, s21=traces.s21 * shift)


def _power_over_delay(traces: Traces, focus: Focus) -> np.ndarray:
    flat = traces.s21.reshape(-1, traces.sweep.count)
    some = flat[:: max(1, len(flat) // TRACES_LOOKED_AT)]
    samples = a_scans(some, traces.sweep, traces.sweep.count, focus.window)
    return np.mean(np.abs(samples) ** 2, axis=0)


def _reference_focus(focus: Focus, depth_m: np.ndarray, voxels: int) -> Focus:
    """Return a focus at depths for the measurement, the same for every range of an image.

    Planes come in pairs with the step of the image, which tell the correlation of adjacent voxels.

    Args:
        focus: How the image was focused.
        depth_m: Depths of the image [m].
        voxels: Number of voxels of each plane.
    """
    last_m = max(DEEPEST_M, float(focus.depth_m[-1]))
    step_m = float(np.min(np.diff(depth_m)))
    pairs = max(PLANES, VOXELS // voxels) // 2
    if last_m / step_m < 2 * pairs:
        return replace(focus, depth_m=np.arange(0.0, last_m + step_m / 2.0, step_m))
    first_m = np.linspace(0.0, last_m - step_m, pairs)
    return replace(focus, depth_m=np.sort(np.concatenate((first_m, first_m + step_m))))


@dataclass(frozen=True)
class _Measured:
    """Logarithms of the noise of one volume and of its factors, and correlations."""

    depth_m: np.ndarray
    over_depth: np.ndarray
    over_y: np.ndarray
    over_x: np.ndarray
    correlation: Tuple[float, ...]


def _measured(traces: Traces, focus: Focus, law: Law, imager: Imager) -> _Measured:
    volume, depth_m = imager(traces, focus)
    over_depth, over_y, over_x = _fit(np.abs(volume), depth_m, law)
    scale = np.exp(over_depth[:, None, None] + over_y[:, None] + over_x)
    correlation = _likeness(volume / scale, depth_m, law)
    return _Measured(depth_m, over_depth, over_y, over_x, correlation)


def _fit(
    magnitude: np.ndarray, depth_m: np.ndarray, law: Law
) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the logarithm of the noise over depth, and of its factors over y and x."""
    with np.errstate(divide="ignore"):
        logarithm = np.log(magnitude) - law.mean_log
    if not np.all(np.isfinite(logarithm)):
        # Traces that are zero make voxels that are zero.
        nothing = np.full(len(depth_m), np.nan)
        return nothing, np.zeros(magnitude.shape[1]), np.zeros(magnitude.shape[2])
    over_y, over_x = (_profile(np.mean(logarithm, axis=axes)) for axes in ((0, 2), (0, 1)))
    flat = logarithm - over_y[:, None] - over_x
    return _curve(depth_m, np.mean(flat, axis=(1, 2)), depth_m, law), over_y, over_x


def _profile(mean: np.ndarray) -> np.ndarray:
    """Return a smooth symmetric curve through values over an axis, less its mean."""
    if len(mean) < 5:
        return np.zeros(len(mean))
    place = np.linspace(-1.0, 1.0, len(mean))
    basis = np.stack([np.ones(len(mean)), place**2, place**8], axis=1)
    curve = basis @ np.linalg.lstsq(basis, mean, rcond=None)[0]
    return curve - np.mean(curve)


def _curve(depth_m: np.ndarray, values: np.ndarray, wanted_m: np.ndarray, law: Law) -> np.ndarray:
    """Return a smooth curve through values over depth, or a constant through few, at depths."""
    degree = min(law.depth_degree, max(0, len(depth_m) // 3 - 1))
    middle, half = np.mean(depth_m), np.ptp(depth_m) / 2.0
    found = np.polynomial.polynomial.polyfit((depth_m - middle) / half, values, degree)
    return np.polynomial.polynomial.polyval((wanted_m - middle) / half, found)


def _likeness(volume: np.ndarray, depth_m: np.ndarray, law: Law) -> Tuple[float, ...]:
    """Return the correlation of adjacent voxels along depth, y and x of noise in its unit."""
    smallest = np.min(np.diff(depth_m)) * 1.01
    pairs = np.flatnonzero(np.diff(depth_m) <= smallest)
    down = (volume[pairs], volume[pairs + 1])
    along_y = (volume[:, :-1], volume[:, 1:])
    along_x = (volume[:, :, :-1], volume[:, :, 1:])
    return tuple(_correlation(one, other, law) for one, other in (down, along_y, along_x))


def _correlation(one: np.ndarray, other: np.ndarray, law: Law) -> float:
    if one.size == 0:
        return 0.0
    if law is Law.RAYLEIGH:
        power = math.sqrt(float(np.sum(np.abs(one) ** 2) * np.sum(np.abs(other) ** 2)))
        return abs(complex(np.vdot(one, other))) / power
    # Logarithms of tails are distributed as the powers of complex noise, whose correlation is the
    # square of that of the noise.
    first, second = (-law.log_tail(np.abs(side)).ravel() - 1.0 for side in (one, other))
    shared = float(np.mean(first * second)) / max(float(np.std(first) * np.std(second)), 1e-12)
    return math.sqrt(min(max(shared, 0.0), 1.0))

"""The echoes in an image: its maxima, the strong ones each without the sidelobes of the others.

This is CLEAN by orthogonal matching pursuit: the strongest maxima are taken as points, whose echoes
are fitted to all traces together and taken away; what is left is imaged again, and so on. A strong
body so takes its own sidelobes with it, as the survey's positions, band and heights cause them.
What is left at the end is the clutter that every maximum is compared with, and its maxima are the
weak echoes. See Pati, Rezaiifar and Krishnaprasad, Orthogonal matching pursuit, 1993, and Tsao and
Steinberg, Reduction of sidelobe and speckle artifacts in microwave imaging: the CLEAN technique,
IEEE Transactions on Antennas and Propagation 36 (4), 1988.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, List, Optional, Sequence

import numpy as np
from scipy.ndimage import maximum_filter, uniform_filter1d

from gpr20_analysis.imaging.phase_shift import unit_phasor
from gpr20_analysis.imaging.records import Focus, Traces, antenna_offset_m, gated_sweep
from gpr20_analysis.processing.sweep import steps_to_top
from gpr20_survey.radar import decibels, one_way_delay_s

Imager = Callable[[Traces], np.ndarray]
"""Returns the image (depth, y, x) of traces."""

# The strongest echoes are fitted as points: at most so many per area, or per longer side.
POINTS_PER_M2, POINTS_PER_M = 70.0, 14.0
ROUNDS = 6
# Fitted in a round: what is that much above clutter, and not much less so than the first.
ABOVE_CLUTTER_DB, BELOW_FIRST_DB = 0.5, 12.0
# Two of one round are apart, across or in depth; one near a much stronger one waits for the next.
APART_M, DEEPER_M = 0.06, 0.05
NEAR_M, STRONGER_DB = 0.4, 10.0
# Extent of the ground that a voxel is compared with: across, and in resolutions of the depth. What
# is left of the surface is stronger than the clutter below, so shallow voxels have less of that.
ACROSS_M, RESOLUTIONS, SHALLOW_RESOLUTIONS = 0.6, 3.0, 1.0
# What is nearer to a body belongs to it: across, and in resolutions of the depth.
BODY_M, BODY_RESOLUTIONS = 0.06, 2.0
# Where bodies leave so little of that ground, the whole plane counts as much.
LEAST_SHARE = 0.1
# Below the largest magnitude, against the logarithm of 0: 140 dB.
SMALLEST_SHARE = 1e-7
EULER = 0.5772156649015329
# Traces that amplitudes are fitted to, evenly taken from all.
MOST_FITTED = 3000


@dataclass(frozen=True)
class Echoes:
    """The maxima of an image of one polarization.

    Attributes:
        place_m: Depth, y and x (echo, 3) [m].
        magnitude: Magnitude in the image.
        clutter: Standard magnitude of what is around it, without other bodies.
        fitted: Whether it is a point that was fitted; the others are in what those left.
    """

    place_m: np.ndarray
    magnitude: np.ndarray
    clutter: np.ndarray
    fitted: np.ndarray


def find_echoes(
    volume: np.ndarray,
    axes_m: Sequence[np.ndarray],
    resolution_m: float,
    points: PointEchoes,
    imager: Imager,
) -> Echoes:
    """Return the echoes in an image.

    Args:
        volume: The image (depth, y, x), complex.
        axes_m: Depths, positions along Y, positions along X [m].
        resolution_m: Resolution of the depth [m].
        points: Fits points to its traces.
        imager: Makes an image like this one of other traces.
    """
    place_m, strength = np.zeros((0, 3)), np.zeros(0)
    down_m, across_m = (float(np.ptp(axis_m)) for axis_m in axes_m[1:])
    of_line = POINTS_PER_M * max(down_m, across_m)
    most = max(1, int(np.ceil(max(of_line, POINTS_PER_M2 * down_m * across_m))))
    rest = volume
    for _ in range(ROUNDS):
        left = np.abs(rest)
        clutter = local_clutter(left, axes_m, resolution_m, place_m)
        found = _strongest(left, clutter, axes_m, min(most - len(place_m), -(-most // 3)))
        if len(found) == 0:
            break
        place_m = np.concatenate([place_m, between_voxels_m(left, axes_m, found)])
        # What is left may be more than the image shows, but nothing is brighter than its brightest.
        shown = np.minimum(left, np.abs(volume))[tuple(found.T)]
        strength = np.concatenate([strength, shown])
        points.add(place_m[-len(found) :])
        rest = imager(points.left())
    left = np.abs(rest)
    clutter = local_clutter(left, axes_m, resolution_m, place_m)
    weak = _maxima(left)
    nearest = [
        np.argmin(np.abs(axis_m[None, :] - one[:, None]), axis=1)
        for axis_m, one in zip(axes_m, place_m.T)
    ]
    return Echoes(
        np.concatenate([place_m, between_voxels_m(left, axes_m, weak)]),
        np.concatenate([strength, left[tuple(weak.T)]]),
        np.concatenate([clutter[tuple(nearest)], clutter[tuple(weak.T)]]),
        np.arange(len(place_m) + len(weak)) < len(place_m),
    )


def _maxima(magnitude: np.ndarray) -> np.ndarray:
    """Return the indices of the local maxima (maximum, 3)."""
    highest = maximum_filter(magnitude, size=3, mode="nearest")
    return np.argwhere((magnitude == highest) & (magnitude > 0.0))


def _strongest(
    magnitude: np.ndarray, clutter: np.ndarray, axes_m: Sequence[np.ndarray], most: int
) -> np.ndarray:
    """Return the indices of the maxima to fit next (maximum, 3), the strongest first."""
    index = _maxima(magnitude)
    at = tuple(index.T)
    above_db = decibels(magnitude[at] / clutter[at], 0.0)
    index = index[above_db > ABOVE_CLUTTER_DB]
    above_db = above_db[above_db > ABOVE_CLUTTER_DB]
    order = np.argsort(-above_db, kind="stable")
    index, above_db = index[order], above_db[order]
    level_db = decibels(magnitude[tuple(index.T)], 0.0)
    place_m = np.stack([axis_m[one] for axis_m, one in zip(axes_m, index.T)], axis=1)
    chosen: List[int] = []
    for one in range(len(index)):
        if len(chosen) >= most or (chosen and above_db[one] < above_db[chosen[0]] - BELOW_FIRST_DB):
            break
        away_m = np.hypot(*(place_m[:, 1:] - place_m[one, 1:]).T)
        deeper_m = np.abs(place_m[:, 0] - place_m[one, 0])
        if np.any((away_m < NEAR_M) & (level_db > level_db[one] + STRONGER_DB)):
            continue
        if np.all((away_m[chosen] >= APART_M) | (deeper_m[chosen] >= DEEPER_M)):
            chosen.append(one)
    found: np.ndarray = index[chosen]
    return found


def between_voxels_m(
    volume: np.ndarray, axes_m: Sequence[np.ndarray], places: np.ndarray
) -> np.ndarray:
    """Return depth, y and x of local maxima between the voxels (maximum, 3) [m].

    Each is the maximum of a parabola through the logarithms of three voxels.

    Args:
        volume: Magnitudes (depth, y, x).
        axes_m: Depths, positions along Y, positions along X [m].
        places: Indices of the maxima (maximum, 3).
    """
    found_m = np.stack([axis[index] for axis, index in zip(axes_m, places.T)], axis=1)
    for number, axis in enumerate(axes_m):
        step = np.eye(3, dtype=int)[number]
        inner = np.flatnonzero((places[:, number] > 0) & (places[:, number] < len(axis) - 1))
        beside = np.stack([volume[tuple((places[inner] + one * step).T)] for one in (-1, 0, 1)], 1)
        bright = np.all(beside > 0.0, axis=1)
        inner, level = inner[bright], np.log(beside[bright])
        at = places[inner, number] + steps_to_top(level, np.ones(len(level), dtype=int))
        found_m[inner, number] = np.interp(at, np.arange(len(axis)), axis)
    return found_m


class PointEchoes:
    """Fits points to traces, and takes them away.

    Every point has the delays of the refracted paths, spreads with the square of the delay, and
    has lost its mean over all positions, as a survey has with its background.

    Args:
        traces: The traces.
        focus: How the image is focused.
        longest_s: Longest delay that counts [s]; the spectra become as coarse as that allows.
    """

    def __init__(self, traces: Traces, focus: Focus, longest_s: float) -> None:
        sweep, gate = gated_sweep(traces.sweep, longest_s)
        flat = traces.s21.reshape(-1, traces.sweep.count)
        self._present = np.flatnonzero(np.any(flat != 0.0, axis=1))
        self._spectra = flat @ gate.astype(np.complex64)
        self._traces = replace(traces, sweep=sweep)
        self._weights = focus.window.weights(sweep.count).astype(np.float32)
        y_m, x_m = np.meshgrid(traces.y_m, traces.x_m, indexing="ij")
        self._y_m, self._x_m = y_m.ravel(), x_m.ravel()
        offset_m = antenna_offset_m(traces, focus)
        self._offsets_m = (offset_m, (-offset_m[0], -offset_m[1])) if any(offset_m) else (offset_m,)
        self._permittivity = focus.permittivity
        self._height_m = float(np.mean(traces.height_m))
        step = -(-len(self._present) // MOST_FITTED)
        self._fitted = self._present[::step]
        self._atoms = np.zeros((0, self._fitted.size * sweep.count), np.complex64)
        self._places_m = np.zeros((0, 3))

    def add(self, places_m: np.ndarray) -> None:
        """Add points (point, 3): depth, y, x [m]."""
        atoms = [self._spectrum(place_m, self._fitted) * self._weights for place_m in places_m]
        flat = np.stack(atoms).reshape(len(atoms), -1).astype(np.complex64)
        self._atoms = np.concatenate([self._atoms, flat])
        self._places_m = np.concatenate([self._places_m, places_m])

    def left(self) -> Traces:
        """Return the traces without all points, whose amplitudes fit them best."""
        measured = (self._spectra[self._fitted] * self._weights).ravel()
        products = self._atoms.conj() @ self._atoms.T
        amplitudes = np.linalg.lstsq(products, self._atoms.conj() @ measured, rcond=1e-6)[0]
        left = self._spectra.copy()
        for place_m, amplitude in zip(self._places_m, amplitudes):
            echo = self._spectrum(place_m, self._present) * np.complex64(amplitude)
            left[self._present] = left[self._present] - echo
        traces = self._traces
        shape = (*traces.height_m.shape, traces.sweep.count)
        return replace(traces, s21=left.reshape(shape).astype(np.complex64))

    def _spectrum(self, place_m: Sequence[float], which: np.ndarray) -> np.ndarray:
        """Return the spectra (trace, frequency) of a point at some traces."""
        depth_m, y_m, x_m = place_m
        one_way_s = [
            one_way_delay_s(
                self._traces.height_m.ravel()[which],
                depth_m,
                np.hypot(
                    self._x_m[which] + offset_m[0] - x_m, self._y_m[which] + offset_m[1] - y_m
                ),
                self._permittivity,
            )
            for offset_m in self._offsets_m
        ]
        delay_s = 2.0 * np.mean(one_way_s, axis=0)
        # The same for all traces and for those that are fitted.
        straight_s = 2.0 * one_way_delay_s(self._height_m, depth_m, 0.0, self._permittivity)
        level = ((straight_s / delay_s) ** 2).astype(np.float32)
        phase_rad = -2.0 * np.pi * delay_s[:, None] * self._traces.sweep.frequency_hz
        spectra = level[:, None] * unit_phasor(phase_rad)
        spectra -= spectra.mean(axis=0)
        return spectra


def local_clutter(
    magnitude: np.ndarray,
    axes_m: Sequence[np.ndarray],
    resolution_m: float,
    bodies_m: Optional[np.ndarray] = None,
) -> np.ndarray:
    """Return the standard magnitude of what is around each voxel (depth, y, x).

    It is the root mean square of complex noise with the same geometric mean, which a few strong
    voxels hardly move.

    Args:
        magnitude: Magnitudes (depth, y, x).
        axes_m: Depths, positions along Y, positions along X [m].
        resolution_m: Resolution of the depth [m].
        bodies_m: Depth, y and x of bodies (body, 3) [m], whose surroundings are left out.
    """
    largest = float(magnitude.max(initial=0.0))
    if largest == 0.0:
        return np.ones(magnitude.shape)
    level = np.log(np.maximum(magnitude, largest * SMALLEST_SHARE))
    counted = np.ones(magnitude.shape)
    for depth_m, y_m, x_m in [] if bodies_m is None else bodies_m:
        away_m = np.hypot(axes_m[1][:, None] - y_m, axes_m[2][None, :] - x_m)
        deep = np.abs(axes_m[0] - depth_m) < BODY_RESOLUTIONS * resolution_m
        counted[deep] *= away_m >= BODY_M
    every, shallow = axes_m[0] == axes_m[0], axes_m[0] < resolution_m
    local = _local_mean(level, counted, axes_m, RESOLUTIONS * resolution_m, every)
    thin_m = SHALLOW_RESOLUTIONS * resolution_m
    local[shallow] = _local_mean(level, counted, axes_m, thin_m, shallow)
    found: np.ndarray = np.exp(local + EULER / 2.0)
    return found


def _local_mean(
    level: np.ndarray,
    counted: np.ndarray,
    axes_m: Sequence[np.ndarray],
    deep_m: float,
    wanted: np.ndarray,
) -> np.ndarray:
    """Return the mean level around the voxels of the wanted depths."""
    both = level * counted, counted
    of_plane, share = (_smoothed(one.mean(axis=(1, 2)), axes_m[0], 0, 2.0 * deep_m) for one in both)
    usual = (of_plane + 1e-9 * level.mean()) / (share + 1e-9)
    sums, shares = (_smoothed(one, axes_m[0], 0, deep_m)[wanted] for one in both)
    for number in (1, 2):
        sums, shares = (_smoothed(one, axes_m[number], number, ACROSS_M) for one in (sums, shares))
    local: np.ndarray = (sums + LEAST_SHARE * usual[wanted, None, None]) / (shares + LEAST_SHARE)
    return local


def _smoothed(values: np.ndarray, axis_m: np.ndarray, number: int, width_m: float) -> np.ndarray:
    """Return running means along an axis, which is mirrored at its ends."""
    count = len(axis_m)
    if count == 1:
        return values
    width = round(width_m / float(np.ptp(axis_m)) * (count - 1)) | 1
    smoothed: np.ndarray = uniform_filter1d(
        values, min(width, 2 * count - 1), axis=number, mode="reflect"
    )
    return smoothed

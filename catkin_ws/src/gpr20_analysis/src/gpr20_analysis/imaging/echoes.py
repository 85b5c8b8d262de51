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

from dataclasses import dataclass
from typing import Callable, List, Sequence

import numpy as np
from scipy.ndimage import maximum_filter

from gpr20_analysis.imaging.clutter import local_clutter
from gpr20_analysis.imaging.point_echoes import PointEchoes
from gpr20_analysis.imaging.records import Traces
from gpr20_survey.radar.frequency_to_delay import decibels

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
    most = most_points(axes_m)
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
    return _with_weak(rest, axes_m, resolution_m, place_m, strength)


def maxima_only(magnitude: np.ndarray, axes_m: Sequence[np.ndarray], resolution_m: float) -> Echoes:
    """Return the echoes in an image whose method is not linear, so that nothing is taken away."""
    return _with_weak(magnitude, axes_m, resolution_m, np.zeros((0, 3)), np.zeros(0))


def most_points(axes_m: Sequence[np.ndarray]) -> int:
    """Return how many points are fitted at most."""
    down_m, across_m = (float(np.ptp(axis_m)) for axis_m in axes_m[1:])
    of_line = POINTS_PER_M * max(down_m, across_m)
    return max(1, int(np.ceil(max(of_line, POINTS_PER_M2 * down_m * across_m))))


def _with_weak(
    rest: np.ndarray,
    axes_m: Sequence[np.ndarray],
    resolution_m: float,
    place_m: np.ndarray,
    strength: np.ndarray,
) -> Echoes:
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
        inner = (places[:, number] > 0) & (places[:, number] < len(axis) - 1)
        step = np.eye(3, dtype=int)[number]
        beside = [volume[tuple((places[inner] + one).T)] for one in (-step, 0, step)]
        bright = np.all(np.stack(beside) > 0.0, axis=0)
        before, top, after = (np.log(one[bright]) for one in beside)
        which = np.flatnonzero(inner)[bright]
        index = places[which, number]
        back_m, on_m = axis[index] - axis[index - 1], axis[index + 1] - axis[index]
        rise, fall = (top - before) / back_m, (after - top) / on_m
        curved = rise != fall
        # The slope is linear between the middles of the two intervals.
        share = rise[curved] / (rise - fall)[curved]
        first_m = axis[index[curved]] - back_m[curved] / 2.0
        found_m[which[curved], number] = first_m + share * (back_m + on_m)[curved] / 2.0
    return found_m

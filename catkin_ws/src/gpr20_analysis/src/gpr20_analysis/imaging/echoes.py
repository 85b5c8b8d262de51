"""Local maxima of an image: where they are, and how wide."""

from __future__ import annotations

import math
from typing import List, Sequence, Tuple

import numpy as np
from scipy.ndimage import maximum_filter


def maxima(
    volume: np.ndarray, axes: Sequence[np.ndarray], threshold: float, nearest_m: float
) -> List[Tuple[int, ...]]:
    """Return the indices of local maxima of a volume (depth, y, x), except at the outer depths.

    Args:
        volume: Magnitudes.
        axes: Depths, positions along Y, positions along X [m].
        threshold: Lower maxima are left out.
        nearest_m: Of maxima closer than half of this only the highest is returned [m].
    """
    size = [
        2 * max(1, round(nearest_m / (2.0 * _step(axis)))) + 1 if len(axis) > 1 else 1
        for axis in axes
    ]
    highest = (volume == maximum_filter(volume, size=size)) & (volume >= threshold)
    highest[[0, -1]] = False
    return [tuple(int(index) for index in place) for place in np.argwhere(highest)]


def peak_places(volume: np.ndarray, axes: Sequence[np.ndarray], places: np.ndarray) -> np.ndarray:
    """Return depth, y and x of local maxima between the voxels (maximum, 3) [m].

    Each is the maximum of a parabola through the logarithms of three voxels.

    Args:
        volume: Magnitudes (depth, y, x).
        axes: Depths, positions along Y, positions along X [m].
        places: Indices of the maxima (maximum, 3).
    """
    found_m = np.stack([axis[index] for axis, index in zip(axes, places.T)], axis=1)
    for number, axis in enumerate(axes):
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


def lines_through(volume: np.ndarray, place: Tuple[int, ...]) -> List[np.ndarray]:
    """Return the three lines of a volume through a voxel, one along each axis."""
    return [
        volume[tuple(slice(None) if other == axis else place[other] for other in range(3))]
        for axis in range(3)
    ]


def half_power_widths(volume: np.ndarray, axes: Sequence[np.ndarray]) -> Tuple[float, ...]:
    """Return the -3 dB widths of the brightest voxel along depth, y and x [m].

    NaN where the image ends before.
    """
    place = tuple(int(one) for one in np.unravel_index(int(np.argmax(volume)), volume.shape))
    lines = lines_through(volume, place)
    return tuple(_half_power_width(*one) for one in zip(lines, axes, place))


def _step(axis: np.ndarray) -> float:
    return float(axis[-1] - axis[0]) / (len(axis) - 1)


def _half_power_width(line: np.ndarray, axis: np.ndarray, index: int) -> float:
    """Return the -3 dB width of a maximum; NaN if the line ends above that level."""
    level = float(line[index]) / math.sqrt(2.0)
    below = np.flatnonzero(line <= level)
    left, right = below[below < index], below[below > index]
    if not left.size or not right.size:
        return math.nan
    ends = [
        np.interp(level, line[[low, high]], axis[[low, high]])
        for low, high in ((left[-1], left[-1] + 1), (right[0], right[0] - 1))
    ]
    return float(ends[1] - ends[0])

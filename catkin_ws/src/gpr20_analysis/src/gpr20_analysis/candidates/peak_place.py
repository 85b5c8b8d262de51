"""The places of local maxima of an image, finer than its voxels."""

from __future__ import annotations

from typing import Sequence

import numpy as np


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

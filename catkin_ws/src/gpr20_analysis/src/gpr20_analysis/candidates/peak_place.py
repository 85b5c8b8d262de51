"""The place of a local maximum of an image, finer than its voxels."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np


def peak_place(
    volume: np.ndarray, axes: Sequence[np.ndarray], place: Tuple[int, ...]
) -> Tuple[float, ...]:
    """Return (depth, y, x) of a local maximum between the voxels [m]."""
    lines = (
        volume[tuple(slice(None) if other == axis else place[other] for other in range(3))]
        for axis in range(3)
    )
    return tuple(_peak(line, axis, index) for line, axis, index in zip(lines, axes, place))


def _peak(line: np.ndarray, axis: np.ndarray, index: int) -> float:
    """Return the maximum of a parabola through the logarithms of three voxels."""
    if index in (0, len(line) - 1) or np.any(line[index - 1 : index + 2] <= 0.0):
        return float(axis[index])
    before, top, after = np.log(line[index - 1 : index + 2])
    back_m, on_m = axis[index] - axis[index - 1], axis[index + 1] - axis[index]
    rise, fall = (top - before) / back_m, (after - top) / on_m
    if rise == fall:
        return float(axis[index])
    # The slope is linear between the middles of the two intervals.
    share = rise / (rise - fall)
    return float(axis[index] - back_m / 2.0 + share * (back_m + on_m) / 2.0)

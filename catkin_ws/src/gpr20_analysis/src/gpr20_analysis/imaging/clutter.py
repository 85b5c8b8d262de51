"""The clutter around each voxel of an image: what the ground shows beside its bodies."""

from __future__ import annotations

from typing import Optional, Sequence

import numpy as np
from scipy.ndimage import uniform_filter1d

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
    local = _local_mean(level, counted, axes_m, RESOLUTIONS * resolution_m)
    shallow = axes_m[0] < resolution_m
    thin = _local_mean(level, counted, axes_m, SHALLOW_RESOLUTIONS * resolution_m)
    local[shallow] = thin[shallow]
    found: np.ndarray = np.exp(local + EULER / 2.0)
    return found


def _local_mean(
    level: np.ndarray, counted: np.ndarray, axes_m: Sequence[np.ndarray], deep_m: float
) -> np.ndarray:
    sums, shares = level * counted, counted
    plane = sums.mean(axis=(1, 2)), shares.mean(axis=(1, 2))
    for number, width_m in enumerate((deep_m, ACROSS_M, ACROSS_M)):
        sums, shares = (_smoothed(one, axes_m[number], number, width_m) for one in (sums, shares))
    of_plane, share = (_smoothed(one, axes_m[0], 0, 2.0 * deep_m) for one in plane)
    usual = (of_plane + 1e-9 * level.mean()) / (share + 1e-9)
    local: np.ndarray = (sums + LEAST_SHARE * usual[:, None, None]) / (shares + LEAST_SHARE)
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

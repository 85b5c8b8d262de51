"""The compiled loops of the back-projection; importing this needs numba.

They run without the interpreter's lock, so that several parts are computed at once in threads.
"""

from __future__ import annotations

import math

import numba
import numpy as np


@numba.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
def _add_together(voxels, samples, delays, steps, more, first):  # type: ignore[no-untyped-def]
    """Add a trace to a column of voxels, the distance given in steps of the table."""
    i = int(steps)
    part = np.float32(steps - i)
    nearer, further = delays[i], delays[i + 1]
    real, imaginary = voxels[0], voxels[1]
    for k in range(first, real.size):
        one_way = nearer[k] + part * (further[k] - nearer[k])
        place = np.float32(2.0) * (one_way + more)
        index = np.int32(place)
        share = place - np.float32(index)
        rest = np.float32(1.0) - share
        real[k] += rest * samples[index, 0] + share * samples[index + 1, 0]
        imaginary[k] += rest * samples[index, 1] + share * samples[index + 1, 1]


@numba.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
def _add_apart(  # type: ignore[no-untyped-def]
    voxels, samples, delays, surface, out, back, more, lower_m, first
):
    """The same for two antennas at different distances, and for uneven ground.

    The surface is lower by `lower_m` below the antennas than at the voxels.
    """
    i, j = int(out), int(back)
    out_part, back_part = np.float32(out - i), np.float32(back - j)
    real, imaginary = voxels[0], voxels[1]
    for k in range(first, real.size):
        place = np.float32(2.0) * more
        place += delays[i, k] + out_part * (delays[i + 1, k] - delays[i, k])
        place += delays[j, k] + back_part * (delays[j + 1, k] - delays[j, k])
        place += lower_m * (surface[i, k] + surface[j, k])
        index = np.int32(place)
        share = place - np.float32(index)
        rest = np.float32(1.0) - share
        real[k] += rest * samples[index, 0] + share * samples[index + 1, 0]
        imaginary[k] += rest * samples[index, 1] + share * samples[index + 1, 1]


@numba.njit(cache=True, fastmath=True, nogil=True)
def project_columns(  # type: ignore[no-untyped-def]
    samples, place_m, side_m, height_m, level, more, table, surface, step_m, reach, depth_m,
    uneven, x_m, y_m, column_m, column_level, column_more,
):  # fmt: skip
    """Return adjacent columns of one row of the image (x, 2: real and imaginary, depth), float32.

    Args:
        samples: Analytic A-scans (trace, delay, 2: real and imaginary part), float32.
        place_m: Middle of the antennas (trace, 2: x, y) [m].
        side_m: From the middle to the transmitter (2) [m]; the receiver is opposite.
        height_m: Height of the antennas above the surface below them (trace) [m].
        level: Index of the table's height nearest to each trace's.
        more: Remaining one-way delay of its own height, in samples, float32.
        table: One-way delays in samples (height, distance, depth), float32.
        surface: Delay added per metre that the surface below the antennas is lower than at the
            voxel, in samples (distance, depth), float32; 0 on level ground.
        step_m: Step of the table's distances [m].
        reach: Horizontal reach of the widest ray per height and per depth.
        depth_m: Depths [m].
        uneven: Whether the ground is uneven; level ground does not use the last three.
        x_m: Positions of the columns along X [m].
        y_m: Their position along Y [m].
        column_m: Height of the antennas' plane above the surface at each position [m].
        column_level: Index of the table's height nearest to it.
        column_more: Remaining one-way delay, in samples, float32.
    """
    image = np.zeros((x_m.size, 2, depth_m.size), dtype=np.float32)
    together = side_m[0] == 0.0 and side_m[1] == 0.0 and not uneven
    for trace in range(samples.shape[0]):
        dy = y_m - place_m[trace, 1]
        nearest_m = height_m[trace] * reach[0]
        if abs(dy) > nearest_m + depth_m[-1] * reach[1]:
            continue
        for column in range(x_m.size):
            dx = x_m[column] - place_m[trace, 0]
            distance_m = math.hypot(dx, dy)
            first = np.searchsorted(depth_m, (distance_m - nearest_m) / reach[1])
            if first == depth_m.size:
                continue
            voxels = image[column]
            if together:
                delays = table[level[trace]]
                steps = distance_m / step_m
                _add_together(voxels, samples[trace], delays, steps, more[trace], first)
                continue
            out = math.hypot(dx - side_m[0], dy - side_m[1]) / step_m
            back = math.hypot(dx + side_m[0], dy + side_m[1]) / step_m
            own, rest, lower_m = level[trace], more[trace], np.float32(0.0)
            if uneven:
                own, rest = column_level[column], column_more[column]
                lower_m = np.float32(height_m[trace] - column_m[column])
            _add_apart(voxels, samples[trace], table[own], surface, out, back, rest, lower_m, first)
    return image

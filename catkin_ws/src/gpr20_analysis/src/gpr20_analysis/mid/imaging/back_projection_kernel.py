"""The compiled loops of the back-projection; importing this needs numba."""

from __future__ import annotations

import math

import numba
import numpy as np


@numba.njit(cache=True, fastmath=True)
def _add_together(column, samples, delays, steps, more, first):  # type: ignore[no-untyped-def]
    """Add a trace to a column of voxels, the distance given in steps of the table."""
    i = int(steps)
    part = np.float32(steps - i)
    for k in range(first, column.size):
        one_way = delays[i, k] + part * (delays[i + 1, k] - delays[i, k])
        place = np.float32(2.0) * (one_way + more)
        index = int(place)
        share = place - np.float32(index)
        column[k] += samples[index] + share * (samples[index + 1] - samples[index])


@numba.njit(cache=True, fastmath=True)
def _add_apart(column, samples, delays, out, back, more, first):  # type: ignore[no-untyped-def]
    """The same for two antennas at different distances."""
    i, j = int(out), int(back)
    out_part, back_part = np.float32(out - i), np.float32(back - j)
    for k in range(first, column.size):
        place = np.float32(2.0) * more
        place += delays[i, k] + out_part * (delays[i + 1, k] - delays[i, k])
        place += delays[j, k] + back_part * (delays[j + 1, k] - delays[j, k])
        index = int(place)
        share = place - np.float32(index)
        column[k] += samples[index] + share * (samples[index + 1] - samples[index])


@numba.njit(cache=True, fastmath=True, parallel=True)
def project(  # type: ignore[no-untyped-def]
    samples, place_m, side_m, level, more, table, step_m, x_m, y_m, reach_m
):
    """Return the image (y, x, depth).

    Args:
        samples: Analytic A-scans (trace, delay), complex64.
        place_m: Middle of the antennas (trace, 2: x, y) [m].
        side_m: From the middle to the transmitter (2) [m]; the receiver stands opposite.
        level: Index of the table's height nearest to each trace's.
        more: What its own height adds to the one-way delay, in samples, float32.
        table: One-way delays in samples (height, distance, depth), float32.
        step_m: Step of the table's distances [m].
        x_m: Positions of the image along X [m].
        y_m: The same along Y.
        reach_m: Largest distance that is taken (trace, depth) [m], ascending with depth.
    """
    image = np.zeros((y_m.size, x_m.size, table.shape[2]), dtype=np.complex64)
    together = side_m[0] == 0.0 and side_m[1] == 0.0
    for row in numba.prange(y_m.size):
        for trace in range(samples.shape[0]):
            delays = table[level[trace]]
            for column in range(x_m.size):
                dx = x_m[column] - place_m[trace, 0]
                dy = y_m[row] - place_m[trace, 1]
                distance_m = math.hypot(dx, dy)
                first = np.searchsorted(reach_m[trace], distance_m)
                if first == table.shape[2]:
                    continue
                voxels = image[row, column]
                if together:
                    steps = distance_m / step_m
                    _add_together(voxels, samples[trace], delays, steps, more[trace], first)
                else:
                    out = math.hypot(dx - side_m[0], dy - side_m[1]) / step_m
                    back = math.hypot(dx + side_m[0], dy + side_m[1]) / step_m
                    _add_apart(voxels, samples[trace], delays, out, back, more[trace], first)
    return image

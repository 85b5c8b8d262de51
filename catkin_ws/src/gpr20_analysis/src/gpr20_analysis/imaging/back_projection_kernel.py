"""The compiled loops of the back-projection; importing this needs numba.

Real and imaginary parts and their differences to the next sample are in separate arrays, so that
the compiler can process several voxels at once: twice as fast as with complex numbers.
"""

from __future__ import annotations

import math

import numba
import numpy as np


@numba.njit(cache=True, fastmath=True, error_model="numpy")
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
        real[k] += samples[0, index] + share * samples[2, index]
        imaginary[k] += samples[1, index] + share * samples[3, index]


@numba.njit(cache=True, fastmath=True, error_model="numpy")
def _add_apart(voxels, samples, delays, out, back, more, first):  # type: ignore[no-untyped-def]
    """The same for two antennas at different distances."""
    i, j = int(out), int(back)
    out_part, back_part = np.float32(out - i), np.float32(back - j)
    real, imaginary = voxels[0], voxels[1]
    for k in range(first, real.size):
        place = np.float32(2.0) * more
        place += delays[i, k] + out_part * (delays[i + 1, k] - delays[i, k])
        place += delays[j, k] + back_part * (delays[j + 1, k] - delays[j, k])
        index = np.int32(place)
        share = place - np.float32(index)
        real[k] += samples[0, index] + share * samples[2, index]
        imaginary[k] += samples[1, index] + share * samples[3, index]


@numba.njit(cache=True, fastmath=True, error_model="numpy")
def _add_over_uneven(  # type: ignore[no-untyped-def]
    voxels, samples, delays, surface, out, back, more, lower_m, first
):
    """The same where the surface is lower below the antennas than at the voxels."""
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
        real[k] += samples[0, index] + share * samples[2, index]
        imaginary[k] += samples[1, index] + share * samples[3, index]


@numba.njit(cache=True, fastmath=True, parallel=True)
def project_uneven(  # type: ignore[no-untyped-def]
    samples, place_m, side_m, height_m, column_m, level, more, table, surface, step_m, x_m, y_m,
    reach_m,
):  # fmt: skip
    """Return the image of uneven ground (y, x, 2: real and imaginary, depth), float32.

    Args:
        samples: As for `project`, and likewise all that is not described here.
        place_m: Middle of the antennas (trace, 2: x, y) [m].
        side_m: From the middle to the transmitter (2) [m].
        height_m: Height of the antennas above the surface below them (trace) [m], float32.
        column_m: The same above each column of the image (y, x) [m], float32.
        level: Index of the table's height nearest to each column's (y, x).
        more: Remaining one-way delay of its own height, in samples (y, x), float32.
        table: One-way delays in samples (height, distance, depth), float32.
        surface: Delay added per metre that the surface below the antennas is lower than at the
            voxel, in samples (distance, depth), float32.
        step_m: Step of the table's distances [m].
        x_m: Positions of the image along X [m].
        y_m: The same along Y.
        reach_m: Largest distance that is used (trace, depth) [m], ascending with depth.
    """
    image = np.zeros((y_m.size, x_m.size, 2, table.shape[2]), dtype=np.float32)
    for row in numba.prange(y_m.size):
        for trace in range(samples.shape[0]):
            for column in range(x_m.size):
                dx = x_m[column] - place_m[trace, 0]
                dy = y_m[row] - place_m[trace, 1]
                first = np.searchsorted(reach_m[trace], math.hypot(dx, dy))
                if first == table.shape[2]:
                    continue
                out = math.hypot(dx - side_m[0], dy - side_m[1]) / step_m
                back = math.hypot(dx + side_m[0], dy + side_m[1]) / step_m
                lower_m = height_m[trace] - column_m[row, column]
                _add_over_uneven(
                    image[row, column], samples[trace], table[level[row, column]], surface,
                    out, back, more[row, column], lower_m, first,
                )  # fmt: skip
    return image


@numba.njit(cache=True, fastmath=True, parallel=True)
def project(  # type: ignore[no-untyped-def]
    samples, place_m, side_m, level, more, table, step_m, x_m, y_m, reach_m
):
    """Return the image (y, x, 2: real and imaginary, depth), float32.

    Args:
        samples: Analytic A-scans (trace, 4, delay), float32: real and imaginary part, and their
            differences to the next sample.
        place_m: Middle of the antennas (trace, 2: x, y) [m].
        side_m: From the middle to the transmitter (2) [m]; the receiver is opposite.
        level: Index of the table's height nearest to each trace's.
        more: Remaining one-way delay of its own height, in samples, float32.
        table: One-way delays in samples (height, distance, depth), float32.
        step_m: Step of the table's distances [m].
        x_m: Positions of the image along X [m].
        y_m: The same along Y.
        reach_m: Largest distance that is used (trace, depth) [m], ascending with depth.
    """
    image = np.zeros((y_m.size, x_m.size, 2, table.shape[2]), dtype=np.float32)
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

"""The compiled loops of the back-projection on a regular grid; importing this needs numba.

They run without the interpreter's lock, so that several depths are computed at once in threads.
"""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
def _interpolate(values, earlier, later, share):  # type: ignore[no-untyped-def]
    """Store what all traces hold between two samples of their delay."""
    for place in range(values.size):
        values[place] = earlier[place] + share * (later[place] - earlier[place])


@numba.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
def _interpolate_each(  # type: ignore[no-untyped-def]
    values, samples, heights, delays, level, more, least_m
):
    """Store what each trace holds at the delay that belongs to its own height."""
    # Indices that cannot be negative are faster.
    step = np.uint64(samples.shape[2])
    real, imaginary = samples[0].ravel(), samples[1].ravel()
    for trace in range(values.shape[1]):
        place = delays[level[trace]] + np.float32(2.0) * more[trace]
        index = np.int32(place)
        part = place - np.float32(index)
        weight = np.float32(heights[trace] >= least_m)
        earlier, later = weight - weight * part, weight * part
        here = np.uint64(index) * step + np.uint64(trace)
        values[0, trace] = earlier * real[here] + later * real[here + step]
        values[1, trace] = earlier * imaginary[here] + later * imaginary[here + step]


@numba.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
def _add(sums, values):  # type: ignore[no-untyped-def]
    for place in range(sums.size):
        sums[place] += values[place]


@numba.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
def _add_moved(image, values, first, offset):  # type: ignore[no-untyped-def]
    """Add to each column of the image the trace that lies at an offset from it."""
    down, right = first[0] + offset[0], first[1] + offset[1]
    top, bottom = max(0, -down), min(image.shape[1], values.shape[1] - down)
    left, end = max(0, -right), min(image.shape[2], values.shape[2] - right)
    if end <= left:
        return
    for row in range(top, bottom):
        for part in range(2):
            _add(
                image[part, row, left:end],
                values[part, row + down, left + right : end + right],
            )


@numba.njit(cache=True, fastmath=True, error_model="numpy", nogil=True)
def project_depth(  # type: ignore[no-untyped-def]
    samples, height_m, level, more, table, in_air, in_soil_m, first, size, paths, offsets, ends
):
    """Return the image of one depth (2: real and imaginary, y, x), float32.

    Args:
        samples: Analytic A-scans (2: real and imaginary, delay, y, x), float32.
        height_m: Height of the antennas at each trace (y, x) [m].
        level: Index of the table's height nearest to each trace's (y, x).
        more: Remaining one-way delay of its own height, in samples (y, x), float32.
        table: One-way delays at this depth in samples (distance, height), float32.
        in_air: Horizontal reach of the widest ray per height.
        in_soil_m: Its reach in the soil down to this depth [m].
        first: Row and column of the traces at which the image begins.
        size: Rows and columns of the image.
        paths: Distance from the middle of the antennas [m], then from either antenna in steps of
            the table (path, 3); the distances ascend.
        offsets: Rows and columns from a column of the image to the traces of each path.
        ends: End of each path's offsets.
    """
    image = np.zeros((2, size[0], size[1]), dtype=np.float32)
    values = np.empty((2, *samples.shape[2:]), dtype=np.float32)
    flat = samples.reshape(2, samples.shape[1], -1)
    flat_values = values.reshape(2, -1)
    heights, levels, mores = height_m.ravel(), level.ravel(), more.ravel()
    lowest_m, highest_m = heights.min(), heights.max()
    delays = np.empty(table.shape[1], dtype=np.float32)
    begin = 0
    for path in range(ends.size):
        least_m = (paths[path, 0] - in_soil_m) / in_air
        if least_m > highest_m:
            break
        i, j = int(paths[path, 1]), int(paths[path, 2])
        i_part, j_part = np.float32(paths[path, 1] - i), np.float32(paths[path, 2] - j)
        for one in range(delays.size):
            delays[one] = table[i, one] + i_part * (table[i + 1, one] - table[i, one])
            delays[one] += table[j, one] + j_part * (table[j + 1, one] - table[j, one])
        if lowest_m == highest_m:
            place = delays[0] + np.float32(2.0) * mores[0]
            index = int(place)
            share = place - np.float32(index)
            for part in range(2):
                _interpolate(flat_values[part], flat[part, index], flat[part, index + 1], share)
        else:
            _interpolate_each(flat_values, flat, heights, delays, levels, mores, least_m)
        for one in range(begin, ends[path]):
            _add_moved(image, values, first, offsets[one])
        begin = ends[path]
    return image

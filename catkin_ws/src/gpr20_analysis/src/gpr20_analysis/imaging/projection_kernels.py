"""The compiled loops of the back-projection; importing this needs numba.

They run without the interpreter's lock, so that several parts are computed at once in threads. Real
and imaginary parts are in separate arrays, so that the compiler can process several voxels at once.
"""

from __future__ import annotations

import math

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
        real[k] += rest * samples[0, index] + share * samples[0, index + 1]
        imaginary[k] += rest * samples[1, index] + share * samples[1, index + 1]


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
        real[k] += rest * samples[0, index] + share * samples[0, index + 1]
        imaginary[k] += rest * samples[1, index] + share * samples[1, index + 1]


@numba.njit(cache=True, fastmath=True, nogil=True)
def project_columns(  # type: ignore[no-untyped-def]
    samples, place_m, side_m, height_m, level, more, table, surface, step_m, reach, depth_m,
    uneven, x_m, y_m, column_m, column_level, column_more,
):  # fmt: skip
    """Return adjacent columns of one row of the image (x, 2: real and imaginary, depth), float32.

    Args:
        samples: Analytic A-scans (trace, 2: real and imaginary part, delay), float32.
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

"""Back-projection with the exact refracted delay of every pair of trace and voxel.

Each voxel is the sum of all traces, each at the delay of the path to the voxel. Positions and
heights may be irregular, and the two antennas may be separated. It needs numba.
"""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np
from scipy.constants import speed_of_light

from gpr20_analysis import cluster
from gpr20_analysis.cluster import slices
from gpr20_analysis.errors import MissingLibraryError, WrongDatasetError, library_missing
from gpr20_analysis.imaging.a_scans import gated_a_scans
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.imaging.refraction import DelayTable, tabulate_delays
from gpr20_common.message import Message


def back_projection_image(
    traces: Traces,
    focus: Focus,
    x_m: Optional[np.ndarray] = None,
    y_m: Optional[np.ndarray] = None,
) -> np.ndarray:
    """Return the complex image (depth, y, x).

    Args:
        traces: The traces; those of only zeros are skipped.
        focus: How to focus.
        x_m: Positions of the image along X [m]; default those of the traces.
        y_m: The same along Y.

    Raises:
        MissingLibraryError: numba is not installed.
        WrongDatasetError: All traces are zero.
    """
    _kernel(focus.ground)
    x_m = traces.x_m if x_m is None else np.asarray(x_m, dtype=np.float64)
    y_m = traces.y_m if y_m is None else np.asarray(y_m, dtype=np.float64)
    place_m, spectra, height_m = _scattered(traces)
    apart_m = focus.separation_m / 2.0
    turn = np.radians(traces.rotation_deg)
    side_m = apart_m * np.array([np.cos(turn), np.sin(turn)])
    spread_m = [
        max(np.max(axis_m) - np.min(place), np.max(place) - np.min(axis_m))
        for axis_m, place in ((x_m, place_m[:, 0]), (y_m, place_m[:, 1]))
    ]
    table = tabulate_delays(
        height_m, focus.depth_m, float(np.hypot(*spread_m)) + apart_m, focus.permittivity
    )
    lower_s = float(np.ptp(height_m) * np.abs(table.surface_s_per_m).max())
    longest_s = 2.0 * (float(table.delay_s.max()) + lower_s)
    samples, sample_s = gated_a_scans(spectra, traces.sweep, focus.window, longest_s)
    delays = (table.delay_s / sample_s).astype(np.float32)
    held = (_parts_and_rises(samples), place_m, side_m)
    reaches_m = _reaches_m(height_m, focus)
    # Arguments for all slabs of rows, and arguments of each slab.
    shared: Tuple[Any, ...]
    if focus.ground is Ground.LEVEL:
        levels = _levels(table, height_m, sample_s)
        shared = (*held, *levels, delays, table.distance_step_m, x_m, reaches_m)
        own: Tuple[np.ndarray, ...] = (y_m,)
        function = _level_slab
    else:
        column_m = _heights_at(traces, x_m, y_m)
        surface = (table.surface_s_per_m / sample_s).astype(np.float32)
        above = (height_m.astype(np.float32), delays, surface)
        shared = (*held, *above, table.distance_step_m, x_m, reaches_m)
        own = (y_m, column_m.astype(np.float32), *_levels(table, column_m, sample_s))
        function = _uneven_slab
    slabs = [tuple(one[rows] for one in own) for rows in slices(len(y_m), cluster.parts())]
    parts = cluster.distribute(function, shared, slabs)
    image = np.concatenate([part[:, :, 0] + 1j * part[:, :, 1] for part in parts])
    return np.moveaxis(image, 2, 0) / np.float32(traces.height_m.size)


def _level_slab(shared: Tuple[Any, ...], slab: Tuple[Any, ...]) -> np.ndarray:
    *first, step_m, x_m, reaches_m = shared
    found: np.ndarray = _kernel(Ground.LEVEL)(*first, step_m, x_m, *slab, reaches_m)
    return found


def _uneven_slab(shared: Tuple[Any, ...], slab: Tuple[Any, ...]) -> np.ndarray:
    *held, height_m, delays, surface, step_m, x_m, reaches_m = shared
    y_m, *column = slab
    found: np.ndarray = _kernel(Ground.UNEVEN)(
        *held, height_m, *column, delays, surface, step_m, x_m, y_m, reaches_m
    )
    return found


def _kernel(ground: Ground):  # type: ignore[no-untyped-def]
    try:
        from gpr20_analysis.imaging.back_projection_kernel import project, project_uneven
    except ImportError as error:
        raise MissingLibraryError(
            Message(
                "{reason}; --method phase-shift works without it",
                reason=library_missing("numba", "compiled"),
            )
        ) from error
    return project if ground is Ground.LEVEL else project_uneven


def _scattered(traces: Traces) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions (trace, 2), spectra (trace, frequency) and heights of non-zero traces."""
    grid_y, grid_x = np.meshgrid(traces.y_m, traces.x_m, indexing="ij")
    spectra = traces.s21.reshape(-1, traces.sweep.count)
    held = np.any(spectra != 0.0, axis=1)
    if not np.any(held):
        raise WrongDatasetError(
            Message("every trace is zero or was left out, so there is nothing to image")
        )
    place_m = np.stack([grid_x.ravel(), grid_y.ravel()], axis=1)
    return place_m[held], spectra[held], traces.height_m.ravel()[held]


def _parts_and_rises(samples: np.ndarray) -> np.ndarray:
    """Return real and imaginary parts, and differences to the next sample, (trace, 4, delay)."""
    here, rise = samples[:, :-1], np.diff(samples, axis=1)
    return np.stack([here.real, here.imag, rise.real, rise.imag], axis=1)


def _levels(
    table: DelayTable, height_m: np.ndarray, sample_s: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Return the index of the nearest height in the table, and the remaining delay in samples."""
    level = np.rint((height_m - table.lowest_m) / table.height_step_m).astype(np.int64)
    more_m = height_m - table.lowest_m - table.height_step_m * level
    return level, (more_m / speed_of_light / sample_s).astype(np.float32)


def _heights_at(traces: Traces, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
    """Return the height of the antennas' plane above the surface at each place (y, x) [m]."""
    along_x = [np.interp(x_m, traces.x_m, row) for row in traces.height_m]
    along_y = [np.interp(y_m, traces.y_m, column) for column in np.transpose(along_x)]
    return np.transpose(along_y)


def _reaches_m(height_m: np.ndarray, focus: Focus) -> np.ndarray:
    """Return the horizontal reach of the widest ray [m], (trace, depth)."""
    sine = np.sin(np.radians(focus.widest_angle_deg))
    in_air = sine / np.sqrt(max(1.0 - sine**2, 1e-6))
    in_soil = sine / np.sqrt(max(focus.permittivity - sine**2, 1e-6))
    return height_m[:, None] * in_air + focus.depth_m[None, :] * in_soil

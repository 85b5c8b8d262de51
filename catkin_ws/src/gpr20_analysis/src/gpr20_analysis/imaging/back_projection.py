"""Back-projection with the exact refracted delay of every pair of trace and voxel.

Each voxel is the sum of all traces, each at the delay of the path to the voxel. Positions and
heights may be irregular, and the two antennas may be separated. The delays between antennas in air
and points in the soil are in a table. It needs numba.
"""

from __future__ import annotations

import math
from typing import Any, Tuple

import numpy as np

from gpr20_analysis.errors import MissingLibraryError, library_missing
from gpr20_analysis.imaging.records import (
    Focus,
    Ground,
    Traces,
    antenna_offset_m,
    gated_a_scans,
    reach,
)
from gpr20_analysis.work import Progress, no_progress, on_threads
from gpr20_common.message import Message
from gpr20_survey.radar import SPEED_OF_LIGHT_M_S, one_way_delay_s, tangent_in_air

# The error of linear interpolation over the distance is less than step^2 / 8 times the second
# derivative of the delay: 0.5 mrad at 6 GHz and 0.1 m of height.
DISTANCE_STEP_M = 0.002
# A trace uses the nearest height with a vertical correction; its error is at most half a step times
# (1 - cos) of the angle: 0.13 mm at 60 deg.
HEIGHT_STEP_M = 0.0005
MOST_HEIGHTS = 200
# Pairs of trace and column that are computed at once: less than a second.
PAIRS = 2_000_000


def back_projection_image(
    traces: Traces, focus: Focus, progress: Progress = no_progress
) -> np.ndarray:
    """Return the complex image (depth, y, x).

    Args:
        traces: The traces.
        focus: How to focus.
        progress: Shows the progress.

    Raises:
        MissingLibraryError: numba is not installed.
    """
    try:
        from gpr20_analysis.imaging.projection_kernels import project_columns  # slow to import
    except ImportError as error:
        raise MissingLibraryError(
            Message(
                "{reason}; --method phase-shift works without it",
                reason=library_missing("numba", "compiled"),
            )
        ) from error
    x_m, y_m = traces.x_m, traces.y_m
    height_m = np.asarray(traces.height_m, dtype=np.float64).ravel()
    lowest_m, range_m = float(height_m.min()), float(np.ptp(height_m))
    step_m = max(HEIGHT_STEP_M, range_m / MOST_HEIGHTS)
    distance_m = _distances_m(traces, focus)
    # Height by height, because the iterations need several times the memory of their result.
    delay_s = np.stack(
        [
            one_way_delay_s(
                lowest_m + step_m * one, focus.depth_m, distance_m, focus.permittivity
            ).astype(np.float32)
            for one in range(1 + math.ceil(range_m / step_m))
        ]
    )
    surface_s_per_m = np.zeros(delay_s.shape[1:])
    if focus.ground is Ground.UNEVEN:
        surface_s_per_m = _surface_delay_s_per_m(height_m.mean(), distance_m, focus)
    longest_s = 2.0 * float(delay_s.max() + range_m * np.abs(surface_s_per_m).max())
    spectra = traces.s21.reshape(-1, traces.sweep.count)
    samples, sample_s = gated_a_scans(spectra, traces.sweep, focus.window, longest_s)

    def levels(own_m: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Return the index of the nearest height in the table, and the remaining delay."""
        level = np.rint((own_m - lowest_m) / step_m).astype(np.int32)
        more = (own_m - lowest_m - step_m * level) / (SPEED_OF_LIGHT_M_S * sample_s)
        return level, more.astype(np.float32)

    grid_y, grid_x = np.meshgrid(y_m, x_m, indexing="ij")
    shared = (
        samples.view(np.float32).reshape(*samples.shape, 2),
        np.stack([grid_x.ravel(), grid_y.ravel()], axis=1),
        np.array(antenna_offset_m(traces, focus)),
        height_m,
        *levels(height_m),
        delay_s / np.float32(sample_s),
        (surface_s_per_m / sample_s).astype(np.float32),
        DISTANCE_STEP_M,
        np.array(reach(focus)),
        focus.depth_m,
        focus.ground is Ground.UNEVEN,
    )
    # Height of the antennas' plane above the surface at each column (y, x).
    columns_m = height_m.reshape(len(y_m), len(x_m))
    own = (columns_m, *levels(columns_m))
    width = max(1, PAIRS // len(height_m))
    parts = [
        (x_m[first : first + width], y, *(values[row, first : first + width] for values in own))
        for row, y in enumerate(y_m)
        for first in range(0, len(x_m), width)
    ]

    def project(part: Tuple[Any, ...]) -> np.ndarray:
        return project_columns(*shared, *part)

    found = np.concatenate(on_threads(project, parts, progress)) / np.float32(len(height_m))
    image = (found[:, 0] + np.complex64(1j) * found[:, 1]).reshape(len(y_m), len(x_m), -1)
    return np.ascontiguousarray(np.moveaxis(image, 2, 0))


def _distances_m(traces: Traces, focus: Focus) -> np.ndarray:
    """Return the horizontal distances of the table (distance, 1) [m]."""
    spread_m = [np.ptp(traces.x_m), np.ptp(traces.y_m)]
    in_air, in_soil = reach(focus)
    reach_m = float(traces.height_m.max()) * in_air + float(focus.depth_m[-1]) * in_soil
    furthest_m = min(float(np.hypot(*spread_m)), reach_m) + focus.separation_m / 2.0
    # Two beyond the furthest, so that its right neighbour exists.
    return (DISTANCE_STEP_M * np.arange(3 + math.ceil(furthest_m / DISTANCE_STEP_M)))[:, None]


def _surface_delay_s_per_m(height_m: float, distance_m: np.ndarray, focus: Focus) -> np.ndarray:
    """Return the delay added per metre that the surface is lower below the antenna [s/m].

    Lower than at the point, that is; between the two it is assumed to be a plane. By Fermat's
    principle the change of the path does not change the delay to the first order. What counts is
    how much lower the surface is where the path crosses it: that much more of the path is in air
    instead of soil.

    Args:
        height_m: Height of the antenna above the surface at the point [m], more than 0.
        distance_m: Horizontal distances of the points (distance, 1) [m].
        focus: Their depths, and the permittivity of the soil.
    """
    permittivity, depth_m = focus.permittivity, focus.depth_m
    tangent = tangent_in_air(np.asarray(height_m), depth_m, distance_m, permittivity)
    root = np.sqrt(permittivity + (permittivity - 1.0) * tangent**2)
    # Share of the horizontal distance beyond the crossing.
    beyond = (depth_m / root) / (height_m + depth_m / root)
    secant = np.sqrt(1.0 + tangent**2)
    # The wave number along the vertical is cos(angle) in air, sqrt(permittivity - sin^2) in soil.
    in_soil = np.sqrt(permittivity - (tangent / secant) ** 2)
    delay_s_per_m: np.ndarray = beyond * (1.0 / secant - in_soil) / SPEED_OF_LIGHT_M_S
    return delay_s_per_m

"""Back-projection with the exact refracted delay of every pair of trace and voxel.

Each voxel is the sum of all traces, each at the delay of the path to the voxel. Positions and
heights may be irregular, and the two antennas may be separated. It needs numba.

On a regular grid many pairs share a path: those with the same distance between trace and voxel.
What the traces hold at the delay of that path is interpolated once and added at all offsets of
that distance. Irregular positions and uneven ground are computed pair by pair.
"""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np

from gpr20_analysis.errors import MissingLibraryError, library_missing
from gpr20_analysis.imaging.lattice import lattice_image
from gpr20_analysis.imaging.projection_scene import Scene, scene_of
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.work import Progress, no_progress, on_threads
from gpr20_common.message import Message

# Pairs of trace and column that are computed at once: less than a second.
PAIRS = 2_000_000


def back_projection_image(
    traces: Traces,
    focus: Focus,
    x_m: Optional[np.ndarray] = None,
    y_m: Optional[np.ndarray] = None,
    progress: Progress = no_progress,
) -> np.ndarray:
    """Return the complex image (depth, y, x).

    Args:
        traces: The traces; those of only zeros are skipped.
        focus: How to focus.
        x_m: Positions of the image along X [m]; default those of the traces.
        y_m: The same along Y.
        progress: Shows the progress.

    Raises:
        MissingLibraryError: numba is not installed.
        WrongDatasetError: All traces are zero.
    """
    _require_numba()
    x_m = traces.x_m if x_m is None else np.asarray(x_m, dtype=np.float64)
    y_m = traces.y_m if y_m is None else np.asarray(y_m, dtype=np.float64)
    scene = scene_of(traces, focus, x_m, y_m)
    image = lattice_image(scene, progress) if focus.ground is Ground.LEVEL else None
    if image is None:
        image = pair_image(scene, progress)
    image /= np.float32(traces.height_m.size)
    return image


def _require_numba() -> None:
    try:
        import numba  # noqa: F401
    except ImportError as error:
        raise MissingLibraryError(
            Message(
                "{reason}; --method phase-shift works without it",
                reason=library_missing("numba", "compiled"),
            )
        ) from error


def pair_image(scene: Scene, progress: Progress) -> np.ndarray:
    """Return the image (depth, y, x) of any positions and ground."""
    traces, focus, table = scene.traces, scene.focus, scene.table
    grid_y, grid_x = np.meshgrid(traces.y_m, traces.x_m, indexing="ij")
    place_m = np.stack([grid_x.ravel(), grid_y.ravel()], axis=1)[scene.held]
    height_m = scene.height_m[scene.held]
    uneven = focus.ground is Ground.UNEVEN
    surface_s_per_m = table.surface_s_per_m if uneven else np.zeros_like(table.surface_s_per_m)
    surface = (surface_s_per_m / scene.transform.sample_s).astype(np.float32)
    above = (height_m, *scene.levels(height_m), scene.delays, surface, table.distance_step_m)
    reach = np.array([scene.in_air, scene.in_soil])
    shared = (
        *(_stored(scene), place_m, scene.side_m, *above, reach),
        *(focus.depth_m, uneven),
    )
    column_m = _heights_at(scene)
    own = (column_m, *scene.levels(column_m))
    width = max(1, PAIRS // len(place_m))
    columns = [slice(first, first + width) for first in range(0, len(scene.x_m), width)]
    parts = [
        (scene.x_m[one], y_m, *(values[row, one] for values in own))
        for row, y_m in enumerate(scene.y_m)
        for one in columns
    ]
    from gpr20_analysis.imaging.projection_kernels import project_columns  # slow to import

    def project(part: Tuple[Any, ...]) -> np.ndarray:
        return project_columns(*shared, *part)

    found = np.concatenate(on_threads(project, parts, progress))
    image = found[:, 0] + np.complex64(1j) * found[:, 1]
    image = image.reshape(len(scene.y_m), len(scene.x_m), -1)
    return np.ascontiguousarray(np.moveaxis(image, 2, 0))


def _stored(scene: Scene) -> np.ndarray:
    """Return A-scans of the traces that are not zero (trace, 2: real and imaginary, delay)."""
    held = np.flatnonzero(scene.held)
    samples = np.empty((len(held), 2, scene.transform.kept), dtype=np.float32)
    for block, a_scans in scene.a_scans(held):
        samples[block, 0], samples[block, 1] = a_scans.real, a_scans.imag
    return samples


def _heights_at(scene: Scene) -> np.ndarray:
    """Return the height of the antennas' plane above the surface at each place (y, x) [m]."""
    traces = scene.traces
    along_x = [np.interp(scene.x_m, traces.x_m, row) for row in traces.height_m]
    along_y = [np.interp(scene.y_m, traces.y_m, column) for column in np.transpose(along_x)]
    return np.transpose(along_y)

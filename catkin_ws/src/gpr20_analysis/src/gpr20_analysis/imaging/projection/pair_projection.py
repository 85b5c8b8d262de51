"""Back-projection pair by pair: for any positions, and for uneven ground."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from gpr20_analysis.imaging.projection.projection_scene import Scene
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.progress import Progress
from gpr20_analysis.threads import on_threads

# Pairs of trace and column that are computed at once: less than a second.
PAIRS = 2_000_000


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
    from gpr20_analysis.imaging.projection.pair_kernel import (
        project_columns,  # compiled: slow to import
    )

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

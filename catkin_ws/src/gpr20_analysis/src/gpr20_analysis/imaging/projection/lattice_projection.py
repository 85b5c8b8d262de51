"""Back-projection where the positions of the traces and of the image are regular."""

from __future__ import annotations

from typing import Any, Optional, Tuple

import numpy as np

from gpr20_analysis.imaging.projection.lattice import combs_of, even_step_m, paths_of
from gpr20_analysis.imaging.projection.projection_scene import Scene
from gpr20_analysis.progress import Progress
from gpr20_analysis.threads import on_threads


def lattice_image(scene: Scene, progress: Progress) -> Optional[np.ndarray]:
    """Return the image (depth, y, x); None if positions are irregular."""
    places_m, image_m = (scene.traces.y_m, scene.traces.x_m), (scene.y_m, scene.x_m)
    steps_m = [even_step_m(one) for one in places_m]
    if steps_m[0] is None or steps_m[1] is None:
        return None
    down_combs = combs_of(image_m[0], places_m[0], steps_m[0])
    right_combs = combs_of(image_m[1], places_m[1], steps_m[1])
    if down_combs is None or right_combs is None:
        return None
    counts = (len(places_m[0]), len(places_m[1]))
    furthest_m = (scene.table.delay_s.shape[1] - 3) * scene.table.distance_step_m
    furthest_m -= float(np.hypot(*scene.side_m))
    parts = []
    for pair in ((down, right) for down in down_combs for right in right_combs):
        paths = paths_of(pair, counts, (steps_m[0], steps_m[1]), scene.side_m, furthest_m)
        steps = paths.distance_m / [1.0, *2 * [scene.table.distance_step_m]]
        parts.append((pair, (steps, paths.offsets, paths.ends)))
    level, more = scene.levels(scene.height_m)
    planes: Tuple[Any, ...] = (
        _planes(scene),
        *(one.reshape(counts) for one in (scene.height_m, level, more)),
    )
    shape = (len(scene.focus.depth_m), len(scene.y_m), len(scene.x_m))
    delays = np.moveaxis(scene.delays, 2, 0)
    image = np.empty(shape, dtype=np.complex64)
    from gpr20_analysis.imaging.projection.lattice_kernel import (
        project_depth,  # compiled: slow to import
    )

    def project(row: int) -> None:
        # Distance by height, so that what is needed for one path is adjacent.
        table = np.ascontiguousarray(delays[row].T)
        in_soil_m = scene.in_soil * float(scene.focus.depth_m[row])
        for (down, right), (paths, offsets, ends) in parts:
            first, count = (down.first, right.first), (down.count, right.count)
            own: Tuple[Any, ...] = (
                table,
                scene.in_air,
                in_soil_m,
                first,
                count,
                paths,
                offsets,
                ends,
            )
            real, imaginary = project_depth(*planes, *own)
            image[row][down.columns, right.columns] = real + np.complex64(1j) * imaginary

    on_threads(project, range(shape[0]), progress)
    return image


def _planes(scene: Scene) -> np.ndarray:
    """Return A-scans (2: real and imaginary, delay, y, x), float32."""
    count = len(scene.held)
    samples = np.empty((2, scene.transform.kept, count), dtype=np.float32)
    for block, a_scans in scene.a_scans(np.arange(count)):
        samples[0, :, block], samples[1, :, block] = a_scans.T.real, a_scans.T.imag
    return samples.reshape(2, -1, *scene.traces.s21.shape[:2])

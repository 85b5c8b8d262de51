"""Back-projection on regular grids, where traces lie at the same distance from every column."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, Optional, Tuple

import numpy as np

from gpr20_analysis.imaging.projection_scene import Scene
from gpr20_analysis.work import Progress, on_threads

# Of a position; at 6 GHz it turns the phase by less than 3 mrad.
TOLERANCE_M = 1e-5
# Steps of the image's grid within one of the survey's.
FINEST = 8


@dataclass(frozen=True)
class Comb:
    """Positions of an image, evenly spaced by the step of the traces, along one axis.

    Attributes:
        columns: Which positions of the image.
        first: Index of the trace at or before the first of them; may be negative.
        beyond_m: How far they lie beyond the traces of these indices [m].
        count: Number of positions.
    """

    columns: slice
    first: int
    beyond_m: float
    count: int


@dataclass(frozen=True)
class Paths:
    """Offsets from a column of an image to traces, grouped by the distances to both antennas.

    Attributes:
        distance_m: Distance to the middle of the antennas, then to either one, nearest path
            first (path, 3) [m].
        offsets: Rows and columns (offset, 2), path by path.
        ends: End of each path's offsets.
    """

    distance_m: np.ndarray
    offsets: np.ndarray
    ends: np.ndarray


def even_step_m(place_m: np.ndarray) -> Optional[float]:
    """Return the step of evenly spaced, ascending positions [m]; None if they are not."""
    if len(place_m) < 2:
        return 1.0
    step_m = float(place_m[-1] - place_m[0]) / (len(place_m) - 1)
    return step_m if _even(place_m, step_m) and step_m > TOLERANCE_M else None


def combs_of(image_m: np.ndarray, place_m: np.ndarray, step_m: float) -> Optional[List[Comb]]:
    """Return how positions of an image lie between those of traces; None if not regularly.

    Args:
        image_m: Positions of the image along one axis [m].
        place_m: Positions of the traces, evenly spaced [m].
        step_m: Their step [m].
    """
    for finer in range(1, FINEST + 1):
        columns = [slice(first, None, finer) for first in range(min(finer, len(image_m)))]
        if all(_even(image_m[one], step_m) for one in columns):
            return [_comb(image_m[one], one, place_m[0], step_m) for one in columns]
    return None


def _even(place_m: np.ndarray, step_m: float) -> bool:
    off_m = place_m - place_m[0] - step_m * np.arange(len(place_m))
    return bool(np.all(np.abs(off_m) <= TOLERANCE_M))


def _comb(image_m: np.ndarray, columns: slice, first_m: float, step_m: float) -> Comb:
    first = int(np.floor((image_m[0] - first_m + TOLERANCE_M) / step_m))
    beyond_m = float(image_m[0] - first_m - first * step_m)
    return Comb(columns, first, 0.0 if abs(beyond_m) <= TOLERANCE_M else beyond_m, len(image_m))


def paths_of(
    combs: Tuple[Comb, Comb],
    counts: Tuple[int, int],
    steps_m: Tuple[float, float],
    side_m: np.ndarray,
    furthest_m: float,
) -> Paths:
    """Return the paths from the columns of an image to the traces.

    Args:
        combs: Positions of the image along Y and X.
        counts: Number of traces along Y and X.
        steps_m: Steps of the traces along Y and X [m].
        side_m: From the middle of the antennas to one of them (x, y) [m].
        furthest_m: Largest distance from the middle of the antennas [m].
    """
    down, right = (
        _offsets(comb, count, step_m, furthest_m)
        for comb, count, step_m in zip(combs, counts, steps_m)
    )
    rows, columns = (one.ravel() for one in np.meshgrid(down, right, indexing="ij"))
    dy_m = rows * steps_m[0] - combs[0].beyond_m
    dx_m = columns * steps_m[1] - combs[1].beyond_m
    either = [np.hypot(dx_m + sign * side_m[0], dy_m + sign * side_m[1]) for sign in (1.0, -1.0)]
    # The two antennas can be exchanged. Distances that differ by rounding errors are the same.
    distance_m = np.round(
        np.stack([np.hypot(dx_m, dy_m), np.minimum(*either), np.maximum(*either)], axis=1), 9
    )
    near = distance_m[:, 0] <= furthest_m
    distance_m, places = distance_m[near], np.stack([rows, columns], axis=1)[near]
    own, path, sizes = np.unique(distance_m, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(path.ravel(), kind="stable")
    return Paths(own, np.ascontiguousarray(places[order]), np.cumsum(sizes))


def _offsets(comb: Comb, count: int, step_m: float, furthest_m: float) -> np.ndarray:
    """Return the offsets that lead from any position of the image to a trace in reach."""
    most = int(np.ceil(furthest_m / step_m)) + 1
    lowest = max(-most, -(comb.first + comb.count - 1))
    highest = min(most, count - 1 - comb.first)
    return np.arange(lowest, highest + 1)


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
    from gpr20_analysis.imaging.projection_kernels import project_depth  # slow to import

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

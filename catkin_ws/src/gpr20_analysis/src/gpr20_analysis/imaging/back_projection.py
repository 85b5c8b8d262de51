"""Back-projection with the exact refracted delay of every pair of trace and voxel.

Each voxel is the sum of all traces, each at the delay of the path to the voxel. Positions and
heights may be irregular, and the two antennas may be separated. It needs numba.

On a regular grid many pairs share a path: those with the same distance between trace and voxel.
What the traces hold at the delay of that path is interpolated once and added at all offsets of
that distance. Irregular positions and uneven ground are computed pair by pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, Optional, Tuple

import numpy as np
from scipy.constants import speed_of_light

from gpr20_analysis import cluster
from gpr20_analysis.cluster import slices
from gpr20_analysis.errors import MissingLibraryError, WrongDatasetError, library_missing
from gpr20_analysis.imaging.a_scans import Transform
from gpr20_analysis.imaging.lattice import Comb, combs_of, even_step_m, paths_of
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.imaging.refraction import DelayTable, tabulate_delays
from gpr20_analysis.progress import Progress, no_progress
from gpr20_common.message import Message

# Traces that are transformed at once: about 20 MiB.
BLOCK = 2048


@dataclass(frozen=True)
class _Scene:
    """Traces and delays, for either way.

    Attributes:
        traces: The traces.
        focus: How to focus.
        x_m: Positions of the image along X [m].
        y_m: The same along Y.
        held: Which traces are not zero (trace).
        height_m: Height of the antennas, of the lowest where a trace is zero (trace) [m].
        side_m: From the middle of the antennas to the transmitter (x, y) [m].
        in_air: Horizontal reach of the widest ray per height.
        in_soil: The same per depth.
        table: One-way delays.
        transform: Makes the A-scans.
    """

    traces: Traces
    focus: Focus
    x_m: np.ndarray
    y_m: np.ndarray
    held: np.ndarray
    height_m: np.ndarray
    side_m: np.ndarray
    in_air: float
    in_soil: float
    table: DelayTable
    transform: Transform

    @property
    def delays(self) -> np.ndarray:
        """One-way delays in samples (height, distance, depth), float32."""
        return self.table.delay_s / np.float32(self.transform.sample_s)

    def levels(self, height_m: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Return the index of the nearest height in the table, and the remaining delay."""
        step_m = self.table.height_step_m
        level = np.rint((height_m - self.table.lowest_m) / step_m).astype(np.int32)
        more_m = height_m - self.table.lowest_m - step_m * level
        more = more_m / speed_of_light / self.transform.sample_s
        return level, more.astype(np.float32)


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
    scene = _scene(traces, focus, x_m, y_m)
    image = _on_grid(scene, progress) if focus.ground is Ground.LEVEL else None
    if image is None:
        image = _pair_by_pair(scene, progress)
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


def _scene(traces: Traces, focus: Focus, x_m: np.ndarray, y_m: np.ndarray) -> _Scene:
    held = np.any(traces.s21, axis=2).ravel()
    if not np.any(held):
        raise WrongDatasetError(
            Message("every trace is zero or was left out, so there is nothing to image")
        )
    height_m = traces.height_m.ravel()
    # A trace of zeros adds nothing, so its height does not matter.
    height_m = np.where(held, height_m, height_m[held].min())
    apart_m, turn = focus.separation_m / 2.0, np.radians(traces.rotation_deg)
    sine = np.sin(np.radians(focus.widest_angle_deg))
    in_air = float(sine / np.sqrt(max(1.0 - sine**2, 1e-6)))
    in_soil = float(sine / np.sqrt(max(focus.permittivity - sine**2, 1e-6)))
    spread_m = [
        max(np.max(axis_m) - np.min(place_m), np.max(place_m) - np.min(axis_m))
        for axis_m, place_m in ((x_m, traces.x_m), (y_m, traces.y_m))
    ]
    reach_m = float(height_m.max()) * in_air + float(focus.depth_m[-1]) * in_soil
    furthest_m = min(float(np.hypot(*spread_m)), reach_m)
    table = tabulate_delays(height_m, focus.depth_m, furthest_m + apart_m, focus.permittivity)
    lower_s = float(np.ptp(height_m) * np.abs(table.surface_s_per_m).max())
    longest_s = 2.0 * (float(table.delay_s.max()) + lower_s)
    return _Scene(
        *(traces, focus, x_m, y_m, held, height_m),
        side_m=apart_m * np.array([np.cos(turn), np.sin(turn)]),
        in_air=in_air,
        in_soil=in_soil,
        table=table,
        transform=Transform.until(longest_s, traces.sweep, focus.window),
    )


def _on_grid(scene: _Scene, progress: Progress) -> Optional[np.ndarray]:
    """Return the image (depth, y, x); None if positions are irregular."""
    places_m, image_m = (scene.traces.y_m, scene.traces.x_m), (scene.y_m, scene.x_m)
    steps_m = [even_step_m(one) for one in places_m]
    if steps_m[0] is None or steps_m[1] is None:
        return None
    combs = [combs_of(*axis) for axis in zip(image_m, places_m, steps_m)]
    if combs[0] is None or combs[1] is None:
        return None
    counts = (len(places_m[0]), len(places_m[1]))
    furthest_m = (scene.table.delay_s.shape[1] - 3) * scene.table.distance_step_m
    furthest_m -= float(np.hypot(*scene.side_m))
    parts = []
    for pair in ((down, right) for down in combs[0] for right in combs[1]):
        paths = paths_of(pair, counts, (steps_m[0], steps_m[1]), scene.side_m, furthest_m)
        steps = paths.distance_m / [1.0, *2 * [scene.table.distance_step_m]]
        parts.append((pair, (steps, paths.offsets, paths.ends)))
    level, more = scene.levels(scene.height_m)
    shared = (
        _planes(scene),
        *(one.reshape(counts) for one in (scene.height_m, level, more)),
        scene.in_air,
        parts,
    )
    shape = (len(scene.focus.depth_m), len(scene.y_m), len(scene.x_m))
    delays = np.moveaxis(scene.delays, 2, 0)
    # Distance by height, so that what is needed for one path is adjacent.
    items = [
        [
            (np.ascontiguousarray(delays[one].T), scene.in_soil * float(scene.focus.depth_m[one]))
            for one in range(shape[0])[part]
        ]
        for part in slices(shape[0], _pieces(shape[0]))
    ]
    threads = cluster.processors()
    found = cluster.distribute(_grid_slab, (shared, shape[1:]), items, progress, threads)
    return np.concatenate(found)


def _grid_slab(shared: Tuple[Any, ...], depths: List[Tuple[np.ndarray, float]]) -> np.ndarray:
    """Return the image of some depths (depth, y, x)."""
    from gpr20_analysis.imaging.lattice_kernel import project_depth

    (samples, height_m, level, more, in_air, parts), size = shared
    image = np.empty((len(depths), *size), dtype=np.complex64)
    for one, (table, in_soil_m) in zip(image, depths):
        for (down, right), (paths, offsets, ends) in parts:
            real, imaginary = project_depth(
                *(samples, height_m, level, more, table, in_air, in_soil_m),
                *((down.first, right.first), (down.count, right.count), paths, offsets, ends),
            )
            one[down.columns, right.columns] = real + np.complex64(1j) * imaginary
    return image


def _planes(scene: _Scene) -> np.ndarray:
    """Return A-scans (2: real and imaginary, delay, y, x), float32."""
    spectra = scene.traces.s21.reshape(-1, scene.traces.sweep.count)
    samples = np.empty((2, scene.transform.kept, len(spectra)), dtype=np.float32)
    for first in range(0, len(spectra), BLOCK):
        a_scans = scene.transform.a_scans(spectra[first : first + BLOCK]).T
        samples[0, :, first : first + BLOCK] = a_scans.real
        samples[1, :, first : first + BLOCK] = a_scans.imag
    return samples.reshape(2, -1, *scene.traces.s21.shape[:2])


def _pieces(count: int) -> int:
    """Return the number of pieces of work: small ones in this process, to show the progress."""
    return count if cluster.parts() == 1 else cluster.parts()


def _pair_by_pair(scene: _Scene, progress: Progress) -> np.ndarray:
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
        *(focus.depth_m, uneven, scene.x_m),
    )
    column_m = _heights_at(scene)
    own = (scene.y_m, column_m, *scene.levels(column_m))
    rows = [
        [tuple(one[row] for one in own) for row in range(len(scene.y_m))[part]]
        for part in slices(len(scene.y_m), _pieces(len(scene.y_m)))
    ]
    found = cluster.distribute(_rows, shared, rows, progress, cluster.processors())
    return np.ascontiguousarray(np.moveaxis(np.concatenate(found), 2, 0))


def _rows(shared: Tuple[Any, ...], rows: List[Tuple[Any, ...]]) -> np.ndarray:
    """Return some rows of the image (y, x, depth)."""
    from gpr20_analysis.imaging.back_projection_kernel import project_row

    found = [project_row(*shared, *row) for row in rows]
    return np.stack([one[:, 0] + np.complex64(1j) * one[:, 1] for one in found])


def _stored(scene: _Scene) -> np.ndarray:
    """Return A-scans of the traces that are not zero (trace, 2: real and imaginary, delay)."""
    spectra, held = scene.traces.s21.reshape(len(scene.held), -1), np.flatnonzero(scene.held)
    samples = np.empty((len(held), 2, scene.transform.kept), dtype=np.float32)
    for first in range(0, len(held), BLOCK):
        a_scans = scene.transform.a_scans(spectra[held[first : first + BLOCK]])
        samples[first : first + BLOCK, 0] = a_scans.real
        samples[first : first + BLOCK, 1] = a_scans.imag
    return samples


def _heights_at(scene: _Scene) -> np.ndarray:
    """Return the height of the antennas' plane above the surface at each place (y, x) [m]."""
    traces = scene.traces
    along_x = [np.interp(scene.x_m, traces.x_m, row) for row in traces.height_m]
    along_y = [np.interp(scene.y_m, traces.y_m, column) for column in np.transpose(along_x)]
    return np.transpose(along_y)

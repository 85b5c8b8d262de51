"""Back-projection with the exact refracted delay of every pair of trace and voxel.

Each voxel is the sum of all traces, each at the delay of the path to the voxel. Positions and
heights may be irregular, and the two antennas may be separated. It needs numba.

On a regular grid many pairs share a path: those with the same distance between trace and voxel.
What the traces hold at the delay of that path is interpolated once and added at all offsets of
that distance. Irregular positions and uneven ground are computed pair by pair.
"""

from __future__ import annotations

from typing import Optional

import numpy as np

from gpr20_analysis.errors import MissingLibraryError, library_missing
from gpr20_analysis.imaging.projection.lattice_projection import lattice_image
from gpr20_analysis.imaging.projection.pair_projection import pair_image
from gpr20_analysis.imaging.projection.projection_scene import scene_of
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.progress import Progress, no_progress
from gpr20_common.message import Message


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

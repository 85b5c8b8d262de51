"""Volumes as VTK image data, for ParaView and its kin."""

from __future__ import annotations

from pathlib import Path
from typing import Dict

import numpy as np

from gpr20_analysis.errors import ExportError, MissingLibraryError

SUFFIX = ".vtr"


def write_vtk(
    path: Path, x_m: np.ndarray, y_m: np.ndarray, z_m: np.ndarray, volumes: Dict[str, np.ndarray]
) -> None:
    """Write volumes on one rectilinear grid.

    Args:
        path: Ends in .vtr.
        x_m: Positions along X [m].
        y_m: Positions along Y [m].
        z_m: Positions upwards [m], ascending: a depth is negative.
        volumes: Real values by name, each (x, y, z).

    Raises:
        ExportError: The name ends in something else.
        MissingLibraryError: pyevtk is not installed.
        OSError: It cannot be written.
    """
    if path.suffix != SUFFIX:
        raise ExportError(f"{path.name} must end in {SUFFIX}, VTK's rectilinear grid")
    try:
        from pyevtk.hl import gridToVTK
    except ImportError as error:
        raise MissingLibraryError(
            "VTK files need pyevtk: pip install 'gpr20_analysis[vtk]'"
        ) from error
    contiguous = {name: np.asfortranarray(values) for name, values in volumes.items()}
    axes = [np.ascontiguousarray(axis, dtype=np.float64) for axis in (x_m, y_m, z_m)]
    gridToVTK(str(path.with_suffix("")), *axes, pointData=contiguous)

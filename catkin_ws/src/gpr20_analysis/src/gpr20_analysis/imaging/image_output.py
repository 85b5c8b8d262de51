"""An image in the forms that other programs take, and in words."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import DEPTH, IMAGE, MM_PER_M, POLARIZATION, X, Y, require
from gpr20_analysis.errors import ExportError, MissingLibraryError
from gpr20_analysis.imaging.echoes import Echo


def write_volume(image: xr.Dataset, path: Path) -> None:
    """Write the magnitude of each polarization as VTK, z upwards from the surface.

    Raises:
        ExportError: The path does not end in .vtr.
        MissingLibraryError: pyevtk is not installed.
        OSError: It cannot be written.
    """
    magnitude = np.abs(require(image, IMAGE, (POLARIZATION, X, Y, DEPTH)).values)
    volumes = {
        f"magnitude_{rotation_word(turn)}": np.ascontiguousarray(volume[:, :, ::-1])
        for turn, volume in zip(image[POLARIZATION].values, magnitude)
    }
    write_vtk(path, image[X].values, image[Y].values, -image[DEPTH].values[::-1], volumes)


def rotation_word(rotation_deg: float) -> str:
    """Return a polarization as part of a name."""
    return "combined" if np.isnan(rotation_deg) else f"{rotation_deg:g}deg"


def echo_lines(echoes: List[Echo]) -> List[str]:
    """Return a table of echoes, one line each below its heading, and what to doubt."""
    heading = (
        "polarization      x mm      y mm  depth mm  level dB  above noise dB   "
        "-3 dB width x, y, depth mm"
    )
    lines = [heading] + [
        f"{rotation_word(echo.polarization_deg):>12} "
        f"{echo.x_m * MM_PER_M:9.1f} {echo.y_m * MM_PER_M:9.1f} "
        f"{echo.depth_m * MM_PER_M:9.1f} {echo.level_db:9.1f} {echo.above_noise_db:15.1f}   "
        f"{echo.width_x_m * MM_PER_M:8.1f} {echo.width_y_m * MM_PER_M:8.1f} "
        f"{echo.width_depth_m * MM_PER_M:8.1f}"
        for echo in echoes
    ]
    return [*lines, *doubtful_echoes(echoes)]


def doubtful_echoes(echoes: List[Echo]) -> List[str]:
    """Return a sentence on echoes that may be noise; none if there are no such echoes."""
    doubtful = sum(echo.above_noise_db <= 0.0 for echo in echoes)
    if not doubtful:
        return []
    return [
        f"{doubtful} of the {len(echoes)} are no brighter than the brightest voxel would be if the "
        "whole image were noise: they may be no echoes"
    ]


def permittivity_line(image: xr.Dataset) -> str:
    """Return what permittivity was taken, and how far depths are off if it is another."""
    value = float(image.attrs["permittivity"])
    if "permittivity_lowest" not in image.attrs:
        return f"relative permittivity {value:.3g} as given"
    lowest, highest = (float(image.attrs[f"permittivity_{end}"]) for end in ("lowest", "highest"))
    deeper, shallower = (100.0 * (np.sqrt(value / one) - 1.0) for one in (lowest, highest))
    return (
        f"relative permittivity {value:.3g}, ESTIMATED by focus; nearly as good from {lowest:.3g} "
        f"to {highest:.3g}: depths may be off by {shallower:+.0f} % to {deeper:+.0f} %"
    )


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

"""An image as VTK file, and its echoes as text."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import DEPTH, IMAGE, MM_PER_M, POLARIZATION, X, Y, require
from gpr20_analysis.errors import (
    ExportError,
    MissingLibraryError,
    library_missing,
    wrong_ending,
)
from gpr20_analysis.imaging.echoes import Echo
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message


def write_volume(image: xr.Dataset, path: Path) -> None:
    """Write the magnitude of each polarization as VTK, z upwards from the surface.

    Raises:
        ExportError: The path has another ending than .vtr.
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
    """Return a polarization as part of a file name."""
    return "combined" if np.isnan(rotation_deg) else f"{rotation_deg:g}deg"


def echo_heading(catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return the titles of the columns of a table of echoes."""
    return (
        catalogue.tr("polarization"),
        catalogue.tr("x mm"),
        catalogue.tr("y mm"),
        catalogue.tr("depth mm"),
        catalogue.tr("level dB"),
        catalogue.tr("above noise dB"),
        catalogue.tr("-3 dB width x, y, depth mm"),
    )


def echo_row(echo: Echo, catalogue: Catalogue = ENGLISH) -> Tuple[str, ...]:
    """Return an echo as a row of a table below `echo_heading`."""
    widths_m = (echo.width_x_m, echo.width_y_m, echo.width_depth_m)
    turn_deg = echo.polarization_deg
    name = Message("{rotation_deg:g} deg", rotation_deg=turn_deg)
    return (
        catalogue.text(Message("combined") if np.isnan(turn_deg) else name),
        *(_mm(one) for one in (echo.x_m, echo.y_m, echo.depth_m)),
        f"{echo.level_db:.1f}",
        f"{echo.above_noise_db:.1f}",
        ", ".join(_mm(one) for one in widths_m),
    )


def echo_lines(echoes: List[Echo], catalogue: Catalogue = ENGLISH) -> List[str]:
    """Return the lines of a table of echoes, and a warning about those that may be noise."""
    rows = [echo_heading(catalogue), *(echo_row(echo, catalogue) for echo in echoes)]
    widths = [max(len(cell) for cell in column) for column in zip(*rows)]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in rows]
    return [*lines, *(catalogue.text(one) for one in doubtful_echoes(echoes))]


def doubtful_echoes(echoes: List[Echo]) -> List[Message]:
    """Return a warning about echoes that may be noise; empty if there are none."""
    doubtful = sum(echo.above_noise_db <= 0.0 for echo in echoes)
    if not doubtful:
        return []
    return [
        Message(
            "{doubtful} of the {count} echoes are not brighter than the brightest voxel expected "
            "from noise alone, so they may be noise",
            doubtful=doubtful,
            count=len(echoes),
        )
    ]


def permittivity_line(image: xr.Dataset) -> Message:
    """Return the permittivity of an image and, if it was estimated, the uncertainty of depths."""
    value = float(image.attrs["permittivity"])
    if "permittivity_lowest" not in image.attrs:
        return Message("relative permittivity {permittivity:.3g}, as given", permittivity=value)
    lowest, highest = (float(image.attrs[f"permittivity_{end}"]) for end in ("lowest", "highest"))
    deeper, shallower = (100.0 * (np.sqrt(value / one) - 1.0) for one in (lowest, highest))
    return Message(
        "relative permittivity {permittivity:.3g}, ESTIMATED from echoes; 95 % range {lowest:.3g} "
        "to {highest:.3g}, so the error of depths is {shallower:+.0f} % to {deeper:+.0f} %",
        permittivity=value,
        lowest=lowest,
        highest=highest,
        shallower=shallower,
        deeper=deeper,
    )


def _mm(value_m: float) -> str:
    return f"{value_m * MM_PER_M:.1f}"


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
        ExportError: The path has another ending.
        MissingLibraryError: pyevtk is not installed.
        OSError: It cannot be written.
    """
    if path.suffix != SUFFIX:
        raise ExportError(wrong_ending(path, [SUFFIX]))
    try:
        from pyevtk.hl import gridToVTK
    except ImportError as error:
        raise MissingLibraryError(library_missing("pyevtk", "vtk")) from error
    contiguous = {name: np.asfortranarray(values) for name, values in volumes.items()}
    axes = [np.ascontiguousarray(axis, dtype=np.float64) for axis in (x_m, y_m, z_m)]
    gridToVTK(str(path.with_suffix("")), *axes, pointData=contiguous)

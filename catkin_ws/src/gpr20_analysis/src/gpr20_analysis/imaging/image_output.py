"""An image as VTK file, and its permittivity as text."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import Dict, Mapping, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y, require
from gpr20_analysis.errors import (
    ExportError,
    MissingLibraryError,
    library_missing,
    wrong_ending,
)
from gpr20_analysis.formats.provenance import SIMULATED_KEY, is_simulated
from gpr20_analysis.imaging.permittivity.known_permittivity import (
    GIVEN_UNCERTAINTY,
    Source,
    depth_shares,
)
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
    marks = {SIMULATED_KEY: np.array([1])} if is_simulated(image) else {}
    z_m = -image[DEPTH].values[::-1]
    write_vtk(path, image[X].values, image[Y].values, z_m, volumes, marks)


def rotation_word(rotation_deg: float) -> str:
    """Return a polarization as part of a file name."""
    return "combined" if np.isnan(rotation_deg) else f"{rotation_deg:g}deg"


def permittivity_line(image: xr.Dataset) -> Message:
    """Return the permittivity of an image, where it is from, and the uncertainty of depths.

    Args:
        image: Dataset with `image`.
    """
    value = float(image.attrs["permittivity"])
    lowest, highest = permittivity_range(image)
    _, deeper, shallower = depth_shares(value, lowest, highest)
    return Message(
        "The soil's permittivity is {permittivity:.3g}, {source}; {lowest:.3g} to {highest:.3g} is "
        "likely, so depths may be wrong by {shallower:+.0f} % to {deeper:+.0f} %.",
        permittivity=value,
        source=Source(image.attrs.get("permittivity_source", Source.GIVEN.value)).message,
        lowest=lowest,
        highest=highest,
        shallower=-100.0 * shallower,
        deeper=100.0 * deeper,
    )


def permittivity_range(image: xr.Dataset) -> Tuple[float, float]:
    """Return the lowest and highest likely permittivity of an image, also of other programs."""
    value = float(image.attrs["permittivity"])
    lowest = float(image.attrs.get("permittivity_lowest", value * (1.0 - GIVEN_UNCERTAINTY)))
    highest = float(image.attrs.get("permittivity_highest", value * (1.0 + GIVEN_UNCERTAINTY)))
    return max(lowest, 1.0), highest


SUFFIX = ".vtr"


def write_vtk(
    path: Path,
    x_m: np.ndarray,
    y_m: np.ndarray,
    z_m: np.ndarray,
    volumes: Dict[str, np.ndarray],
    marks: Mapping[str, np.ndarray] = MappingProxyType({}),
) -> None:
    """Write volumes on one rectilinear grid.

    Args:
        path: Ends in .vtr.
        x_m: Positions along X [m].
        y_m: Positions along Y [m].
        z_m: Positions upwards [m], ascending: a depth is negative.
        volumes: Real values by name, each (x, y, z).
        marks: Values that hold for the whole file, by name.

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
    gridToVTK(str(path.with_suffix("")), *axes, pointData=contiguous, fieldData=dict(marks))

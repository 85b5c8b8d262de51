"""The HDF5 file of a migrated image of the GPR-20 group: magnitudes of one polarization."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y
from gpr20_analysis.errors import AnalysisError, ExportError, UnreadableFileError
from gpr20_analysis.formats.checksums import add_checksum, has_checksum
from gpr20_analysis.formats.common import even_step
from gpr20_analysis.formats.format import ImageFormat
from gpr20_analysis.formats.provenance import (
    SIMULATED,
    SIMULATED_KEY,
    kept,
    marked,
    restored,
)
from gpr20_analysis.sentences import with_sentences
from gpr20_common.message import Message

GROUP, DATA_SET = "MigratedImage", "Image"
PERMITTIVITY, ROTATION = "Relative permittivity", "Antenna rotation [deg]"
METHOD = "method"


def write_migrated(image: xr.Dataset, path: Path, title: str) -> None:
    """Write the magnitude of an image of one polarization.

    Raises:
        ExportError: It has more than one polarization, or uneven spacing.
        OSError: The file exists or cannot be written.
    """
    values = dataset.require(image, IMAGE, (POLARIZATION, X, Y, DEPTH))
    if values.sizes[POLARIZATION] != 1:
        raise ExportError(
            Message("a file of a migrated image holds one polarization; image each by itself"),
            fault=faults.INPUT,
        )
    axes = {"x": image[X].values, "y": image[Y].values, "z": image[DEPTH].values}
    for name, axis in axes.items():
        even_step(axis, name, "m")
    with h5py.File(str(path), "x") as file:
        file.attrs.update(kept(image))
        file.attrs["Title"] = marked(title, image)
        file.attrs[PERMITTIVITY] = float(image.attrs["permittivity"])
        file.attrs[ROTATION] = float(image[POLARIZATION].values[0])
        file.attrs[METHOD] = str(image.attrs.get(METHOD, ""))
        place = file.create_group("Position")
        for name, axis in axes.items():
            place.attrs[f"{name}0"], place.attrs[f"{name}f"] = float(axis[0]), float(axis[-1])
            place.attrs[f"q{name}"] = len(axis)
        place.attrs["h_ant_mig"] = float(image.attrs.get("mean_height_m", np.nan))
        magnitude = np.abs(values.values[0]).astype(np.float32)
        file.create_group(GROUP).create_dataset(DATA_SET, data=magnitude, compression="gzip")
    add_checksum(path)


def is_migrated(path: Path) -> bool:
    """Return whether a file is a migrated image, without reading it."""
    try:
        with h5py.File(str(path), "r") as file:
            return f"{GROUP}/{DATA_SET}" in file
    # On damaged files HDF5 raises exceptions of many kinds.
    except Exception:
        return False


def read_migrated(path: Path) -> xr.Dataset:
    """Read such a file as an image.

    Raises:
        UnreadableFileError: It is damaged.
        OSError: It cannot be read.
    """
    checked = has_checksum(path)
    try:
        with h5py.File(str(path), "r") as file:
            return _read(file, path.name, checked)
    except AnalysisError:
        raise
    # On damaged files HDF5 and numpy raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message("{file} is damaged or is not a migrated image", file=path.name, details=error)
        ) from error


def _read(file: Any, name: str, checked: bool) -> xr.Dataset:
    position = file["Position"].attrs
    axes = [
        np.linspace(
            float(position[f"{one}0"]), float(position[f"{one}f"]), int(position[f"q{one}"])
        )
        for one in "xyz"
    ]
    values = np.asarray(file[f"{GROUP}/{DATA_SET}"][()], np.float64)
    shape = tuple(len(axis) for axis in axes)
    ascending = all((np.diff(axis) > 0.0).all() for axis in axes)
    if values.shape != shape or not np.isfinite(values).all() or not ascending:
        raise UnreadableFileError(
            Message(
                "{file}: the image has the shape {found} instead of {expected}, contains NaN or "
                "infinite values, or its positions are not ascending",
                file=name,
                found=" x ".join(map(str, values.shape)),
                expected=" x ".join(map(str, shape)),
            ),
            fault=faults.INPUT,
        )
    rotation_deg = float(file.attrs.get(ROTATION, np.nan))
    x_m, y_m, depth_m = axes
    image = xr.Dataset(
        {IMAGE: ((POLARIZATION, DEPTH, Y, X), np.moveaxis(values, (0, 1, 2), (2, 1, 0))[None])},
        {POLARIZATION: [rotation_deg], DEPTH: depth_m, Y: y_m, X: x_m},
    )
    for axis in (POLARIZATION, DEPTH, Y, X):
        image[axis].attrs.update(dataset.ATTRIBUTES[axis])
    image[IMAGE].attrs.update(units="1", long_name="image")
    image.attrs.update(
        format=dataset.FORMAT,
        source=name,
        permittivity=float(file.attrs[PERMITTIVITY]),
        permittivity_source="given",
        method=str(file.attrs.get(METHOD, "")) or "migrated image of the group",
        mean_height_m=float(position["h_ant_mig"]),
    )
    found = dict(file.attrs)
    if SIMULATED in str(found.get("Title", "")):
        found[SIMULATED_KEY] = True
    notes = _notes(depth_m, name, checked)
    lists = with_sentences(image.attrs, missing=[], faults=[], notes=notes)
    return restored(image.assign_attrs(lists), found)


def _notes(depth_m: np.ndarray, name: str, checked: bool) -> List[Message]:
    notes = [Message("the image holds magnitudes only, in single precision")]
    if not checked:
        notes.append(
            Message(
                "{file} has no gpr20 checksum, so changes on the disk cannot be detected",
                file=name,
            )
        )
        notes.append(
            Message(
                "depths are taken as evenly spaced from z0 to zf; the group's migration leaves out "
                "zf, so true depths may be up to {step_mm:.1f} mm smaller",
                step_mm=dataset.MM_PER_M * float(depth_m[1] - depth_m[0]),
            )
        )
    return notes


FORMAT = ImageFormat(is_migrated, read_migrated, write_migrated)

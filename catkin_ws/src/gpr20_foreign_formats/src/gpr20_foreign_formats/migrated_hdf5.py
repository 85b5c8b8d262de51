"""The HDF5 file of a migrated image of the GPR-20 group: magnitudes of one polarization."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Optional

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.sentences import with_sentences
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_foreign_formats.header import Header, hdf5_with, opened_hdf5, refusal

DATA_SET = "MigratedImage/Image"
PERMITTIVITY = "Relative permittivity"
FARTHEST_M, MOST_POINTS, HIGHEST_PERMITTIVITY = 10.0, 100_000, 1e3


def read_migrated(path: Path, _: ImportOptions, __: Progress) -> xr.Dataset:
    """Read such a file as an image.

    Raises:
        UnreadableFileError: It is damaged.
        OSError: It cannot be read.
    """
    with opened_hdf5(path, "migrated image (HDF5)", DATA_SET, "Position") as file:
        return _read(file, path.name)


def _read(file: Any, name: str) -> xr.Dataset:
    position = Header(name, file["Position"].attrs, typed=True)
    axes = [
        np.linspace(
            position.number(f"{one}0", -FARTHEST_M, FARTHEST_M),
            position.number(f"{one}f", -FARTHEST_M, FARTHEST_M),
            position.count(f"q{one}", 2 if one == "z" else 1, MOST_POINTS),
        )
        for one in "xyz"
    ]
    values = np.asarray(file[DATA_SET][()], np.float64)
    shape = tuple(len(axis) for axis in axes)
    ascending = all((np.diff(axis) > 0.0).all() for axis in axes)
    if values.shape != shape or not np.isfinite(values).all() or not ascending:
        raise refusal(
            Message(
                "{file}: the image has the shape {found} instead of {expected}, contains NaN or "
                "infinite values, or its positions are not ascending",
                file=name,
                found=" x ".join(map(str, values.shape)),
                expected=" x ".join(map(str, shape)),
            )
        )
    x_m, y_m, depth_m = axes
    image = xr.Dataset(
        {IMAGE: ((POLARIZATION, DEPTH, Y, X), np.moveaxis(values, (0, 1, 2), (2, 1, 0))[None])},
        {POLARIZATION: [np.nan], DEPTH: depth_m, Y: y_m, X: x_m},
    )
    for axis in (POLARIZATION, DEPTH, Y, X):
        image[axis].attrs.update(dataset.ATTRIBUTES[axis])
    image[IMAGE].attrs.update(units="1", long_name="image")
    image.attrs.update(
        format=dataset.FORMAT,
        source=printable(name),
        permittivity=Header(name, file.attrs, typed=True).number(
            PERMITTIVITY, 1.0, HIGHEST_PERMITTIVITY
        ),
        permittivity_source="given",
        method="migrated image of the group",
        mean_height_m=position.number("h_ant_mig", 0.0, FARTHEST_M),
    )
    notes = [
        Message("the image holds magnitudes only, in single precision"),
        Message(
            "depths are taken as evenly spaced from z0 to zf; the group's migration leaves out zf, "
            "so true depths may be up to {step_mm:.1f} mm smaller",
            step_mm=dataset.MM_PER_M * float(depth_m[1] - depth_m[0]),
        ),
    ]
    return image.assign_attrs(with_sentences(image.attrs, missing=[], faults=[], notes=notes))


def _whole(path: Path) -> Optional[Path]:
    return hdf5_with(path, DATA_SET)


IMPORT = ImportFormat(read_migrated, _whole, ())

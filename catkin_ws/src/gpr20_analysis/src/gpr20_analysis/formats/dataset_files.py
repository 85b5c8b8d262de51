"""Datasets of surveys, A-scans, images and models as NetCDF, which is HDF5, by the CF conventions.

CF 1.9 is the first version with unsigned bytes and 64-bit integers. NetCDF knows no complex
numbers: a complex variable `s21` is stored as `s21_real` and `s21_imag`. HDF5 itself checks the
numbers and the structure of a file (Fletcher's checksum, format 1.8), so that a changed byte is an
error and no echo.
"""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any, Dict, Tuple, Union

import numpy as np
import xarray as xr
from xarray.backends import H5NetCDFStore

from gpr20_analysis import dataset, faults
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import (
    AnalysisError,
    DamagedSurveyError,
    ExportError,
    UnreadableFileError,
    not_there,
    wrong_ending,
)
from gpr20_analysis.formats.facts import marked
from gpr20_analysis.read.doubts import survey_doubts
from gpr20_analysis.sentences import (
    LIST_ATTRIBUTES,
    first_of,
    sentences_of,
    with_doubts,
    with_sentences,
)
from gpr20_common.message import Message
from gpr20_common.terminal_text import storable

NETCDF = ".nc"
REAL, IMAGINARY = "_real", "_imag"
PART_OF = "complex_part_of"
OVERHEAD_BYTES = 1 << 20
CHECKED = {"driver_kwds": {"libver": ("v108", "v108")}}
"""The oldest structure of HDF5 files that has checksums."""
CONVENTIONS = "CF-1.9"
AXES = {dataset.X: "X", dataset.Y: "Y", dataset.DEPTH: "Z"}
"""Of images alone: the conventions want these axes last, but spectra end with the frequency."""
PLANE = {dataset.X: "projection_x_coordinate", dataset.Y: "projection_y_coordinate"}
STANDARD_NAMES = {dataset.DEPTH: "depth", dataset.HEIGHT: "height", dataset.TIMESTAMP: "time"}
ANCILLARY = (dataset.QUALITY, dataset.HEIGHT, dataset.TIMESTAMP)
VALUES: Dict[str, Tuple[str, ...]] = {
    dataset.S21: dataset.S21_DIMS,
    dataset.A_SCAN: (*dataset.SAMPLE_DIMS, dataset.DELAY),
    dataset.IMAGE: (dataset.POLARIZATION, dataset.DEPTH, dataset.Y, dataset.X),
    dataset.ANTENNA: dataset.ANTENNA_DIMS,
}
"""The variables that a Dataset may have, and their dimensions."""
ASCENDING = (dataset.Y, dataset.X, dataset.FREQUENCY, dataset.DELAY, dataset.DEPTH)


def write_dataset(data: xr.Dataset, path: Union[str, Path]) -> None:
    """Write any Dataset, complex variables included; the file is complete or does not exist.

    Args:
        data: The Dataset.
        path: Ends in .nc; an existing file is replaced.

    Raises:
        ExportError: The path has another ending, or it cannot be written.
    """
    path = Path(path).expanduser()
    if path.suffix != NETCDF:
        raise ExportError(wrong_ending(path, (NETCDF,)))
    stored = _with_conventions(_as_real(data))
    # xarray casts the times of missing samples by way of NaN, which numpy warns of.
    with np.errstate(invalid="ignore"), atomic_output(path, stored.nbytes + OVERHEAD_BYTES) as own:
        # to_netcdf imports distributed, which takes half a second, to ask for a cluster's locks.
        store = H5NetCDFStore.open(str(own), mode="w", lock=threading.Lock(), **CHECKED)
        try:
            stored.dump_to_store(store, encoding=_encoding(stored))
        finally:
            store.close()


def read_dataset(path: Path) -> xr.Dataset:
    """Read a Dataset written by `write_dataset`.

    Raises:
        UnreadableFileError: It is damaged, or not a Dataset.
        OSError: It cannot be read.
    """
    if not path.exists():
        raise AnalysisError(not_there(path), fault=faults.INPUT)
    try:
        stored = xr.open_dataset(str(path), engine="h5netcdf")
        with np.errstate(invalid="ignore"), stored:
            return _without_conventions(_as_complex(stored.load()))
    # On damaged files the libraries raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message("{path} is damaged or is not a Dataset", path=path, details=error)
        ) from error


def _as_real(data: xr.Dataset) -> xr.Dataset:
    variables: Dict[str, Any] = {}
    for name, values in data.data_vars.items():
        if np.issubdtype(values.dtype, np.complexfloating):
            for ending, part in ((REAL, values.real), (IMAGINARY, values.imag)):
                variables[f"{name}{ending}"] = part.assign_attrs({**values.attrs, PART_OF: name})
        else:
            variables[str(name)] = values
    stored = xr.Dataset(variables, data.coords, {})
    for key, value in data.attrs.items():
        if key in LIST_ATTRIBUTES or isinstance(value, (dict, list, tuple)):
            value = json.dumps(value)
        value = storable(value) if isinstance(value, str) else value
        stored.attrs[key] = int(value) if isinstance(value, (bool, np.bool_)) else value
    return stored


def _as_complex(stored: xr.Dataset) -> xr.Dataset:
    data = stored.copy()
    for name in list(stored.data_vars):
        whole = stored[name].attrs.get(PART_OF)
        if whole is None or not str(name).endswith(REAL):
            continue
        real, imaginary = stored[name], stored[f"{whole}{IMAGINARY}"]
        values = np.empty(real.shape, np.result_type(real.dtype, np.complex64))
        values.real, values.imag = real.values, imaginary.values
        kept = {key: value for key, value in real.attrs.items() if key != PART_OF}
        data[whole] = (real.dims, values, kept)
        data = data.drop_vars([f"{whole}{REAL}", f"{whole}{IMAGINARY}"])
    for key in LIST_ATTRIBUTES:
        if isinstance(data.attrs.get(key), str):
            data.attrs[key] = json.loads(data.attrs[key])
    return data


def _encoding(data: xr.Dataset) -> Dict[str, Dict[str, Any]]:
    """Return how variables are stored: numbers with checksums, coordinates without gaps."""
    found: Dict[str, Dict[str, Any]] = {}
    for name, values in data.variables.items():
        if values.ndim and values.size and values.dtype.kind in "iufbM":
            # A chunk is a row of traces, or of an image.
            chunks = tuple(1 for _ in values.dims[:-2]) + values.shape[-2:]
            found[str(name)] = {"fletcher32": True, "chunksizes": chunks}
    for name in data.dims:
        if name in data.coords:
            found.setdefault(str(name), {})["_FillValue"] = None
    return found


def _with_conventions(stored: xr.Dataset) -> xr.Dataset:
    """Return a Dataset without complex numbers with the attributes of the conventions."""
    data = stored.copy()
    for name in data.variables:
        own = {**_of_variable(data, str(name)), **data[name].attrs}
        if "flag_masks" in own:
            own["flag_masks"] = np.asarray(own["flag_masks"], data[name].dtype)
        data[name].attrs = own
    return data.assign_attrs({**_of_file(data), **data.attrs})


def _without_conventions(data: xr.Dataset) -> xr.Dataset:
    """Return a Dataset, complex again, without what `_with_conventions` has added."""
    for name in data.variables:
        own = data[name].attrs
        for key, value in _of_variable(data, str(name)).items():
            if str(own.get(key)) == value:
                del own[key]
        if "flag_masks" in own:
            own["flag_masks"] = np.asarray(own["flag_masks"]).tolist()
    for key, value in _of_file(data).items():
        if data.attrs.get(key) == value:
            del data.attrs[key]
    return dataset.described(data)


def _of_variable(data: xr.Dataset, name: str) -> Dict[str, str]:
    is_image = dataset.DEPTH in data.dims
    added = {"long_name": name.replace("_", " ")}
    if name in AXES and is_image:
        added["axis"] = AXES[name]
    if name in PLANE and is_image:
        added["standard_name"] = PLANE[name]
    if name == dataset.HEIGHT:
        added["positive"] = "up"
    if name in STANDARD_NAMES:
        added["standard_name"] = STANDARD_NAMES[name]
    beside = [one for one in ANCILLARY if one in data]
    if beside and set(dataset.SAMPLE_DIMS) < set(data[name].dims):
        added["ancillary_variables"] = " ".join(beside)
    return added


def _of_file(data: xr.Dataset) -> Dict[str, str]:
    title = f"GPR-20 survey {data.attrs.get('survey_id', '')}".rstrip()
    return {
        "Conventions": CONVENTIONS,
        "title": marked(title, data),
        "history": "written by gpr20_analysis",
    }


def checked(data: xr.Dataset, name: str, accept_damaged: bool = False) -> xr.Dataset:
    """Return a Dataset as `gpr20_analysis.dataset` describes it, or refuse it.

    Attribute `missing` names every sample without data, even if the file did not.

    Args:
        data: Content of a file.
        name: Name of the file, for messages.
        accept_damaged: Mark usable samples that contain NaN as damaged instead of refusing.

    Raises:
        UnreadableFileError: It contains neither spectra nor A-scans nor an image.
        DamagedSurveyError: Values of usable samples are NaN or infinite.
    """
    held = [one for one in VALUES if one in data]
    if not held:
        raise UnreadableFileError(
            Message(
                "{file} was not written by gpr20: it contains none of {needed}, only: {names}",
                file=name,
                needed=", ".join(VALUES),
                names=", ".join(sorted(map(str, data.data_vars))) or "-",
            ),
            fault=faults.INPUT,
        )
    for one in held:
        _check_form(data, one, VALUES[one], name)
        _check_axes(data, VALUES[one], name)
        if one in (dataset.IMAGE, dataset.ANTENNA):
            if not bool(np.isfinite(data[one]).all()):
                raise DamagedSurveyError(
                    Message("{file} is damaged: it contains NaN or infinite values", file=name),
                    fault=faults.FILE_DAMAGED,
                )
        else:
            data = _check_samples(data, one, name, accept_damaged)
    return data


def _check_form(data: xr.Dataset, one: str, dims: Tuple[str, ...], name: str) -> None:
    if one not in data or set(data[one].dims) != set(dims) or 0 in data[one].shape:
        found = data[one].sizes.items() if one in data else ()
        raise UnreadableFileError(
            Message(
                "{file}: '{variable}' has the dimensions {found}; it must have {needed}, none of "
                "them empty",
                file=name,
                variable=one,
                found=", ".join(f"{dim} {size}" for dim, size in found) or "-",
                needed=", ".join(dims),
            ),
            fault=faults.INPUT,
        )


def _check_axes(data: xr.Dataset, dims: Tuple[str, ...], name: str) -> None:
    for axis in dims:
        values = data[axis].values if axis in data.coords else np.array("")
        if values.dtype.kind not in "fiu":
            raise UnreadableFileError(
                Message("{file} has no coordinate '{axis}'", file=name, axis=axis),
                fault=faults.INPUT,
            )
        # Written so that NaN is refused too.
        if axis in ASCENDING and not (np.diff(values.astype(np.float64)) > 0).all():
            raise DamagedSurveyError(
                Message(
                    "{file} is damaged: the values of '{axis}' are not ascending",
                    file=name,
                    axis=axis,
                ),
                fault=faults.FILE_DAMAGED,
            )


def _check_samples(data: xr.Dataset, one: str, name: str, accept_damaged: bool) -> xr.Dataset:
    for variable in (dataset.QUALITY, dataset.HEIGHT):
        _check_form(data, variable, dataset.SAMPLE_DIMS, name)
    quality = data[dataset.QUALITY].transpose(*dataset.SAMPLE_DIMS)
    whole = (abs(data[one]) < np.inf).all(VALUES[one][-1]) & ~np.isinf(data[dataset.HEIGHT])
    spoilt = (dataset.usable(data) & ~whole).transpose(*dataset.SAMPLE_DIMS).values
    damaged = sentences_of(data, "faults")
    if spoilt.any():
        marked_as = quality.copy(data=np.where(spoilt, int(Quality.DAMAGED), quality.values))
        data = data.assign({dataset.QUALITY: marked_as.astype(quality.dtype)})
        positions = dataset.positions_of(data, spoilt)
        if not accept_damaged:
            raise DamagedSurveyError(
                Message(
                    "{file} is damaged: {count} samples that are marked as good contain NaN or "
                    "infinite values ({samples}); leave them out with --accept-damaged",
                    file=name,
                    count=len(positions),
                    samples=first_of(positions, dataset.NAMED),
                ),
                fault=faults.FILE_DAMAGED,
            )
        data = data.assign({one: data[one].where(~quality.copy(data=spoilt))})
        damaged += [
            Message("{file}: {position}: NaN or infinite values", file=name, position=position)
            for position in positions
        ]
        data = with_doubts(data, *survey_doubts({}, (), len(positions)))
    missing = [*sentences_of(data, "missing"), *dataset.missing_samples(data)]
    missing = list({str(one): one for one in missing}.values())
    attributes = {"notes": [], **data.attrs}
    return data.assign_attrs(with_sentences(attributes, missing=missing, faults=damaged))

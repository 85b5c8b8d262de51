"""Datasets of surveys, A-scans, images and models as NetCDF, which is HDF5, by the CF conventions.

CF 1.9 is the first version with unsigned bytes and 64-bit integers. NetCDF knows no complex
numbers: a complex variable `s21` is stored as `s21_real` and `s21_imag`. HDF5 itself checks the
numbers and the structure of a file (Fletcher's checksum, format 1.8), so that a changed byte is an
error and no echo.

A survey also as a table for spreadsheets, with a line per sample.
"""

from __future__ import annotations

import json
import re
import threading
from pathlib import Path
from typing import Any, Dict, Tuple, Union

import h5netcdf
import numpy as np
import xarray as xr
from xarray.backends import H5NetCDFStore

from gpr20_analysis import dataset, errors
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.dataset import aux_names
from gpr20_analysis.errors import (
    AnalysisError,
    DamagedSurveyError,
    UnreadableFileError,
    WrongDatasetError,
    check_ending,
    not_there,
)
from gpr20_analysis.sentences import DOUBTS, LIST_ATTRIBUTES, sentences_of, with_sentences
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable, storable

NETCDF = ".nc"
REAL, IMAGINARY = "_real", "_imag"
PART_OF = "complex_part_of"
OVERHEAD_BYTES = 1 << 20
CHECKED = ("v108", "v108")
"""The oldest structure of HDF5 files that has checksums."""
OF_FILE = ("Conventions", "title", "history")
"""Attributes that a file has and a Dataset has not."""
VALUES: Dict[str, Tuple[str, ...]] = {
    dataset.S21: dataset.S21_DIMS,
    dataset.A_SCAN: (*dataset.SAMPLE_DIMS, dataset.DELAY),
    dataset.IMAGE: (dataset.POLARIZATION, dataset.DEPTH, dataset.Y, dataset.X),
    dataset.ANTENNA: dataset.ANTENNA_DIMS,
}
"""The variables that a Dataset may have, and their dimensions."""
ASCENDING = (dataset.Y, dataset.X, dataset.FREQUENCY, dataset.DELAY, dataset.DEPTH)
FACTS = "index,x_m,y_m,polarization_deg,height_m,timestamp,quality,simulated,doubts"
# A quote at the beginning of a cell would make one cell of the lines after it.
_FORMULA = '\'*(?="|[ \u00a0"]*[=+\\-@\uff1d\uff0b\uff0d\uff20\t\r\n])'
_PLACE = re.compile(f"(?:^|(?<=[,;\t\r\n])){_FORMULA}")
_NUMBER = re.compile(r"[-+]?[0-9]+([.][0-9]+)?")


def write_dataset(data: xr.Dataset, path: Union[str, Path]) -> None:
    """Write any Dataset, complex variables included; the file is complete or does not exist.

    Args:
        data: The Dataset.
        path: Ends in .nc; an existing file is replaced.

    Raises:
        AnalysisError: The path has another ending, or it cannot be written.
    """
    path = Path(path).expanduser()
    check_ending(path, (NETCDF,))
    stored = _as_real(dataset.described(data.copy()))
    title = f"GPR-20 survey {data.attrs.get('survey_id', '')}".rstrip()
    title += " (SIMULATED)" if dataset.is_simulated(data) else ""
    of_file = ("CF-1.9", title, "written by gpr20_analysis")
    stored.attrs.update(zip(OF_FILE, of_file))
    # The conventions want these last where there is a depth; spectra end with the frequency.
    for axis in (dataset.Y, dataset.X) if dataset.DEPTH in stored.dims else ():
        as_plane = {"axis": axis.upper(), "standard_name": f"projection_{axis}_coordinate"}
        stored[axis].attrs.update(as_plane)
    # xarray casts the times of missing samples by way of NaN, which numpy warns of.
    with np.errstate(invalid="ignore"), atomic_output(path, stored.nbytes + OVERHEAD_BYTES) as own:
        # to_netcdf imports distributed, where it is installed, to ask for a cluster's locks.
        file = h5netcdf.File(str(own), "w", libver=CHECKED)
        store = H5NetCDFStore(file, mode="w", lock=threading.Lock())
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
        raise AnalysisError(not_there(path), fault=errors.INPUT)
    try:
        stored = xr.open_dataset(str(path), engine="h5netcdf", decode_timedelta=False)
        with np.errstate(invalid="ignore"), stored:
            return dataset.described(_as_complex(stored.load()))
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
    for key in OF_FILE:
        data.attrs.pop(key, None)
    for axis in {dataset.Y, dataset.X} & data.coords.keys():
        for key in ("axis", "standard_name"):
            data[axis].attrs.pop(key, None)
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
            if values.dtype.kind == "M" and values.isnull().all():
                # Where no moment is known pandas looks for a unit for 0.1 s.
                found[str(name)]["units"] = "days since 1970-01-01 00:00:00"
    for name in data.dims:
        if name in data.coords:
            found.setdefault(str(name), {})["_FillValue"] = None
    return found


def checked(data: xr.Dataset, name: str) -> xr.Dataset:
    """Return a Dataset as `gpr20_analysis.dataset` describes it, or refuse it.

    Attribute `missing` names every sample without data, even if the file did not.

    Args:
        data: Content of a file.
        name: Name of the file, for messages.

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
            fault=errors.INPUT,
        )
    for one in held:
        dims = VALUES[one]
        beside = (dataset.QUALITY, dataset.HEIGHT) if one in (dataset.S21, dataset.A_SCAN) else ()
        try:
            values = dataset.require(data, one, dims)
            for variable in beside:
                dataset.require(data, variable, dataset.SAMPLE_DIMS)
        except WrongDatasetError as error:
            reason = Message("{file}: {reason}", file=name, reason=error.message)
            raise UnreadableFileError(reason, fault=errors.INPUT) from error
        _check_axes(data, dims, name)
        whole = abs(values) < np.inf
        if beside:
            is_there = whole.all(dims[-1]) & ~np.isinf(data[dataset.HEIGHT])
            whole = is_there | ~dataset.usable(data)
        if not whole.all():
            raise DamagedSurveyError(
                Message("{file} is damaged: it contains NaN or infinite values", file=name),
                fault=errors.FILE_DAMAGED,
            )
    if dataset.QUALITY not in data:
        return data
    missing = [*sentences_of(data, "missing"), *dataset.missing_samples(data)]
    missing = list({str(one): one for one in missing}.values())
    attributes = {"notes": [], "faults": [], **data.attrs}
    return data.assign_attrs(with_sentences(attributes, missing=missing))


def _check_axes(data: xr.Dataset, dims: Tuple[str, ...], name: str) -> None:
    for axis in dims:
        values = data[axis].values if axis in data.coords else np.array("")
        if values.dtype.kind not in "fiu" or not values.size:
            raise UnreadableFileError(
                Message("{file} has no coordinate '{axis}'", file=name, axis=axis),
                fault=errors.INPUT,
            )
        # Written so that NaN is refused too.
        if axis in ASCENDING and not (np.diff(values.astype(np.float64)) > 0).all():
            raise DamagedSurveyError(
                Message(
                    "{file} is damaged: the values of '{axis}' are not ascending",
                    file=name,
                    axis=axis,
                ),
                fault=errors.FILE_DAMAGED,
            )


def csv_cell(value: Any) -> Any:
    """Return a value as a cell of a CSV file; numbers, also those in a text, stay as they are.

    Texts that people type, or that a file holds, may begin like a formula, which a spreadsheet runs
    when it opens the file. They get an apostrophe before that; `cell_text` takes it away again. The
    same holds behind a comma, semicolon, tab or line break in a text: a spreadsheet that expects
    another separator, as in countries with a decimal comma, begins a new cell there, whatever the
    quotes say.
    """
    if value is None:
        return ""
    if not isinstance(value, str) or _NUMBER.fullmatch(value):
        return value
    return _PLACE.sub(lambda found: f"'{found.group()}", value)


def cell_text(cell: str) -> str:
    """Return the text of a cell that a CSV file of gpr20 holds, without what protects it."""
    return _PLACE.sub(lambda found: found.group()[1:], cell)


def write_plain_csv(survey: xr.Dataset, path: Path, progress: Progress = no_progress) -> int:
    """Write the table and return its number of samples; those without data are left out.

    Values of other sensors are in columns such as `aux_soil_moisture [m3/m3]`. Numbers have as many
    digits as are needed to read back the same float64.

    Raises:
        OSError: The file exists or cannot be written.
    """
    s21 = dataset.require(survey, dataset.S21, dataset.S21_DIMS).values
    columns = [
        f"{part}_{frequency_hz!r}_hz"
        for frequency_hz in survey[dataset.FREQUENCY].values.tolist()
        for part in ("real", "imag")
    ]
    index, height_m, timestamp, quality = (
        dataset.require(survey, name, dataset.SAMPLE_DIMS).values
        for name in ("index", dataset.HEIGHT, dataset.TIMESTAMP, dataset.QUALITY)
    )
    # Empty if it is not known.
    simulated = str(int(dataset.is_simulated(survey))) if dataset.SIMULATED in survey.attrs else ""
    codes = " ".join(one.fault_code for one in sentences_of(survey, DOUBTS))
    aux = [survey[name].transpose(*dataset.SAMPLE_DIMS) for name in aux_names(survey)]
    turns_deg, y_m, x_m = (survey[axis].values for axis in dataset.SAMPLE_DIMS)
    usable = dataset.usable(survey).transpose(*dataset.SAMPLE_DIMS).values
    places = [tuple(place) for place in np.argwhere(usable)]
    with path.open("x", encoding="utf-8", newline="") as stream:
        stream.write(",".join([FACTS, *map(_heading, aux), *columns]) + "\n")
        for place in progress(places, len(places)):
            position = (x_m[place[2]], y_m[place[1]], turns_deg[place[0]], height_m[place])
            numbers = np.ascontiguousarray(s21[place]).view(np.float64).tolist()
            words = [
                str(index[place]),
                *(repr(float(one)) for one in position),
                str(csv_cell(str(timestamp[place]))),
                str(quality[place]),
                simulated,
                codes,
                *(repr(float(one.values[place])) for one in aux),
                *map(repr, numbers),
            ]
            stream.write(",".join(words) + "\n")
    return len(places)


def _heading(aux: xr.DataArray) -> str:
    """Return the heading of a column; a unit has no commas and quotes there."""
    unit = "".join(one for one in printable(str(aux.attrs.get("units", ""))) if one not in ',"')
    return str(csv_cell(f"{aux.name} [{unit}]" if unit else str(aux.name)))

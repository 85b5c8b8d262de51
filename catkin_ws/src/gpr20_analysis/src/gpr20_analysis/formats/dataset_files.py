"""Datasets of surveys, A-scans and images as NetCDF and Zarr.

NetCDF files follow the CF conventions. NetCDF knows no complex numbers: a complex variable `s21` is
stored as `s21_real` and `s21_imag`.
"""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any, Dict, Optional, Union

import h5py
import numpy as np
import xarray as xr
from xarray.backends import H5NetCDFStore

from gpr20_analysis import faults
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.dataset import Y
from gpr20_analysis.errors import (
    AnalysisError,
    ExportError,
    MissingLibraryError,
    UnreadableFileError,
    library_missing,
    not_there,
    wrong_ending,
)
from gpr20_analysis.formats.cf_conventions import (
    encoding,
    with_conventions,
    without_conventions,
)
from gpr20_analysis.formats.checksums import add_checksum, has_checksum
from gpr20_analysis.formats.zarr_codecs import refuse_unsafe_codecs
from gpr20_analysis.sentences import LIST_ATTRIBUTES, with_notes
from gpr20_common.message import Message
from gpr20_common.terminal_text import storable
from gpr20_survey.files.file_sums import regular_files
from gpr20_survey.files.regular_file import check_regular

NETCDF, ZARR = ".nc", ".zarr"
REAL, IMAGINARY = "_real", "_imag"
PART_OF = "complex_part_of"
OVERHEAD_BYTES = 1 << 20
LEAST_LAZY_DIMS = 4
CHUNK_BYTES = 16 << 20
"""Lazy data that each thread has in memory at once; a step may need eight times as much."""


def is_dataset(path: Path) -> bool:
    """Return whether a path has the ending of a Dataset written by `write_dataset`."""
    return path.suffix in (NETCDF, ZARR)


def write_dataset(data: xr.Dataset, path: Union[str, Path]) -> None:
    """Write any Dataset, complex variables included; the file is complete or does not exist.

    Args:
        data: In memory or lazy.
        path: Ends in .nc or .zarr; an existing file is replaced.

    Raises:
        AnalysisError: The path has another ending.
        ExportError: It cannot be written.
    """
    path = Path(path).expanduser()
    if not is_dataset(path):
        raise ExportError(wrong_ending(path, (NETCDF, ZARR)))
    stored = with_conventions(_as_real(data))
    # xarray casts the times of missing samples by way of NaN, which numpy warns of.
    with np.errstate(invalid="ignore"), atomic_output(path, _size(stored)) as place:
        if path.suffix == ZARR:
            stored.to_zarr(str(place), mode="w", consolidated=True, **_zarr_format())
        else:
            _write_netcdf(stored, place)
        add_checksum(place)


def _write_netcdf(stored: xr.Dataset, path: Path) -> None:
    if stored.chunks:
        stored.to_netcdf(str(path), engine="h5netcdf", encoding=encoding(stored))
        return
    # to_netcdf imports distributed, which takes half a second, to ask for a cluster's locks.
    store = H5NetCDFStore.open(str(path), mode="w", lock=threading.Lock())
    try:
        stored.dump_to_store(store, encoding=encoding(stored))
    finally:
        store.close()


def _size(stored: xr.Dataset) -> int:
    return int(stored.nbytes) + OVERHEAD_BYTES


def read_dataset(path: Path, lazy_bytes: Optional[int] = None) -> xr.Dataset:
    """Read a Dataset written by `write_dataset`.

    Args:
        path: Ends in .nc or .zarr.
        lazy_bytes: Spectra, A-scans or an image larger than this [bytes] become a dask array in
            chunks of whole rows; everything else is read into memory. None: everything is.

    Raises:
        UnreadableFileError: It is damaged, or not a Dataset.
        MissingLibraryError: zarr is not installed.
        OSError: It cannot be read.
    """
    if not path.exists():
        raise AnalysisError(not_there(path), fault=faults.INPUT)
    if path.is_dir():
        for name in regular_files(path):
            check_regular(path / name)
    if path.suffix == NETCDF and not h5py.is_hdf5(str(path)):
        raise AnalysisError(
            Message("{path} is not a NetCDF file of version 4 (HDF5)", path=path),
            fault=faults.INPUT,
        )
    checked = has_checksum(path)
    try:
        with np.errstate(invalid="ignore"):
            data = _read(path, lazy_bytes)
    except (MissingLibraryError, UnreadableFileError):
        raise
    # On damaged files the libraries raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message("{path} is damaged or is not a Dataset", path=path, details=error)
        ) from error
    if not checked:
        note = Message(
            "{file} has no gpr20 checksum, so changes on the disk cannot be detected",
            file=path.name,
        )
        data = data.assign_attrs(with_notes(data, [note]))
    return data


def _read(path: Path, lazy_bytes: Optional[int]) -> xr.Dataset:
    if path.suffix == ZARR:
        _zarr_version()
        refuse_unsafe_codecs(path)
        stored = xr.open_zarr(str(path), chunks=None)
        return _as_complex(_loaded(stored, lazy_bytes))
    stored = xr.open_dataset(str(path), engine="h5netcdf")
    try:
        data = _as_complex(_loaded(stored, lazy_bytes))
    except BaseException:
        stored.close()
        raise
    # Lazy data are read from the open file later.
    if not data.chunks:
        stored.close()
    return data


def _loaded(stored: xr.Dataset, lazy_bytes: Optional[int]) -> xr.Dataset:
    """Return a Dataset in memory, except variables larger than so many bytes."""
    data = stored
    for name, values in stored.variables.items():
        # The other half of a complex variable is as large.
        size = values.nbytes * (2 if PART_OF in values.attrs else 1)
        if lazy_bytes is None or size <= lazy_bytes or values.ndim < LEAST_LAZY_DIMS:
            data[name].load()
        else:
            row_bytes = values.nbytes // (values.sizes[values.dims[0]] * values.sizes[Y])
            rows = max(1, CHUNK_BYTES // (2 * row_bytes))
            whole = dict.fromkeys(values.dims, -1)
            chunks = {**whole, values.dims[0]: 1, Y: rows}
            data = data.assign({name: stored[name].chunk(chunks)})
    return data


def _zarr_format() -> Dict[str, Any]:
    """Return the arguments for writing Zarr format 2, which every version of zarr reads."""
    return {} if _zarr_version() < 3 else {"zarr_format": 2}


def _zarr_version() -> int:
    try:
        from zarr import __version__
    except ImportError as error:
        raise MissingLibraryError(library_missing("zarr", "zarr")) from error
    return int(__version__.split(".")[0])


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
        stored.attrs[key] = _plain(key, value)
    return stored


def _plain(key: str, value: Any) -> Any:
    if key in LIST_ATTRIBUTES or isinstance(value, (dict, list, tuple)):
        return json.dumps(value)
    if isinstance(value, str):
        return storable(value)
    return int(value) if isinstance(value, (bool, np.bool_)) else value


def _kind(real: Any) -> Any:
    return np.result_type(real, np.complex64)


def _joined(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    values = np.empty(real.shape, _kind(real.dtype))
    values.real, values.imag = real, imaginary
    return values


def _as_complex(stored: xr.Dataset) -> xr.Dataset:
    data = stored.copy()
    for name in list(stored.data_vars):
        whole = stored[name].attrs.get(PART_OF)
        if whole is None or not str(name).endswith(REAL):
            continue
        real, imaginary = stored[name], stored[f"{whole}{IMAGINARY}"]
        if real.chunks is None:
            values = _joined(real.values, imaginary.values)
        else:
            import dask.array  # its import takes 0.3 s

            kind = _kind(real.dtype)
            values = dask.array.map_blocks(_joined, real.data, imaginary.data, dtype=kind)
        kept = {key: value for key, value in real.attrs.items() if key != PART_OF}
        data[whole] = (real.dims, values, kept)
        data = data.drop_vars([f"{whole}{REAL}", f"{whole}{IMAGINARY}"])
    for key in LIST_ATTRIBUTES:
        if isinstance(data.attrs.get(key), str):
            data.attrs[key] = json.loads(data.attrs[key])
    return without_conventions(data)

"""Plain arrays of any program with documented names: spectra or A-scans, and their axes."""

from __future__ import annotations

import math
import os
import zipfile
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis import dataset, work
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.common import EVEN, HIGHEST_M, on_grid
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.read.survey_attributes import ANTENNA_DELAY
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_foreign_formats.header import Header, other_kind
from gpr20_survey.files.regular_files import open_regular

S21, A_SCANS, FREQUENCY, TIME, HEIGHT = "s21", "a_scans", "frequency_hz", "time_s", "height_m"
LAST = {S21: FREQUENCY, A_SCANS: TIME}
PLACES = ("rotation_deg", "y_m", "x_m")
ASSUMED = {"rotation_deg": 0.0, "y_m": 0.0}
DELAY = "delay_s"
# Beyond these the unit is another one, such as GHz or ns.
LIMITS: Dict[str, Tuple[float, float]] = {
    FREQUENCY: (1e6, 1e12),
    TIME: (-1e-4, 1e-4),
    HEIGHT: (0.0, HIGHEST_M),
    DELAY: (-1e-5, 1e-5),
    "x_m": (-1e7, 1e7),
    "y_m": (-1e7, 1e7),
    "rotation_deg": (-360.0, 360.0),
}
COPIES = 3.0  # of an array: as stored, in double precision, and in another order
PAIRS = [np.dtype([("real", one), ("imag", one)]) for one in ("f4", "f8")]
ENDINGS = (".npz", ".mat", ".h5", ".hdf5")


def read_arrays(path: Path, options: ImportOptions, _: Progress) -> xr.Dataset:
    """Read spectra or A-scans (rotation, y, x, frequency or time), or a list (trace, ...).

    Dimensions of one place may be missing.

    Raises:
        UnreadableFileError: The file is damaged, or an array is missing or wrong.
    """
    found = _arrays_in(path, (*LAST, *LIMITS))
    name, kinds = path.name, [one for one in LAST if one in found]
    if len(kinds) != 1:
        one = Message("one complex array {s21} or one real {a_scans}", s21=S21, a_scans=A_SCANS)
        raise Header(name, {"its data": ", ".join(kinds)} if kinds else {}).refused("its data", one)
    (kind,) = kinds
    last, values = LAST[kind], np.squeeze(found[kind])
    if values.dtype.kind not in ("c" if kind == S21 else "fiu"):
        needed = Message("complex") if kind == S21 else Message("real")
        raise Header(name, {kind: values.dtype}).refused(kind, needed)
    axes = {key: np.ravel(_numbers(name, found, key, ASSUMED.get(key))) for key in PLACES}
    axis = _axis(name, found, last)
    positions, shape = _positions(name, kind, values, axes, axis)
    given_m = np.squeeze(_numbers(name, found, HEIGHT, np.nan))
    if given_m.shape not in ((), shape):
        each = Message("one value, or one for each trace: {shape}", shape=_text(shape))
        raise Header(name, {HEIGHT: _text(given_m.shape)}).refused(HEIGHT, each)
    height_m = np.broadcast_to(given_m if options.height_m is None else options.height_m, shape)
    notes = [
        Message("{file} has no {key}: {value:g} is assumed", file=name, key=key, value=value)
        for key, value in ASSUMED.items()
        if key not in found
    ]
    if kind == A_SCANS and DELAY not in found:
        notes.append(
            Message(
                "{file} has no {key}: its time zero is taken as 0, so depths are too large; store "
                "it there, or give --delay to gpr20 image",
                file=name,
                key=DELAY,
            )
        )
    survey = on_grid(
        printable(name),
        positions * (1.0, dataset.MM_PER_M, dataset.MM_PER_M),
        values.reshape(len(positions), -1),
        height_m.ravel().tolist(),
        axis if kind == S21 else None,
        notes,
        delay_s=axis if kind == A_SCANS else None,
    )
    if DELAY not in found:
        return survey
    return survey.assign_attrs({ANTENNA_DELAY: float(_numbers(name, found, DELAY).ravel()[0])})


def _numbers(
    file: str, found: Mapping[str, np.ndarray], key: str, default: Optional[float] = None
) -> np.ndarray:
    """Return the numbers of a key, which must be in its range."""
    values = found.get(key, np.empty(0) if default is None else np.array(default))
    if values.dtype.kind not in "fiub" or not values.size:
        text = str(values.dtype) if values.size else "missing"
        raise Header(file, {key: text}).refused(key, Message("an array of real numbers"))
    values, (lowest, highest) = values.astype(np.float64), LIMITS[key]
    # Only heights may be unknown.
    good = (values >= lowest) & (values <= highest) | ((key == HEIGHT) & np.isnan(values))
    for wrong in values[~good][:1]:
        Header(file, {key: f"{wrong:g}"}).number(key, lowest, highest)
    return values


def _axis(file: str, found: Mapping[str, np.ndarray], key: str) -> np.ndarray:
    """Return the frequencies or times, which must ascend, times in even steps."""
    axis = np.ravel(_numbers(file, found, key))
    steps = np.diff(axis)
    uneven = key == TIME and steps.size and np.ptp(steps) > EVEN * abs(steps.mean())
    if uneven or not (steps.size and steps.min() > 0.0):
        ends = {key: f"{len(axis)} values from {axis[0]:g} to {axis[-1]:g}"}
        allowed = Message("two or more that ascend, times in equal steps")
        raise Header(file, ends).refused(key, allowed)
    return axis


def _positions(
    file: str, kind: str, values: np.ndarray, axes: Mapping[str, np.ndarray], axis: np.ndarray
) -> Tuple[np.ndarray, Tuple[int, ...]]:
    """Return rotation [deg], y and x [m] of each trace, and the dimensions of the traces."""
    sizes = {key: len(axes[key]) for key in PLACES if len(axes[key]) > 1}
    whole = tuple(sizes.values())
    if values.shape == (*whole, len(axis)):
        grids = np.meshgrid(*axes.values(), indexing="ij")
        return np.stack([one.ravel() for one in grids], axis=1), whole
    counts = {*whole}
    if len(counts) == 1 and values.shape == (*counts, len(axis)):
        columns = np.broadcast_arrays(*axes.values())
        return np.stack(columns, axis=1), tuple(counts)
    allowed = Message(
        "{shape} ({names}), or a list of traces; transpose it, or correct the axes",
        shape=_text((*whole, len(axis))),
        names=", ".join((*sizes, LAST[kind])),
    )
    raise Header(file, {kind: _text(values.shape)}).refused(kind, allowed)


def _text(shape: Sequence[int]) -> str:
    return " x ".join(map(str, shape)) or "1"


def _arrays_in(path: Path, names: Sequence[str]) -> Dict[str, np.ndarray]:
    """Return those of the named arrays that a file has.

    Objects, which Python would make by running code of the file, are refused. Of MATLAB's files
    those of version 7.3 are HDF5; scipy's reader of older ones ends the program on damaged files.

    Raises:
        UnreadableFileError: It is no file of arrays, damaged, or an array holds no plain values.
        TooLargeError: The arrays do not fit into the memory.
        OSError: The file cannot be opened.
    """
    os.close(open_regular(path, follow_link=True))
    try:
        if h5py.is_hdf5(str(path)):
            return _hdf5(path, names)
        if zipfile.is_zipfile(str(path)):
            return _npz(path, names)
    except AnalysisError:
        raise
    # On damaged files zipfile, numpy and HDF5 raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message(
                "{file} is damaged, or does not hold its numbers as plain arrays",
                file=path.name,
                details=error,
            )
        ) from error
    raise other_kind(path.name, "NumPy (.npz) or HDF5, as MATLAB writes it with -v7.3")


def _require_room(path: Path, *sizes: int) -> None:
    # With Python's integers, which do not overflow.
    needed = COPIES * math.prod(map(int, sizes))
    work.require_bytes(needed, Message("reading {file}", file=path.name))


def _npz(path: Path, names: Sequence[str]) -> Dict[str, np.ndarray]:
    with np.load(str(path), allow_pickle=False) as stored:
        present = [one for one in names if one in stored.files]
        _require_room(path, sum(stored.zip.getinfo(f"{one}.npy").file_size for one in present))
        return {one: stored[one] for one in present}


def _hdf5(path: Path, names: Sequence[str]) -> Dict[str, np.ndarray]:
    found: Dict[str, np.ndarray] = {}
    with h5py.File(str(path), "r") as file:
        stored: Any
        for name, stored in ((one, file[one]) for one in names if one in file):
            _require_room(path, stored.dtype.itemsize, *stored.shape)
            # Others are not read: a damaged type can make HDF5 write beyond its memory.
            if stored.dtype.kind not in "fciu" and stored.dtype not in PAIRS:
                raise ValueError(f"{name} is {stored.dtype}")
            values = np.asarray(stored[()])
            # MATLAB stores complex numbers as pairs, and dimensions backwards.
            if stored.dtype in PAIRS:
                values = values["real"] + 1j * values["imag"]
            found[name] = values.T if "MATLAB_class" in stored.attrs else values
    return found


def _whole(path: Path) -> Optional[Path]:
    if path.suffix not in ENDINGS or not path.is_file():
        return None
    try:
        names = {*_arrays_in(path, (*LAST, *LAST.values()))}
    except (AnalysisError, OSError):
        return None  # what is damaged is not recognized
    return path if any({*one} <= names for one in LAST.items()) else None


IMPORT = ImportFormat(read_arrays, _whole, ("band", "height_m"))

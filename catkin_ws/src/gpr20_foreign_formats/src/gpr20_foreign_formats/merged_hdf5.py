"""The merged HDF5 file of the GPR-20 group: all A-scans of a survey, over frequency or time."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis import work
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.formats.common import HIGHEST_M
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_foreign_formats.group_files import (
    DEGREES,
    FARTHEST_MM,
    HIGHEST_HZ,
    LETTERS_DECIDED,
    MOST_POINTS,
    Samples,
    check_sweep,
    survey_of,
)
from gpr20_foreign_formats.header import BYTES_PER_SAMPLE, Header, hdf5_with, opened_hdf5

FREQUENCY, TIME = "Frequency", "Time"
QUANTITY = {FREQUENCY: "S21", TIME: "A-Scan"}
RANGE = {FREQUENCY: ("f0", "ff", "df"), TIME: ("t0", "tf", "dt")}
AMOUNT = "Total Amount of A-Scans"
HZ_PER_MHZ = 1e6
ORDER_DECIDED = Message(
    "places and heights are in metres; x changes slowest from scan to scan, as the group's program "
    "sorts them"
)
FARTHEST_M = FARTHEST_MM / MM_PER_M
LARGEST_MHZ = 1e6  # a lower start frequency is in MHz, as in the guide


def read_merged(path: Path, _: ImportOptions, __: Progress) -> xr.Dataset:
    """Read such a file.

    Raises:
        UnreadableFileError: It is damaged, or the positions of its scans are unknown.
    """
    with opened_hdf5(path, "merged HDF5", "A-Scan", "Position") as file:
        return survey_of(path, _samples(file, path.name))


def _samples(file: Any, name: str) -> Samples:
    kind = FREQUENCY if FREQUENCY in file else TIME
    notes = [Message("this format stores single precision, about seven digits")]
    decisions = [ORDER_DECIDED, LETTERS_DECIDED]
    axis = _axis(file, name, kind, decisions)
    x_m, y_m = _places(file, name, "x"), _places(file, name, "y")
    letters = [one for one in DEGREES if _scan(one, "Re", kind) in file["A-Scan"]]
    if not letters:
        wanted = {"x_scan": _scan("X", "Re", kind), "y_scan": _scan("Y", "Re", kind)}
        found = Header(name, {"A-Scan": ", ".join(file["A-Scan"])})
        raise found.refused("A-Scan", Message("{x_scan} or {y_scan}", **wanted))
    count, amount = len(x_m) * len(y_m), float(len(letters) * len(x_m) * len(y_m))
    Header(name, {AMOUNT: amount, **file.attrs}, typed=True).number(AMOUNT, amount, amount)
    size = BYTES_PER_SAMPLE * len(axis) * amount
    work.require_bytes(size, Message("reading {file}", file=name))
    scans, heights_m = [], []
    for letter in letters:
        real, imaginary = (_scan(letter, word, kind) for word in ("Re", "Im"))
        scan = _scans(file, real, name, count, len(axis)).astype(np.complex128)
        if imaginary in file["A-Scan"] or kind == FREQUENCY:
            scan.imag = _scans(file, imaginary, name, count, len(axis))
        else:
            notes.append(Message("{scan} does not exist, so the A-scans are real", scan=imaginary))
        scans.append(scan)
        heights_m.append(np.broadcast_to(_heights(file, name, letter, count), count))
    places = [(letter, x, y) for letter in letters for x in x_m for y in y_m]
    return Samples(
        [f"{name} x {x:g} m, y {y:g} m, {letter}" for letter, x, y in places],
        np.array([(DEGREES[letter], y * MM_PER_M, x * MM_PER_M) for letter, x, y in places]),
        np.concatenate(scans),
        np.concatenate(heights_m),
        frequency_hz=axis if kind == FREQUENCY else None,
        delay_s=axis if kind == TIME else None,
        notes=notes,
        decisions=decisions,
    )


def _scan(letter: str, word: str, kind: str) -> str:
    return f"{word}{{{QUANTITY[kind]} {letter.lower()}-pol}}"


def _axis(file: Any, name: str, kind: str, decisions: List[Message]) -> np.ndarray:
    group = file.get(kind)
    described = Header(name, getattr(group, "attrs", {}), typed=True)
    start, stop, step = (described.number(one, -HIGHEST_HZ, HIGHEST_HZ) for one in RANGE[kind])
    count = described.count("q", 1, MOST_POINTS)
    # The guide divides by the number of points where its program divides by one less.
    if not (count > 1 and step > 0.0 and abs(start + (count - 1) * step - stop) <= 1.01 * step):
        values = {"count": count, "start": start, "stop": stop}
        allowed = Message("the step of {count} points from {start:g} to {stop:g}", **values)
        raise described.refused(RANGE[kind][2], allowed)
    if kind == FREQUENCY and start < LARGEST_MHZ:
        decisions.append(Message("the frequencies were read as MHz"))
        start, stop = start * HZ_PER_MHZ, stop * HZ_PER_MHZ
    if kind == FREQUENCY:
        check_sweep(name, start, stop)
    return np.linspace(start, stop, count)


def _places(file: Any, name: str, axis: str) -> np.ndarray:
    position = Header(name, {f"d{axis}": 0.0, **file["Position"].attrs}, typed=True)
    keys = (f"{axis}0", f"{axis}f", f"d{axis}")
    start, stop, step = (position.number(one, -FARTHEST_M, FARTHEST_M) for one in keys)
    count = 1 if step == 0.0 else round((stop - start) / step) + 1
    if not 1 <= count <= MOST_POINTS or abs(start + (count - 1) * step - stop) > 0.01 * abs(step):
        allowed = Message("a step from {start:g} to {stop:g} m", start=start, stop=stop)
        raise position.refused(keys[2], allowed)
    return np.linspace(start, stop, count)


def _scans(file: Any, scan: str, name: str, count: int, points: int) -> np.ndarray:
    found = _numbers(file, name, f"A-Scan/{scan}")
    if found.shape == (points, count) and points != count:
        found = found.T  # as MATLAB stores it
    if found.shape != (count, points):
        size = {"positions": count, "points": points}
        allowed = Message("{positions} positions of {points} points", **size)
        found_shape = " x ".join(map(str, found.shape))
        raise Header(name, {scan: found_shape}).refused(scan, allowed)
    return found


def _heights(file: Any, name: str, letter: str, count: int) -> Any:
    position, own = file["Position"], f"h {letter.lower()}-pol"
    if own in position:
        found = _numbers(file, name, f"Position/{own}")
        if found.size != count:
            raise Header(name, {own: found.size}).refused(own, Message("one of each A-scan"))
        return found.astype(np.float64).ravel()
    height_m = position.attrs.get("h")
    if height_m is None or isinstance(height_m, str):
        return np.nan
    return Header(name, position.attrs, typed=True).number("h", 0.0, HIGHEST_M)


def _numbers(file: Any, name: str, path: str) -> np.ndarray:
    found = file.get(path)
    if not isinstance(found, h5py.Dataset) or found.dtype.kind not in "iuf":
        kind = {path: getattr(found, "dtype", None) or "-"}
        raise Header(name, kind).refused(path, Message("an array of numbers"))
    return np.asarray(found[()])


IMPORT = ImportFormat(read_merged, lambda path: hdf5_with(path, "A-Scan", "Position"), ("band",))

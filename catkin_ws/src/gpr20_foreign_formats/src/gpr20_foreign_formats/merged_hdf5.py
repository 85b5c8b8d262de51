"""The merged HDF5 file of the GPR-20 group: all A-scans of a survey, over frequency or time."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults, lazy
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.checksums import add_checksum, has_checksum
from gpr20_analysis.formats.common import HIGHEST_M, Imported, as_dataset, even_step
from gpr20_analysis.formats.format import ExportFormat, ImportFormat, ImportOptions
from gpr20_analysis.formats.provenance import SIMULATED, SIMULATED_KEY, kept, marked, restored
from gpr20_analysis.progress import Progress
from gpr20_common.message import Message
from gpr20_foreign_formats.group_files import (
    DECIDED,
    DEGREES,
    FARTHEST_MM,
    HIGHEST_HZ,
    MOST_POINTS,
    PHASE_DECIDED,
    CheckedTraces,
    check_sweep,
    letters,
)
from gpr20_foreign_formats.header import Header
from gpr20_foreign_formats.lost_imaginary import with_imaginary_parts

COMPRESSION: Dict[str, Any] = {"compression": "gzip", "compression_opts": 4}
GROUP = {dataset.S21: "Frequency", dataset.A_SCAN: "Time"}
QUANTITY = {dataset.S21: "S21", dataset.A_SCAN: "A-Scan"}
RANGE = {dataset.S21: ("f0", "ff", "df"), dataset.A_SCAN: ("t0", "tf", "dt")}
LAST = {dataset.S21: dataset.FREQUENCY, dataset.A_SCAN: dataset.DELAY}
AXIS_NAMES = {dataset.S21: Message("frequency"), dataset.A_SCAN: Message("delay")}
UNITS = {dataset.S21: "Hz", dataset.A_SCAN: "s"}
AMOUNT = "Total Amount of A-Scans"
HZ_PER_MHZ = 1e6
# Of one polarization: unchanged, reordered, and in single precision.
COPIES = 2.5
ORDER_DECIDED = Message(
    "places and heights are in metres; x changes slowest from scan to scan, as the group's program "
    "sorts them"
)
FARTHEST_M = FARTHEST_MM / 1000.0
LARGEST_MHZ = 1e6  # a lower start frequency is in MHz, as in the guide


def write_merged(survey: xr.Dataset, path: Path, title: str) -> None:
    """Write a survey: over time if it holds A-scans over time, else over frequency.

    Scans are ordered by x, then y; a sample without data is NaN.

    Raises:
        ExportError: The format cannot hold the rotations or the spacing.
        OSError: The file exists or cannot be written.
    """
    kind = dataset.A_SCAN if dataset.A_SCAN in survey else dataset.S21
    values = dataset.require(survey, kind, (*dataset.SAMPLE_DIMS, LAST[kind]))
    lazy.require_room(values[0], COPIES, Message("the merged HDF5 file"))
    turns = letters(survey)
    axis = survey[LAST[kind]].values
    step = even_step(axis, AXIS_NAMES[kind], UNITS[kind])
    x_m, y_m = survey[dataset.X].values, survey[dataset.Y].values
    spacing = {"dx": even_step(x_m, "x", "m"), "dy": even_step(y_m, "y", "m")}
    heights = survey[dataset.HEIGHT].transpose(*dataset.SAMPLE_DIMS).values
    with h5py.File(str(path), "x") as file:
        file.attrs["Title"] = marked(title, survey)
        file.attrs[AMOUNT] = len(turns) * len(x_m) * len(y_m)
        file.attrs["Original extension of A-Scans"] = ".csv"
        file.attrs.update(kept(survey))
        place = file.create_group("Position")
        place.attrs.update(x0=x_m[0], y0=y_m[0], xf=x_m[-1], yf=y_m[-1], **spacing)
        names = RANGE[kind]
        extent = {names[0]: axis[0], names[1]: axis[-1], names[2]: step, "q": len(axis)}
        file.create_group(GROUP[kind]).attrs.update(extent)
        scans = file.create_group("A-Scan")
        for letter, turn in turns.items():
            pol = f"{letter.lower()}-pol"
            # (y, x) to scans ordered along y first, like the sorted file names of the group.
            own = np.asarray(values[turn]).swapaxes(0, 1).reshape(-1, len(axis))
            height = heights[turn].swapaxes(0, 1).reshape(-1, 1).astype(np.float32)
            place.create_dataset(f"h {pol}", data=height, **COMPRESSION)
            for word, part in (("Re", own.real), ("Im", own.imag)):
                scans.create_dataset(
                    f"{word}{{{QUANTITY[kind]} {pol}}}", data=part.astype(np.float32), **COMPRESSION
                )
    add_checksum(path)


def read_merged(path: Path) -> xr.Dataset:
    """Read such a file.

    Raises:
        UnreadableFileError: It is damaged, or the positions of its scans are unknown.
    """
    has_checksum(path)  # only gpr20's own files have a checksum
    try:
        with h5py.File(str(path), "r") as file:
            return _read(file, path.name)
    except AnalysisError:
        raise
    # On damaged files HDF5 and numpy raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message("{file} is damaged or is not a merged HDF5 file", file=path.name)
        ) from error


def _read(file: Any, name: str) -> xr.Dataset:
    kind = dataset.S21 if "Frequency" in file else dataset.A_SCAN
    parts = (GROUP[kind], "Position", "A-Scan")
    missing = [one for one in parts if not isinstance(file.get(one), h5py.Group)]
    if missing:
        raise UnreadableFileError(
            Message("{file} has no group {names}", file=name, names=", ".join(missing)),
            fault=faults.INPUT,
        )
    notes: List[Message] = []
    decisions = [ORDER_DECIDED, DECIDED]
    axis = _axis(file, name, kind, decisions)
    x_m, y_m = _places(file, name, "x"), _places(file, name, "y")
    turns = [one for one in DEGREES if _scan(one, "Re", kind) in file["A-Scan"]]
    if not turns:
        wanted = {"x_scan": _scan("X", "Re", kind), "y_scan": _scan("Y", "Re", kind)}
        found = Header(name, {"A-Scan": ", ".join(file["A-Scan"])})
        raise found.refused("A-Scan", Message("{x_scan} or {y_scan}", **wanted))
    shape = (len(turns), len(x_m), len(y_m))
    amount = float(np.prod(shape))
    Header(name, {AMOUNT: amount, **file.attrs}, typed=True).number(AMOUNT, amount, amount)
    lazy.require_bytes(32.0 * len(axis) * amount, Message("reading {file}", file=name))
    ordered = np.empty((len(turns), len(y_m), len(x_m), len(axis)), np.complex128)
    values = ordered.swapaxes(1, 2)  # in the order of the scans
    height_m, traces = np.full(shape, np.nan), CheckedTraces()
    for turn, letter in enumerate(turns):
        real = _scans(file, _scan(letter, "Re", kind), name, shape[1:], len(axis))
        values[turn].real = real
        imaginary = _scan(letter, "Im", kind)
        if imaginary in file["A-Scan"] or kind == dataset.S21:
            values[turn].imag = _scans(file, imaginary, name, shape[1:], len(axis))
        else:
            values[turn].imag = 0.0
            notes.append(Message("{scan} does not exist, so the A-scans are real", scan=imaginary))
        height_m[turn] = _heights(file, name, letter, shape[1:])
        for column, row in np.ndindex(shape[1:]):
            place = f"{name} x {x_m[column]:g} m, y {y_m[row]:g} m, {letter}"
            values[turn, column, row] = traces.take(
                place, values[turn, column, row], height_m[turn, column, row]
            )
    data = as_dataset(
        Imported(
            ordered,
            [DEGREES[letter] for letter in turns],
            y_m,
            x_m,
            height_m.swapaxes(1, 2),
            name,
            frequency_hz=axis if kind == dataset.S21 else None,
            delay_s=axis if kind == dataset.A_SCAN else None,
            notes=[*notes, Message("this format stores single precision, about seven digits")],
            decisions=[*traces.decisions(), *decisions],
        )
    )
    facts = dict(file.attrs)
    if SIMULATED in str(facts.get("Title", "")):
        facts[SIMULATED_KEY] = True
    return restored(data, facts)


def _scan(letter: str, word: str, kind: str) -> str:
    return f"{word}{{{QUANTITY[kind]} {letter.lower()}-pol}}"


def _axis(file: Any, name: str, kind: str, decisions: List[Message]) -> np.ndarray:
    described = Header(name, file[GROUP[kind]].attrs, typed=True)
    start, stop, step = (described.number(one, -HIGHEST_HZ, HIGHEST_HZ) for one in RANGE[kind])
    count = described.count("q", 1, MOST_POINTS)
    # The guide divides by the number of points where its program divides by one less.
    if not (count > 1 and step > 0.0 and abs(start + (count - 1) * step - stop) <= 1.01 * step):
        values = {"count": count, "start": start, "stop": stop}
        allowed = Message("the step of {count} points from {start:g} to {stop:g}", **values)
        raise described.refused(RANGE[kind][2], allowed)
    if kind == dataset.S21:
        decisions.append(PHASE_DECIDED)
    if kind == dataset.S21 and start < LARGEST_MHZ:
        decisions.append(Message("the frequencies were read as MHz"))
        start, stop = start * HZ_PER_MHZ, stop * HZ_PER_MHZ
    if kind == dataset.S21:
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


def _scans(file: Any, scan: str, name: str, shape: Tuple[int, ...], points: int) -> np.ndarray:
    found = _numbers(file, name, f"A-Scan/{scan}")
    if found.shape == (points, shape[0] * shape[1]) and found.shape[0] != found.shape[1]:
        found = found.T  # as MATLAB stores it
    if found.shape != (shape[0] * shape[1], points):
        size = {"positions": shape[0] * shape[1], "points": points}
        allowed = Message("{positions} positions of {points} points", **size)
        found_shape = " x ".join(map(str, found.shape))
        raise Header(name, {scan: found_shape}).refused(scan, allowed)
    return found.reshape(*shape, points)


def _heights(file: Any, name: str, letter: str, shape: Tuple[int, ...]) -> Any:
    position = file["Position"]
    own = f"h {letter.lower()}-pol"
    if own in position:
        found = _numbers(file, name, f"Position/{own}")
        if found.size != np.prod(shape):
            raise Header(name, {own: found.size}).refused(own, Message("one of each A-scan"))
        return found.astype(np.float64).reshape(shape)
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


def _imported(path: Path, _: ImportOptions, __: Progress) -> xr.Dataset:
    return with_imaginary_parts(read_merged(path))


def _exported(survey: xr.Dataset, path: Path, _: Progress) -> Message:
    write_merged(survey, path, path.stem)
    if dataset.A_SCAN in survey:
        return Message("A-scans over time")
    return Message("A-scans over frequency")


def _whole(path: Path) -> Optional[Path]:
    if path.suffix not in (".h5", ".hdf5") or not path.is_file():
        return None
    try:
        with h5py.File(str(path), "r") as file:
            return path if "A-Scan" in file and "Position" in file else None
    # On damaged files HDF5 raises exceptions of many kinds; it is then no merged file.
    except Exception:
        return None


IMPORT = ImportFormat(_imported, _whole, ("band",))
EXPORT = ExportFormat(_exported, ".h5", has_own_checksum=True, over_time=True)

"""The merged HDF5 file of the GPR-20 group: all A-scans of a survey, over frequency or time."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Tuple

import h5py
import numpy as np
import xarray as xr

from gpr20_analysis import dataset, lazy
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.checksums import add_checksum, has_checksum
from gpr20_analysis.formats.common import DEGREES, Imported, as_dataset, even_step, letters

COMPRESSION: Dict[str, Any] = {"compression": "gzip", "compression_opts": 4}
GROUP = {dataset.S21: "Frequency", dataset.A_SCAN: "Time"}
QUANTITY = {dataset.S21: "S21", dataset.A_SCAN: "A-Scan"}
RANGE = {dataset.S21: ("f0", "ff", "df"), dataset.A_SCAN: ("t0", "tf", "dt")}
LAST = {dataset.S21: dataset.FREQUENCY, dataset.A_SCAN: dataset.DELAY}
AMOUNT = "Total Amount of A-Scans"
HZ_PER_MHZ = 1e6
# Of one polarization: as it is, in another order, and in single precision.
COPIES = 2.5
LARGEST_MHZ = 1e6  # a start frequency below it is taken for MHz, as the guide prints it


def write_merged(survey: xr.Dataset, path: Path, title: str) -> None:
    """Write a survey: over time if it holds A-scans over time, else over frequency.

    Scans are ordered by x, then y; a sample without numbers stays in its place as NaN.

    Raises:
        ExportError: Rotations or spacings cannot be said in this format.
        OSError: The disk refused, or the file exists.
    """
    kind = dataset.A_SCAN if dataset.A_SCAN in survey else dataset.S21
    values = dataset.require(survey, kind, (*dataset.SAMPLE_DIMS, LAST[kind]))
    lazy.require_room(values[0], COPIES, "the group's merged file")
    turns = letters(survey)
    axis = survey[LAST[kind]].values
    step = even_step(axis, LAST[kind], "Hz or s")
    x_m, y_m = survey[dataset.X].values, survey[dataset.Y].values
    spacing = {"dx": even_step(x_m, "x", "m"), "dy": even_step(y_m, "y", "m")}
    heights = survey[dataset.HEIGHT].transpose(*dataset.SAMPLE_DIMS).values
    with h5py.File(str(path), "x") as file:
        file.attrs["Title"] = title
        file.attrs[AMOUNT] = len(turns) * len(x_m) * len(y_m)
        file.attrs["Original extension of A-Scans"] = ".csv"
        place = file.create_group("Position")
        place.attrs.update(x0=x_m[0], y0=y_m[0], xf=x_m[-1], yf=y_m[-1], **spacing)
        names = RANGE[kind]
        described = {names[0]: axis[0], names[1]: axis[-1], names[2]: step, "q": len(axis)}
        file.create_group(GROUP[kind]).attrs.update(described)
        scans = file.create_group("A-Scan")
        for letter, turn in turns.items():
            pol = f"{letter.lower()}-pol"
            # (y, x) to scans that run along y first, as the names of the group's files sort.
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
        UnreadableFileError: It is damaged, or its scans cannot be placed.
    """
    has_checksum(path)  # only gpr20's own files have a checksum
    try:
        with h5py.File(str(path), "r") as file:
            return _read(file, path.name)
    except AnalysisError:
        raise
    # Whatever is changed in such a file, HDF5 and numpy raise errors of many kinds.
    except Exception as error:
        raise UnreadableFileError(f"{path.name} is no whole merged file: {error}") from error


def _read(file: Any, name: str) -> xr.Dataset:
    kind = dataset.S21 if "Frequency" in file else dataset.A_SCAN
    notes: List[str] = []
    axis = _axis(file, kind, notes)
    x_m, y_m = _places(file, name, "x"), _places(file, name, "y")
    turns = [one for one in DEGREES if _scan(one, "Re", kind) in file["A-Scan"]]
    if not turns:
        raise UnreadableFileError(f"{name} holds no {_scan('X', 'Re', kind)} nor the one of y-pol")
    shape = (len(turns), len(x_m), len(y_m))
    _check_amount(file, name, int(np.prod(shape)))
    ordered = np.empty((len(turns), len(y_m), len(x_m), len(axis)), np.complex128)
    values = ordered.swapaxes(1, 2)  # as the scans run
    height_m = np.full(shape, np.nan)
    for turn, letter in enumerate(turns):
        real = _scans(file, _scan(letter, "Re", kind), name, shape[1:], len(axis))
        values[turn].real = real
        imaginary = _scan(letter, "Im", kind)
        if imaginary in file["A-Scan"] or kind == dataset.S21:
            values[turn].imag = _scans(file, imaginary, name, shape[1:], len(axis))
        else:
            values[turn].imag = 0.0
            notes.append(f"{imaginary} is not there: the A-scans are real")
        height_m[turn] = _heights(file, letter, shape[1:])
    return as_dataset(
        Imported(
            ordered,
            [DEGREES[letter] for letter in turns],
            y_m,
            x_m,
            height_m.swapaxes(1, 2),
            name,
            frequency_hz=axis if kind == dataset.S21 else None,
            delay_s=axis if kind == dataset.A_SCAN else None,
            notes=[*notes, "the format holds float32: about seven digits"],
        )
    )


def _check_amount(file: Any, name: str, found: int) -> None:
    told = file.attrs.get(AMOUNT)
    if told is not None and int(told) != found:
        raise UnreadableFileError(
            f"{name} tells of {told} A-scans, but its places and polarizations make {found}"
        )


def _scan(letter: str, word: str, kind: str) -> str:
    return f"{word}{{{QUANTITY[kind]} {letter.lower()}-pol}}"


def _axis(file: Any, kind: str, notes: List[str]) -> np.ndarray:
    described = file[GROUP[kind]].attrs
    start, stop, step = (float(described[one]) for one in RANGE[kind])
    count = int(described["q"])
    # The guide divides by the number of points where its program divides by one less.
    if not (count > 1 and step > 0.0 and abs(start + (count - 1) * step - stop) <= 1.01 * step):
        raise UnreadableFileError(
            f"its {count} points from {start:g} to {stop:g} are not in steps of {step:g}"
        )
    if kind == dataset.S21 and start < LARGEST_MHZ:
        notes.append("its frequencies were taken for MHz")
        start, stop = start * HZ_PER_MHZ, stop * HZ_PER_MHZ
    return np.linspace(start, stop, count)


def _places(file: Any, name: str, axis: str) -> np.ndarray:
    position = file["Position"].attrs
    start, stop = float(position[f"{axis}0"]), float(position[f"{axis}f"])
    step = float(position.get(f"d{axis}", 0.0))
    if step == 0.0 and start != stop:
        raise UnreadableFileError(f"{name} does not tell d{axis}, so its scans have no place")
    count = 1 if step == 0.0 else round((stop - start) / step) + 1
    if count < 1 or abs(start + (count - 1) * step - stop) > 0.01 * abs(step):
        raise UnreadableFileError(
            f"{name}: {axis} from {start} to {stop} m is not in steps of {step} m"
        )
    return np.linspace(start, stop, count)


def _scans(file: Any, scan: str, name: str, shape: Tuple[int, ...], points: int) -> np.ndarray:
    found = file["A-Scan"][scan][()]
    if found.shape == (points, shape[0] * shape[1]) and found.shape[0] != found.shape[1]:
        found = found.T  # as MATLAB stores it
    if found.shape != (shape[0] * shape[1], points):
        raise UnreadableFileError(
            f"{name}: {scan} has the shape {found.shape}; {shape[0]} x {shape[1]} places of "
            f"{points} points were told"
        )
    return found.reshape(*shape, points)


def _heights(file: Any, letter: str, shape: Tuple[int, ...]) -> Any:
    position = file["Position"]
    own = f"h {letter.lower()}-pol"
    if own in position:
        return np.asarray(position[own][()], np.float64).reshape(shape)
    told = position.attrs.get("h")
    return np.nan if told is None or isinstance(told, str) else float(told)

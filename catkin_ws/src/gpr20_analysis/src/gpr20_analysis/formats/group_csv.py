"""The CSV files of the GPR-20 group: one A-scan over frequency each, described by its name."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import List

import numpy as np
import pandas as pd
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import AnalysisError, ExportError, UnreadableFileError
from gpr20_analysis.formats.common import DEGREES, even_step, letters, on_grid
from gpr20_analysis.progress import Progress, silent

HEADER = "S21_real,S21_imag"
MM_PER_M, HZ_PER_MHZ = 1000.0, 1e6
NUMBER = r"(-?\d+(?:\.\d+)?)"
NAME = re.compile(
    rf"VNA_X{NUMBER}_Y{NUMBER}_Or([XY])_Fs{NUMBER}M_Fe{NUMBER}M_Qf(\d+)_H{NUMBER}\.csv"
)


@dataclass(frozen=True)
class _Name:
    x_mm: float
    y_mm: float
    letter: str
    start_mhz: float
    stop_mhz: float
    points: int
    height_mm: float


def write_group_csv(survey: xr.Dataset, folder: Path, progress: Progress = silent) -> int:
    """Write one file per sample and return how many; samples without numbers have none.

    Raises:
        ExportError: Rotations, frequencies or heights cannot be said in this format.
        OSError: The disk refused, or a file exists.
    """
    s21 = dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    turns = letters(survey)
    frequency_hz = survey[dataset.FREQUENCY].values
    even_step(frequency_hz, "frequency", "Hz")
    usable = dataset.usable(survey).transpose(*dataset.SAMPLE_DIMS).values
    height_mm = survey[dataset.HEIGHT].transpose(*dataset.SAMPLE_DIMS).values * MM_PER_M
    if not np.isfinite(height_mm[usable]).all():
        raise ExportError(
            f"{np.count_nonzero(~np.isfinite(height_mm[usable]))} samples have no antenna height, "
            "and the names of this format must tell it"
        )
    ends = [f"{_plain(frequency_hz[place] / HZ_PER_MHZ, 6)}M" for place in (0, -1)]
    tail = f"_Fs{ends[0]}_Fe{ends[1]}_Qf{len(frequency_hz)}_H"
    x_text, y_text = (_texts(survey[axis].values * MM_PER_M) for axis in (dataset.X, dataset.Y))
    folder.mkdir(parents=True, exist_ok=True)
    places = [
        (letter, int(row), int(column), turn)
        for letter, turn in turns.items()
        for row, column in np.argwhere(usable[turn])
    ]
    for letter, row, column, turn in progress(places, len(places)):
        height = _plain(height_mm[turn, row, column], 2)
        name = f"VNA_X{x_text[column]}_Y{y_text[row]}_Or{letter}{tail}{height}.csv"
        values = np.asarray(s21[turn, row, column])
        lines = [f"{one.real!r},{one.imag!r}" for one in values.tolist()]
        with (folder / name).open("x", encoding="ascii") as stream:
            stream.write("\n".join([HEADER, *lines, ""]))
    return len(places)


def read_group_csv(folder: Path, progress: Progress = silent) -> xr.Dataset:
    """Read a folder of such files.

    Raises:
        AnalysisError: There is none.
        UnreadableFileError: A file is damaged, two are of one place, or frequencies differ.
    """
    names = {path: _parsed(path.name) for path in sorted(folder.glob("VNA_*.csv"))}
    if not names:
        raise AnalysisError(f"{folder} holds no files VNA_X..._Y..._Or....csv")
    sweeps = {(one.start_mhz, one.stop_mhz, one.points) for one in names.values()}
    if len(sweeps) > 1:
        raise UnreadableFileError(
            f"{folder} mixes frequencies (MHz, MHz, points): {sorted(sweeps)}; put each into a "
            "folder of its own"
        )
    start_mhz, stop_mhz, points = sweeps.pop()
    read = (_read(path, points) for path in progress(list(names), len(names)))
    return on_grid(
        folder.name,
        np.array([(DEGREES[one.letter], one.y_mm, one.x_mm) for one in names.values()]),
        read,
        [one.height_mm / MM_PER_M for one in names.values()],
        np.linspace(start_mhz * HZ_PER_MHZ, stop_mhz * HZ_PER_MHZ, points),
        ["heights and places are as exact as the names of the files tell them"],
    )


def _read(path: Path, points: int) -> np.ndarray:
    with path.open("rb") as stream:
        header = stream.readline().decode("ascii", "replace").strip()
        if header != HEADER:
            raise UnreadableFileError(f"{path.name} begins with {header[:40]!r}, not {HEADER!r}")
        content = stream.read()
        if not content.endswith(b"\n"):
            raise UnreadableFileError(
                f"{path.name} does not end with the end of a line: its last number may be cut off"
            )
        try:
            found = pd.read_csv(
                io.BytesIO(content), header=None, dtype=np.float64, float_precision="round_trip"
            ).to_numpy()
        except ValueError as error:
            raise UnreadableFileError(f"{path.name} is damaged: {error}") from error
    if found.shape != (points, 2):
        raise UnreadableFileError(
            f"{path.name} holds {found.shape[0]} lines of {found.shape[1]} numbers; its name says "
            f"{points} of 2"
        )
    if not np.isfinite(found).all():
        raise UnreadableFileError(f"{path.name} holds values that are no numbers")
    return found[:, 0] + 1j * found[:, 1]


def _parsed(name: str) -> _Name:
    found = NAME.fullmatch(name)
    if found is None:
        raise UnreadableFileError(
            f"{name} is not named as VNA_X155_Y310_OrX_Fs600M_Fe6000M_Qf501_H248.csv is"
        )
    x_mm, y_mm, letter, start, stop, points, height = found.groups()
    return _Name(
        float(x_mm), float(y_mm), letter, float(start), float(stop), int(points), float(height)
    )


def _texts(values_mm: np.ndarray) -> List[str]:
    # All with decimals or none: the group's tools sort by the numbers in the names.
    whole = bool((np.abs(values_mm - np.round(values_mm)) < 5e-4).all())
    texts = [f"{value:.0f}" if whole else f"{value:.2f}" for value in values_mm]
    if len(set(texts)) < len(texts):
        raise ExportError("places closer than 0.01 mm cannot be told apart in this format")
    return texts


def _plain(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".")

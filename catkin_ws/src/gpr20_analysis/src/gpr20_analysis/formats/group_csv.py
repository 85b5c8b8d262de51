"""The CSV files of the GPR-20 group: one A-scan over frequency each, described by the name."""

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
from gpr20_analysis.progress import Progress, no_progress
from gpr20_common.message import Message

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


def write_group_csv(survey: xr.Dataset, folder: Path, progress: Progress = no_progress) -> int:
    """Write one file per sample with data and return the number of files.

    Raises:
        ExportError: The format cannot hold the rotations, frequencies or heights.
        OSError: A file exists or cannot be written.
    """
    s21 = dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    turns = letters(survey)
    frequency_hz = survey[dataset.FREQUENCY].values
    even_step(frequency_hz, Message("frequency"), "Hz")
    usable = dataset.usable(survey).transpose(*dataset.SAMPLE_DIMS).values
    height_mm = survey[dataset.HEIGHT].transpose(*dataset.SAMPLE_DIMS).values * MM_PER_M
    if not np.isfinite(height_mm[usable]).all():
        raise ExportError(
            Message(
                "{count} samples have no antenna height, which the file names of this format need",
                count=np.count_nonzero(~np.isfinite(height_mm[usable])),
            )
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


def read_group_csv(folder: Path, progress: Progress = no_progress) -> xr.Dataset:
    """Read a folder of such files.

    Raises:
        AnalysisError: There is none.
        UnreadableFileError: A file is damaged, two have the same position, or frequencies differ.
    """
    names = {path: _parsed(path.name) for path in sorted(folder.glob("VNA_*.csv"))}
    if not names:
        raise AnalysisError(
            Message(
                "{folder} contains no files {pattern}",
                folder=folder,
                pattern="VNA_X..._Y..._Or....csv",
            )
        )
    sweeps = {(one.start_mhz, one.stop_mhz, one.points) for one in names.values()}
    if len(sweeps) > 1:
        raise UnreadableFileError(
            Message(
                "{folder} mixes frequencies (MHz, MHz, points): {sweeps}; put the files of each "
                "into a separate folder",
                folder=folder,
                sweeps=sorted(sweeps),
            )
        )
    start_mhz, stop_mhz, points = sweeps.pop()
    read = (_read(path, points) for path in progress(list(names), len(names)))
    return on_grid(
        folder.name,
        np.array([(DEGREES[one.letter], one.y_mm, one.x_mm) for one in names.values()]),
        read,
        [one.height_mm / MM_PER_M for one in names.values()],
        np.linspace(start_mhz * HZ_PER_MHZ, stop_mhz * HZ_PER_MHZ, points),
        [Message("heights and positions are rounded as in the file names")],
    )


def _read(path: Path, points: int) -> np.ndarray:
    with path.open("rb") as stream:
        header = stream.readline().decode("ascii", "replace").strip()
        if header != HEADER:
            raise UnreadableFileError(
                Message(
                    "{file} begins with {found} instead of {header}",
                    file=path.name,
                    found=repr(header[:40]),
                    header=repr(HEADER),
                )
            )
        content = stream.read()
        if not content.endswith(b"\n"):
            raise UnreadableFileError(
                Message(
                    "{file} does not end with a line break, so its last number may be cut off",
                    file=path.name,
                )
            )
        try:
            found = pd.read_csv(
                io.BytesIO(content), header=None, dtype=np.float64, float_precision="round_trip"
            ).to_numpy()
        except ValueError as error:
            raise UnreadableFileError(
                Message("{file} is damaged", file=path.name, details=error)
            ) from error
    if found.shape != (points, 2):
        raise UnreadableFileError(
            Message(
                "{file} has {lines} lines of {columns} numbers; by its name it must have {points} "
                "lines of 2",
                file=path.name,
                lines=found.shape[0],
                columns=found.shape[1],
                points=points,
            )
        )
    if not np.isfinite(found).all():
        raise UnreadableFileError(Message("{file} contains NaN or infinite values", file=path.name))
    return found[:, 0] + 1j * found[:, 1]


def _parsed(name: str) -> _Name:
    found = NAME.fullmatch(name)
    if found is None:
        raise UnreadableFileError(
            Message(
                "the name {file} must have the form {example}",
                file=name,
                example="VNA_X155_Y310_OrX_Fs600M_Fe6000M_Qf501_H248.csv",
            )
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
        raise ExportError(
            Message("positions closer than 0.01 mm have the same file name in this format")
        )
    return texts


def _plain(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".")

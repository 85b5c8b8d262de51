"""Tables for spreadsheets: a survey as a line per sample, and texts that are no formulas.

Texts that people type, or that a file holds, may begin like a formula, which a spreadsheet runs
when it opens the file. They get an apostrophe before that; `cell_text` takes it away again. The
same holds behind a comma, semicolon, tab or line break in a text: a spreadsheet that expects
another separator, as in countries with a decimal comma, begins a new cell there, whatever the
quotes say.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import aux_names
from gpr20_analysis.sentences import DOUBTS, sentences_of
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.terminal_text import printable

FACTS = "index,x_m,y_m,polarization_deg,height_m,timestamp,quality,simulated,doubts"
# A quote at the beginning of a cell would make one cell of the lines after it.
_FORMULA = '\'*(?="|[ \u00a0"]*[=+\\-@\uff1d\uff0b\uff0d\uff20\t\r\n])'
_PLACE = re.compile(f"(?:^|(?<=[,;\t\r\n])){_FORMULA}")
_NUMBER = re.compile(r"[-+]?[0-9]+([.][0-9]+)?")


def csv_cell(value: Any) -> Any:
    """Return a value as a cell of a CSV file; numbers, also those in a text, stay as they are."""
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

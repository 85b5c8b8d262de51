"""One table for spreadsheets: a line per sample, two columns per frequency."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import aux_names
from gpr20_analysis.formats.csv_cells import csv_cell
from gpr20_analysis.formats.provenance import SIMULATED_KEY, is_simulated
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.sentences import DOUBTS, sentences_of
from gpr20_common.terminal_text import printable

FACTS = "index,x_m,y_m,polarization_deg,height_m,timestamp,quality,simulated,doubts"


def write_plain_csv(survey: xr.Dataset, path: Path, progress: Progress = no_progress) -> int:
    """Write the table and return its number of samples; those without data are left out.

    Values of other sensors are in columns such as `aux_soil_moisture [m3/m3]`. Numbers have as many
    digits as are needed to read back the same float64.

    Raises:
        OSError: The file exists or cannot be written.
    """
    s21 = dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    columns = [
        f"{part}_{frequency_hz!r}_hz"
        for frequency_hz in survey[dataset.FREQUENCY].values.tolist()
        for part in ("real", "imag")
    ]
    facts = {
        name: dataset.require(survey, name, dataset.SAMPLE_DIMS).values
        for name in ("index", dataset.HEIGHT, dataset.TIMESTAMP, dataset.QUALITY)
    }
    # Empty if it is not known.
    simulated = str(int(is_simulated(survey))) if SIMULATED_KEY in survey.attrs else ""
    codes = " ".join(one.fault_code for one in sentences_of(survey, DOUBTS))
    aux = [survey[name] for name in aux_names(survey)]
    aux_values = [one.transpose(*dataset.SAMPLE_DIMS).values for one in aux]
    usable = dataset.usable(survey).transpose(*dataset.SAMPLE_DIMS).values
    places = [tuple(int(one) for one in place) for place in np.argwhere(usable)]
    with path.open("x", encoding="utf-8", newline="") as stream:
        stream.write(",".join([FACTS, *map(_heading, aux), *columns]) + "\n")
        for turn, row, column in progress(places, len(places)):
            place = (turn, row, column)
            words = [
                str(facts["index"][place]),
                repr(float(survey[dataset.X].values[column])),
                repr(float(survey[dataset.Y].values[row])),
                repr(float(survey[dataset.POLARIZATION].values[turn])),
                repr(float(facts[dataset.HEIGHT][place])),
                str(csv_cell(str(facts[dataset.TIMESTAMP][place]))),
                str(facts[dataset.QUALITY][place]),
                simulated,
                codes,
                *(repr(float(one[place])) for one in aux_values),
            ]
            numbers = np.ascontiguousarray(s21[place]).view(np.float64).tolist()
            stream.write(",".join([*words, *map(repr, numbers)]) + "\n")
    return len(places)


def _heading(aux: xr.DataArray) -> str:
    """Return the heading of a column; a unit has no commas and quotes there."""
    unit = "".join(one for one in printable(str(aux.attrs.get("units", ""))) if one not in ',"')
    return str(csv_cell(f"{aux.name} [{unit}]" if unit else str(aux.name)))

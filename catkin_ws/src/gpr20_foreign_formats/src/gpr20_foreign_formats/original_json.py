"""The JSON samples of the original project."""

from __future__ import annotations

import codecs
import contextlib
import json
import math
import re
from datetime import datetime
from pathlib import Path
from typing import Any, Dict, Optional

import numpy as np
import orjson
import pandas as pd
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.common import HIGHEST_M, on_grid, usable_samples
from gpr20_analysis.formats.format import ExportFormat, ImportFormat, ImportOptions, files_of
from gpr20_analysis.formats.provenance import SIMULATED_KEY, Facts, is_simulated
from gpr20_analysis.formats.sums_beside import checked_facts
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.sentences import DOUBTS, kept_doubts, sentences_of, with_decisions
from gpr20_common.message import Message
from gpr20_foreign_formats.group_files import (
    FARTHEST_MM,
    HIGHEST_HZ,
    PHASE_DECIDED,
    CheckedTraces,
    check_sweep,
    files_of_samples,
    listed,
)
from gpr20_foreign_formats.header import Header
from gpr20_foreign_formats.lost_imaginary import with_imaginary_parts
from gpr20_survey.files.regular_file import read_regular

VALUES = ("freq_value", "real_value", "imaginary_value")
TIME = "%Y%m%d%H%M%S"
LISTED = 3
CONSTANT_M = 10.0
"""Height in every sample of a program that never asked its sensor, which ends at 0.8 m."""
DECIDED = (
    Message("coordinates are mm and degrees, heights metres, frequencies Hz: the files name none"),
    Message(
        "the rotations are those that the files name; a public version of the original control "
        "sent the target of Y to the axis of rotation, so they may not be those of the antennas"
    ),
    Message(
        "nothing was added to the sweeps; a public version of the original storage left out the "
        "last number of the instrument's answer, so the last frequency may be missing"
    ),
)
YEARS = range(2020, 2106)
TIMES_LEFT_OUT = Message("the times of all were left out, for some are not from 2020 on")
TIMES_DECIDED = Message("the times of the samples name no time zone and were read as UTC")
HEIGHT_DECIDED = Message(
    "the height of every sample is {constant_m:g} m, a constant of the original control and no "
    "measurement; it was left out",
    constant_m=CONSTANT_M,
)
PLACE = ("x_coord", "y_coord", "z_coord")
ROUNDED_MM = 0.00501
"""Rounding of coordinates in names [mm or deg]."""
NAME = re.compile(r"X(-?\d+\.\d+)_Y(-?\d+\.\d+)_Z(-?\d+\.\d+)\.json", re.ASCII | re.IGNORECASE)
EXAMPLE = "X000.00_Y000.00_Z000.00.json"


def write_original(survey: xr.Dataset, folder: Path, progress: Progress = no_progress) -> int:
    """Write one file per sample with data and return the number of files.

    Raises:
        OSError: A file exists or cannot be written.
    """
    s21 = dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    frequencies = survey[dataset.FREQUENCY].values.tolist()
    facts = {
        name: dataset.require(survey, name, dataset.SAMPLE_DIMS).values
        for name in (dataset.HEIGHT, dataset.TIMESTAMP, "sample_id")
    }
    folder.mkdir(parents=True, exist_ok=True)
    samples, doubts = usable_samples(survey), kept_doubts(sentences_of(survey, DOUBTS))
    for place, x_mm, y_mm, z_deg in progress(samples, len(samples)):
        moment = facts[dataset.TIMESTAMP][place]
        height_m = float(facts[dataset.HEIGHT][place])
        values = np.asarray(s21[place]).tolist()
        sample: Dict[str, Any] = {
            "x_coord": x_mm,
            "y_coord": y_mm,
            "z_coord": z_deg,
            "antennae_height": None if math.isnan(height_m) else height_m,
            "timestamp": "" if np.isnat(moment) else pd.Timestamp(moment).strftime(TIME),
            "survey_id": str(survey.attrs.get("survey_id", "")),
            "sample_id": str(facts["sample_id"][place]),
            "data": [
                {"freq_value": one, "real_value": value.real, "imaginary_value": value.imag}
                for one, value in zip(frequencies, values)
            ],
        }
        if is_simulated(survey):
            sample[SIMULATED_KEY] = True
        if doubts:
            sample[DOUBTS] = doubts
        name = f"X{x_mm:06.2f}_Y{y_mm:06.2f}_Z{z_deg:06.2f}.json"
        with (folder / name).open("x", encoding="ascii") as stream:
            json.dump(sample, stream, allow_nan=False)
    return len(samples)


def holds_original(folder: Path) -> bool:
    """Return whether a folder has files with names of the original project."""
    return any(NAME.fullmatch(path.name) for path in folder.iterdir())


def read_original(
    folder: Path,
    progress: Progress = no_progress,
    facts: Optional[Facts] = None,
    height_m: Optional[float] = None,
) -> xr.Dataset:
    """Read a folder of such files; a lost imaginary part is recovered.

    Args:
        folder: The folder.
        progress: Shows the progress.
        facts: What is known of the survey besides.
        height_m: Height of the antennas, if the files do not say it [m].

    Raises:
        AnalysisError: There is none.
        UnreadableFileError: One is damaged or contradicts another.
    """
    paths, decisions = files_of_samples(folder, NAME, ".json", EXAMPLE)
    samples = [_read(path) for path in progress(paths, len(paths))]
    frequency_hz = samples[0].pop("frequency_hz")
    for path, sample in zip(paths[1:], samples[1:]):
        if not np.array_equal(sample.pop("frequency_hz"), frequency_hz):
            raise UnreadableFileError(
                Message(
                    "{file} has other frequencies than {first}; put it into another folder",
                    file=path.name,
                    first=paths[0].name,
                ),
                fault=faults.INPUT,
            )
    surveys = sorted({sample["survey_id"] for sample in samples})
    if len(surveys) > 1:
        raise UnreadableFileError(
            Message(
                "{folder} has samples of {count} surveys ({ids}); put those of each into a folder "
                "of its own",
                folder=folder.name,
                count=len(surveys),
                ids=", ".join(surveys[:LISTED]),
            ),
            fault=faults.INPUT,
        )
    traces = CheckedTraces()
    spectra = [
        traces.take(path.name, one["s21"], one["height_m"]) for path, one in zip(paths, samples)
    ]
    decisions += traces.decisions()
    times = [sample["time"] for sample in samples]
    wrong = [path.name for path, one in zip(paths, times) if one and one.year not in YEARS]
    if wrong:
        decisions.append(listed(TIMES_LEFT_OUT, wrong))
        times = []
    decisions += DECIDED
    if any(times):
        decisions.append(TIMES_DECIDED)
    heights_m = np.array([sample["height_m"] for sample in samples])
    if (heights_m == CONSTANT_M).all():
        heights_m[:] = math.nan
        decisions.append(HEIGHT_DECIDED)
    if height_m is not None and np.isnan(heights_m).any():
        heights_m[np.isnan(heights_m)] = height_m
        given = Message(
            "samples without a height have {height_m:g} m, as the user said", height_m=height_m
        )
        decisions.append(given)
    data = on_grid(
        folder.name,
        np.array([sample["position"] for sample in samples]),
        spectra,
        heights_m.tolist(),
        frequency_hz,
        [],
        simulated=True if any(sample["simulated"] for sample in samples) else None,
        facts=facts,
        times=[np.datetime64(one or "NaT", "ns") for one in times] or None,
    )
    if surveys[0]:
        data = data.assign_attrs({"survey_id": surveys[0], **data.attrs})
    return with_imaginary_parts(with_decisions(data, *decisions, PHASE_DECIDED))


def _read(path: Path) -> Dict[str, Any]:
    content = read_regular(path)
    try:
        sample = orjson.loads(content[3:] if content.startswith(codecs.BOM_UTF8) else content)
    except orjson.JSONDecodeError as error:
        raise UnreadableFileError(
            Message(
                "{file} is not JSON in UTF-8: see line {line}, character {column}",
                file=path.name,
                line=error.lineno,
                column=error.colno,
            )
        ) from error
    if not isinstance(sample, dict):
        raise UnreadableFileError(Message("{file} is not a valid sample", file=path.name))
    header = Header(path.name, sample, typed=True)
    place = [header.number(key, -FARTHEST_MM, FARTHEST_MM) for key in PLACE]
    for key, found, named in zip(PLACE, place, NAME.findall(path.name)[0]):
        if abs(found - float(named)) > ROUNDED_MM:
            allowed = Message("{named}, as the name of the file says", named=named)
            raise header.refused(key, allowed)
    unknown = sample.get("antennae_height") is None and "antennae_height" in sample
    for key, kind, allowed in (
        ("survey_id", (str, type(None)), Message("a text")),
        (SIMULATED_KEY, bool, Message("true or false")),
    ):
        if key in sample and not isinstance(sample[key], kind):
            raise header.refused(key, allowed)
    rows = _rows(header)
    return {
        "time": _time(header),
        "survey_id": sample.get("survey_id") or "",
        "position": place[::-1],
        "height_m": math.nan if unknown else header.number("antennae_height", 0.0, HIGHEST_M),
        "frequency_hz": rows[:, 0],
        "simulated": sample.get(SIMULATED_KEY, False),
        "s21": rows[:, 1] + 1j * rows[:, 2],
    }


def _rows(header: Header) -> np.ndarray:
    """Return the rows of numbers: frequency [Hz], real and imaginary part."""
    rows = header.entries.get("data")
    if not isinstance(rows, list) or len(rows) < 2:
        raise header.refused("data", Message("a list of two rows or more"))
    found = [row.get(key) if isinstance(row, dict) else None for row in rows for key in VALUES]
    if not {int, float}.issuperset(map(type, found)):
        at = next(place for place, one in enumerate(found) if type(one) not in (int, float))
        key = f"{VALUES[at % 3]} {at // 3 + 1}"
        Header(header.file, {key: found[at]}, typed=True).number(key, -HIGHEST_HZ, HIGHEST_HZ)
    numbers = np.array(found, np.float64).reshape(-1, 3)
    frequency_hz = numbers[:, 0]
    falls = np.flatnonzero(np.diff(frequency_hz) <= 0.0)
    if falls.size:
        key = f"{VALUES[0]} {falls[0] + 2}"
        found_hz = {key: frequency_hz[falls[0] + 1]}
        raise Header(header.file, found_hz).refused(key, Message("above the one before"))
    check_sweep(header.file, *frequency_hz[[0, -1]])
    return numbers


def _time(header: Header) -> Optional[datetime]:
    stamp = header.entries.get("timestamp")
    if stamp in (None, ""):
        return None
    with contextlib.suppress(TypeError, ValueError):
        if re.fullmatch("[0-9]{14}", stamp):
            return datetime.strptime(stamp, TIME)
    raise header.refused("timestamp", Message("a text such as 20211015083000, or nothing"))


def _imported(path: Path, options: ImportOptions, progress: Progress) -> xr.Dataset:
    return read_original(path, progress, checked_facts(path), options.height_m)


def _whole(path: Path) -> Optional[Path]:
    if path.is_dir():
        return path if holds_original(path) else None
    # One file is no survey; its folder is.
    return path.parent if NAME.fullmatch(path.name) and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, ("height_m",))
EXPORT = ExportFormat(files_of(write_original), holds=("X*_Y*_Z*.json",))

"""The JSON samples of the original project."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import List, Optional

import numpy as np
import orjson
import xarray as xr

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.common import HIGHEST_M
from gpr20_analysis.formats.imports import ImportFormat, ImportOptions
from gpr20_analysis.work import Progress
from gpr20_common.message import Message
from gpr20_foreign_formats.group_files import (
    FARTHEST_MM,
    HIGHEST_HZ,
    Samples,
    check_sweep,
    files_of_samples,
    survey_of,
)
from gpr20_foreign_formats.header import Header, folder_of, refusal
from gpr20_survey.files.regular_files import read_regular

VALUES = ("freq_value", "real_value", "imaginary_value")
TIME, DIGITS = "%Y%m%d%H%M%S", 14
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


@dataclass(frozen=True)
class _Sample:
    """What a file holds: x, y [mm] and rotation [deg]; rows of frequency [Hz], real, imaginary."""

    file: str
    place: List[float]
    height_m: float
    time: Optional[datetime]
    survey_id: str
    rows: np.ndarray


def read_original(path: Path, options: ImportOptions, progress: Progress) -> xr.Dataset:
    """Read a folder of such files.

    Raises:
        UnreadableFileError: There is none, one is damaged, or contradicts another.
    """
    paths, decisions = files_of_samples(path, NAME, ".json", EXAMPLE)
    samples = [_read(one) for one in progress(paths, len(paths))]
    first = samples[0]
    for one in samples:
        same = np.array_equal(one.rows[:, 0], first.rows[:, 0])
        if not same or one.survey_id != first.survey_id:
            raise refusal(
                Message(
                    "{file} is of another survey than {first}, or has other frequencies; put those "
                    "of each into a folder of its own",
                    file=one.file,
                    first=first.file,
                )
            )
    heights_m = np.array([one.height_m for one in samples])
    decisions += DECIDED
    if (heights_m == CONSTANT_M).all():
        heights_m[:] = np.nan
        decisions.append(HEIGHT_DECIDED)
    if options.height_m is not None:
        heights_m[np.isnan(heights_m)] = options.height_m
    times = [one.time for one in samples]
    if any(times):
        decisions.append(TIMES_DECIDED)
    rows = np.array([one.rows for one in samples])
    found = Samples(
        [one.file for one in samples],
        np.array([one.place[::-1] for one in samples]),
        rows[:, :, 1] + 1j * rows[:, :, 2],
        heights_m,
        frequency_hz=first.rows[:, 0],
        times=[np.datetime64(one or "NaT", "ns") for one in times],
        decisions=decisions,
    )
    survey = survey_of(path, found)
    return survey.assign_attrs(survey_id=first.survey_id) if first.survey_id else survey


def _read(path: Path) -> _Sample:
    content = read_regular(path)
    try:
        sample = orjson.loads(content[3:] if content.startswith(codecs.BOM_UTF8) else content)
        if not isinstance(sample, dict):
            raise ValueError("no object")
    except ValueError as error:
        raise UnreadableFileError(
            Message("{file} is not a JSON object in UTF-8", file=path.name, details=error)
        ) from error
    header = Header(path.name, sample, typed=True)
    place = [header.number(key, -FARTHEST_MM, FARTHEST_MM) for key in PLACE]
    for key, found, named in zip(PLACE, place, NAME.findall(path.name)[0]):
        if abs(found - float(named)) > ROUNDED_MM:
            allowed = Message("{named}, as the name of the file says", named=named)
            raise header.refused(key, allowed)
    height_m = np.nan
    if sample.get("antennae_height", 0) is not None:
        height_m = header.number("antennae_height", 0.0, HIGHEST_M)
    if not isinstance(sample.get("survey_id"), (str, type(None))):
        raise header.refused("survey_id", Message("a text"))
    survey_id = sample.get("survey_id") or ""
    return _Sample(path.name, place, height_m, _time(header), survey_id, _rows(header))


def _rows(header: Header) -> np.ndarray:
    """Return the rows of numbers: frequency [Hz], real and imaginary part."""
    rows = header.entries.get("data")
    if not isinstance(rows, list) or len(rows) < 2:
        raise header.refused("data", Message("a list of two rows or more"))
    found = [row.get(key) if isinstance(row, dict) else None for row in rows for key in VALUES]
    for at, one in enumerate(found):
        if type(one) not in (int, float):
            key = f"{VALUES[at % 3]} {at // 3 + 1}"
            Header(header.file, {key: one}, typed=True).number(key, -HIGHEST_HZ, HIGHEST_HZ)
    numbers = np.array(found, np.float64).reshape(-1, 3)
    falls = np.flatnonzero(np.diff(numbers[:, 0]) <= 0.0)
    if falls.size:
        key = f"{VALUES[0]} {falls[0] + 2}"
        found_hz = {key: numbers[falls[0] + 1, 0]}
        raise Header(header.file, found_hz).refused(key, Message("above the one before"))
    check_sweep(header.file, *numbers[[0, -1], 0])
    return numbers


def _time(header: Header) -> Optional[datetime]:
    stamp = str(header.entries.get("timestamp") or "")
    if not stamp:
        return None
    try:
        if len(stamp) != DIGITS:
            raise ValueError(stamp)
        return datetime.strptime(stamp, TIME)
    except ValueError as error:
        allowed = Message("a text such as 20211015083000, or nothing")
        raise header.refused("timestamp", allowed) from error


IMPORT = ImportFormat(read_original, lambda path: folder_of(path, NAME), ("height_m",))

"""The JSON samples of the original project."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any, Dict, Optional

import numpy as np
import orjson
import pandas as pd
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.formats.common import on_grid, usable_samples
from gpr20_analysis.formats.format import ExportFormat, ImportFormat, ImportOptions, files_of
from gpr20_analysis.formats.provenance import SIMULATED_KEY, Facts, is_simulated
from gpr20_analysis.formats.sums_beside import checked_facts
from gpr20_analysis.progress import Progress, no_progress
from gpr20_common.message import Message
from gpr20_foreign_formats.lost_imaginary import with_imaginary_parts
from gpr20_survey.files.regular_file import read_regular

VALUES = ("freq_value", "real_value", "imaginary_value")
TIME = "%Y%m%d%H%M%S"
NAME = re.compile(r"X-?\d+\.\d+_Y-?\d+\.\d+_Z-?\d+\.\d+\.json")


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
    samples = usable_samples(survey)
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
        name = f"X{x_mm:06.2f}_Y{y_mm:06.2f}_Z{z_deg:06.2f}.json"
        with (folder / name).open("x", encoding="ascii") as stream:
            json.dump(sample, stream, allow_nan=False)
    return len(samples)


def holds_original(folder: Path) -> bool:
    """Return whether a folder has files with names of the original project."""
    return any(NAME.fullmatch(path.name) for path in folder.glob("X*.json"))


def read_original(
    folder: Path, progress: Progress = no_progress, facts: Optional[Facts] = None
) -> xr.Dataset:
    """Read a folder of such files; a lost imaginary part is recovered.

    Args:
        folder: The folder.
        progress: Shows the progress.
        facts: What is known of the survey besides.

    Raises:
        AnalysisError: There is none.
        UnreadableFileError: One is damaged or contradicts another.
    """
    paths = sorted(path for path in folder.glob("X*.json") if NAME.fullmatch(path.name))
    if not paths:
        raise AnalysisError(
            Message(
                "{folder} contains no files {pattern}",
                folder=folder,
                pattern="X000.00_Y000.00_Z000.00.json",
            ),
            fault=faults.NO_INPUT,
        )
    samples = [_read(path) for path in progress(paths, len(paths))]
    frequency_hz = samples[0].pop("frequency_hz")
    for path, sample in zip(paths[1:], samples[1:]):
        if not np.array_equal(sample.pop("frequency_hz"), frequency_hz):
            raise UnreadableFileError(
                Message(
                    "{file} has other frequencies than {first}",
                    file=path.name,
                    first=paths[0].name,
                ),
                fault=faults.FILE_CONTENT,
            )
    data = on_grid(
        folder.name,
        np.array([sample["position"] for sample in samples]),
        [sample["s21"] for sample in samples],
        [sample["height_m"] for sample in samples],
        frequency_hz,
        [],
        simulated=True if any(sample["simulated"] for sample in samples) else None,
        facts=facts,
    )
    return with_imaginary_parts(data)


def _read(path: Path) -> Dict[str, Any]:
    try:
        sample = orjson.loads(read_regular(path))
        rows = np.array([[row[key] for key in VALUES] for row in sample["data"]], np.float64)
        if rows.ndim != 2 or not np.isfinite(rows).all() or not (np.diff(rows[:, 0]) > 0).all():
            raise ValueError("frequencies not ascending, or NaN")
        height = sample["antennae_height"]
        return {
            "position": [float(sample[key]) for key in ("z_coord", "y_coord", "x_coord")],
            "height_m": math.nan if height is None else float(height),
            "frequency_hz": rows[:, 0],
            "simulated": sample.get(SIMULATED_KEY) is True,
            "s21": rows[:, 1] + 1j * rows[:, 2],
        }
    except (KeyError, TypeError, ValueError) as error:
        raise UnreadableFileError(
            Message("{file} is not a valid sample", file=path.name, details=repr(error))
        ) from error


def _imported(path: Path, _: ImportOptions, progress: Progress) -> xr.Dataset:
    return read_original(path, progress, checked_facts(path))


def _whole(path: Path) -> Optional[Path]:
    if path.is_dir():
        return path if holds_original(path) else None
    # One file is no survey; its folder is.
    return path.parent if NAME.fullmatch(path.name) and path.is_file() else None


IMPORT = ImportFormat(_imported, _whole, ())
EXPORT = ExportFormat(files_of(write_original), holds=("X*_Y*_Z*.json",))

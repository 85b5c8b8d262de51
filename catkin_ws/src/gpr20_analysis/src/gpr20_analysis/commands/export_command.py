"""gpr20 export: a survey in a format of others."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Callable, Dict

import xarray as xr

from gpr20_analysis.commands import survey_input
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.info_command import status_of
from gpr20_analysis.errors import ExportError
from gpr20_analysis.mid import dataset, dataset_files
from gpr20_analysis.mid.formats import (
    group_csv,
    merged_hdf5,
    original_json,
    plain_csv,
    segy,
    touchstone,
)
from gpr20_analysis.mid.processing.delay import to_time
from gpr20_analysis.mid.processing.sweep import Window
from gpr20_analysis.mid.survey_source import Progress

Writer = Callable[[xr.Dataset, argparse.Namespace], str]


def _netcdf(survey: xr.Dataset, chosen: argparse.Namespace) -> str:
    dataset_files.write_dataset(survey, chosen.output)
    return "everything"


def _group_csv(survey: xr.Dataset, chosen: argparse.Namespace) -> str:
    return f"{group_csv.write_group_csv(survey, chosen.output, _progress())} files"


def _merged(survey: xr.Dataset, chosen: argparse.Namespace) -> str:
    if chosen.domain == "time" and dataset.A_SCAN not in survey:
        survey = to_time(survey, Window.NONE, padding=1.0)
    merged_hdf5.write_merged(survey, chosen.output, chosen.output.stem)
    return f"A-scans over {chosen.domain}"


def _plain_csv(survey: xr.Dataset, chosen: argparse.Namespace) -> str:
    return f"{plain_csv.write_plain_csv(survey, chosen.output, _progress())} samples"


def _segy(survey: xr.Dataset, chosen: argparse.Namespace) -> str:
    return ", ".join(path.name for path in segy.write_segy(survey, chosen.output))


def _touchstone(survey: xr.Dataset, chosen: argparse.Namespace) -> str:
    return f"{touchstone.write_touchstone(survey, chosen.output, _progress())} files"


def _original(survey: xr.Dataset, chosen: argparse.Namespace) -> str:
    return f"{original_json.write_original(survey, chosen.output, _progress())} files"


FORMATS: Dict[str, Writer] = {
    "netcdf": _netcdf,
    "zarr": _netcdf,
    "group-csv": _group_csv,
    "merged-hdf5": _merged,
    "csv": _plain_csv,
    "segy": _segy,
    "touchstone": _touchstone,
    "original-json": _original,
}
ENDINGS = {"netcdf": ".nc", "zarr": ".zarr", "merged-hdf5": ".h5", "csv": ".csv", "segy": ".sgy"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    survey_input.add_survey(parser)
    parser.add_argument(
        "output",
        type=Path,
        help="file, ending in "
        + ", ".join(f"{ending} ({name})" for name, ending in ENDINGS.items())
        + "; a new folder for the formats of one file per sample",
    )
    parser.add_argument("--format", choices=FORMATS, required=True, help="what to write")
    parser.add_argument(
        "--domain",
        choices=("frequency", "time"),
        default="frequency",
        help="merged-hdf5: A-scans over frequency or, by inverse Fourier transform, over time",
    )


def run(chosen: argparse.Namespace) -> int:
    """Write the survey; return the exit status."""
    _check_output(chosen)
    survey = survey_input.load(chosen)
    chosen.output.parent.mkdir(parents=True, exist_ok=True)
    written = FORMATS[chosen.format](survey, chosen)
    print(f"{chosen.output}: {written}")
    return status_of(survey)


def _check_output(chosen: argparse.Namespace) -> None:
    output, ending = chosen.output, ENDINGS.get(chosen.format)
    if ending is not None and output.suffix != ending:
        raise ExportError(f"{output} must end in {ending} for {chosen.format}")
    if output.exists() and not (ending is None and output.is_dir() and not any(output.iterdir())):
        raise ExportError(f"{output} exists; nothing is overwritten, name another place")


def _progress() -> Progress:
    return survey_input.progress_bar("writing")


COMMAND = Command(
    "Write a survey in a format of others. Nothing is overwritten.", add_arguments, run
)

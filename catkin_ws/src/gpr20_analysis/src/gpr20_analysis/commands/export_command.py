"""gpr20 export: a survey in a format of others."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Sequence, Tuple

import xarray as xr

from gpr20_analysis import cluster, dataset
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats import (
    group_csv,
    merged_hdf5,
    original_json,
    plain_csv,
    segy,
    touchstone,
)
from gpr20_analysis.formats.dataset_files import NETCDF, ZARR, write_dataset
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.processing.sweep import FrequencyGrid, Window
from gpr20_analysis.progress import Progress

Writer = Callable[[xr.Dataset, Path, Progress], str]


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        write: Writes a survey to a path and says what.
        ending: What a file's name ends in; empty: a folder of one file per sample.
        holds: Patterns of the names in the folder.
    """

    write: Writer
    ending: str = ""
    holds: Tuple[str, ...] = ()


def _counting(write: Callable[[xr.Dataset, Path, Progress], int], counted: str) -> Writer:
    return lambda survey, path, progress: f"{write(survey, path, progress)} {counted}"


def _write_dataset(survey: xr.Dataset, path: Path, _: Progress) -> str:
    write_dataset(survey, path)
    return "everything"


def _write_merged(survey: xr.Dataset, path: Path, _: Progress) -> str:
    merged_hdf5.write_merged(survey, path, path.stem)
    return f"A-scans over {'time' if dataset.A_SCAN in survey else 'frequency'}"


FORMATS: Dict[str, Format] = {
    "netcdf": Format(_write_dataset, NETCDF),
    "zarr": Format(_write_dataset, ZARR),
    "group-csv": Format(_counting(group_csv.write_group_csv, "files"), holds=("VNA_X*.csv",)),
    "merged-hdf5": Format(_write_merged, ".h5"),
    "csv": Format(_counting(plain_csv.write_plain_csv, "samples"), ".csv"),
    "segy": Format(_counting(segy.write_segy, "traces"), ".sgy"),
    "touchstone": Format(
        _counting(touchstone.write_touchstone, "files"), holds=("[0-9]*_X*_Y*_Z*.s2p",)
    ),
    "original-json": Format(
        _counting(original_json.write_original, "files"), holds=("X*_Y*_Z*.json",)
    ),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    parser.add_argument(
        "output",
        type=Path,
        help="file, ending in "
        + ", ".join(f"{one.ending} ({name})" for name, one in FORMATS.items() if one.ending)
        + "; a new folder for the formats of one file per sample",
    )
    parser.add_argument("--format", choices=FORMATS, required=True, help="what to write")
    parser.add_argument(
        "--domain",
        choices=("frequency", "time"),
        help="merged-hdf5: A-scans over frequency or, by inverse Fourier transform, over time; "
        "default as the data are",
    )
    outputs.add_overwrite(parser)
    inputs.add_scheduler(parser)


def run(chosen: argparse.Namespace) -> int:
    """Write the survey; return the exit status."""
    _check([chosen.output], chosen)
    survey = inputs.load(chosen)
    with cluster.connected(chosen.scheduler):
        transformed = _transformed(survey, chosen)
        with cluster.fetched(transformed) as fetched:
            _write_all(fetched, chosen)
    return inputs.status_of(survey)


def _transformed(survey: xr.Dataset, chosen: argparse.Namespace) -> xr.Dataset:
    if chosen.format != "merged-hdf5":
        return survey
    if dataset.A_SCAN in survey:
        if chosen.domain == "frequency":
            raise ExportError(
                "the data are A-scans over time; --domain time exports them as they are"
            )
    elif chosen.domain == "time":
        return to_time(cluster.spread(survey), Window.NONE, _padding_for_real_parts(survey))
    return survey


def _padding_for_real_parts(survey: xr.Dataset) -> float:
    # The group's programs work on the real part alone, which needs two samples per period of the
    # highest frequency; the complex values would need fewer.
    sweep = FrequencyGrid.of(survey)
    return 2.0 * float(sweep.frequency_hz[-1]) / (sweep.step_hz * sweep.count)


def _write_all(survey: xr.Dataset, chosen: argparse.Namespace) -> None:
    if chosen.format != "segy":
        _write(survey, chosen.output, chosen)
        return
    # One file per polarization, which only the survey tells.
    turns = survey[dataset.POLARIZATION].values
    paths = [segy.file_of(chosen.output, turn) for turn in turns]
    _check(paths, chosen)
    for turn, path in enumerate(paths):
        _write(survey.isel({dataset.POLARIZATION: [turn]}), path, chosen)


def _check(paths: Sequence[Path], chosen: argparse.Namespace) -> None:
    form = FORMATS[chosen.format]
    for path in paths:
        if form.ending and path.suffix != form.ending:
            raise ExportError(f"{path} must end in {form.ending} for {chosen.format}")
    if form.ending in (NETCDF, ZARR):
        written = [outputs.dataset_output(path) for path in paths]
    else:
        written = [Output(path, form.holds) for path in paths]
    outputs.check(written, [chosen.survey], chosen.overwrite)


def _write(survey: xr.Dataset, path: Path, chosen: argparse.Namespace) -> None:
    form, progress = FORMATS[chosen.format], inputs.progress_bar("writing")
    if form.ending in (NETCDF, ZARR):
        written = form.write(survey, path, progress)  # which is whole or not there by itself
    else:
        with atomic_output(path, int(survey.nbytes)) as place:
            written = form.write(survey, place, progress)
    print(f"{path}: {written}")


COMMAND = Command("Write a survey in a format of others.", add_arguments, run)

"""gpr20 export: a survey in a format of others."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, List, Sequence, Tuple

import xarray as xr

from gpr20_analysis.commands import outputs, scheduler, survey_input
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError
from gpr20_analysis.low.whole_output import whole_output
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
from gpr20_analysis.mid.processing.sweep import Sweep, Window
from gpr20_analysis.mid.survey_source import Progress

Writer = Callable[[xr.Dataset, Path, argparse.Namespace], str]


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


def _netcdf(survey: xr.Dataset, path: Path, _: argparse.Namespace) -> str:
    dataset_files.write_dataset(survey, path)
    return "everything"


def _group_csv(survey: xr.Dataset, path: Path, _: argparse.Namespace) -> str:
    return f"{group_csv.write_group_csv(survey, path, _progress())} files"


def _merged(survey: xr.Dataset, path: Path, chosen: argparse.Namespace) -> str:
    if dataset.A_SCAN in survey and chosen.domain == "frequency":
        raise ExportError("the data are A-scans over time; --domain time exports them as they are")
    merged_hdf5.write_merged(survey, path, path.stem)
    return f"A-scans over {'time' if dataset.A_SCAN in survey else 'frequency'}"


def _plain_csv(survey: xr.Dataset, path: Path, _: argparse.Namespace) -> str:
    return f"{plain_csv.write_plain_csv(survey, path, _progress())} samples"


def _segy(survey: xr.Dataset, path: Path, _: argparse.Namespace) -> str:
    return f"{segy.write_segy(survey, path, _progress())} traces"


def _touchstone(survey: xr.Dataset, path: Path, _: argparse.Namespace) -> str:
    return f"{touchstone.write_touchstone(survey, path, _progress())} files"


def _original(survey: xr.Dataset, path: Path, _: argparse.Namespace) -> str:
    return f"{original_json.write_original(survey, path, _progress())} files"


FORMATS: Dict[str, Format] = {
    "netcdf": Format(_netcdf, dataset_files.NETCDF),
    "zarr": Format(_netcdf, dataset_files.ZARR),
    "group-csv": Format(_group_csv, holds=("VNA_X*.csv",)),
    "merged-hdf5": Format(_merged, ".h5"),
    "csv": Format(_plain_csv, ".csv"),
    "segy": Format(_segy, ".sgy"),
    "touchstone": Format(_touchstone, holds=("[0-9]*_X*_Y*_Z*.s2p",)),
    "original-json": Format(_original, holds=("X*_Y*_Z*.json",)),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    survey_input.add_survey(parser)
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
    scheduler.add_scheduler(parser)


def run(chosen: argparse.Namespace) -> int:
    """Write the survey; return the exit status."""
    _check([chosen.output], chosen)
    survey = survey_input.load(chosen)
    with scheduler.machines(chosen) as machines, machines.fetched(
        _transformed(survey, chosen, machines)
    ) as fetched:
        _write_all(fetched, chosen)
    return survey_input.status_of(survey)


def _transformed(
    survey: xr.Dataset, chosen: argparse.Namespace, machines: scheduler.Machines
) -> xr.Dataset:
    over_time = chosen.format == "merged-hdf5" and chosen.domain == "time"
    if over_time and dataset.A_SCAN not in survey:
        return to_time(machines.spread(survey), Window.NONE, _padding_for_real_parts(survey))
    return survey


def _padding_for_real_parts(survey: xr.Dataset) -> float:
    # The group's programs work on the real part alone, which needs two samples per period of the
    # highest frequency; the complex values would need fewer.
    sweep = Sweep.of(survey)
    return 2.0 * float(sweep.frequency_hz[-1]) / (sweep.step_hz * sweep.count)


def _write_all(survey: xr.Dataset, chosen: argparse.Namespace) -> None:
    if chosen.format == "segy":
        for turn, path in enumerate(_segy_files(survey, chosen)):
            _write(survey.isel({dataset.POLARIZATION: [turn]}), path, chosen)
    else:
        _write(survey, chosen.output, chosen)


def _segy_files(survey: xr.Dataset, chosen: argparse.Namespace) -> List[Path]:
    # One file per polarization, which only the survey tells.
    turns = survey[dataset.POLARIZATION].values
    paths = [segy.file_of(chosen.output, turn) for turn in turns]
    _check(paths, chosen)
    return paths


def _check(paths: Sequence[Path], chosen: argparse.Namespace) -> None:
    form = FORMATS[chosen.format]
    for path in paths:
        if form.ending and path.suffix != form.ending:
            raise ExportError(f"{path} must end in {form.ending} for {chosen.format}")
    if form.ending in (dataset_files.NETCDF, dataset_files.ZARR):
        written = [outputs.dataset_output(path) for path in paths]
    else:
        written = [Output(path, form.holds) for path in paths]
    outputs.check(written, [chosen.survey], chosen.overwrite)


def _write(survey: xr.Dataset, path: Path, chosen: argparse.Namespace) -> None:
    form = FORMATS[chosen.format]
    if dataset_files.is_dataset(path) and not form.holds:
        told = form.write(survey, path, chosen)  # which is whole or not there by itself
    else:
        with whole_output(path, int(survey.nbytes)) as place:
            told = form.write(survey, place, chosen)
    print(f"{path}: {told}")


def _progress() -> Progress:
    return survey_input.progress_bar("writing")


COMMAND = Command("Write a survey in a format of others.", add_arguments, run)

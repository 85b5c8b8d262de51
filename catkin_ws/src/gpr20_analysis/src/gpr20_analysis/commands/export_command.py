"""gpr20 export: write a survey in another format."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Sequence

import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats.conversion import (
    EXPORTS,
    check_ending,
    export_format,
    export_survey,
    output_paths,
)
from gpr20_analysis.formats.dataset_files import NETCDF, ZARR
from gpr20_analysis.formats.format import RecordingExport
from gpr20_analysis.formats.sums_beside import sums_path
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.processing.to_frequency import to_frequency
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.radar.frequency_to_delay import Window


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    parser.add_argument(
        "output",
        type=Path,
        nargs="?",
        help="file, ending in "
        + ", ".join(f"{one.ending} ({name})" for name, one in EXPORTS.own.items() if one.ending)
        + "; a new folder for the formats with one file per sample; without it, a bag is made in "
        "the folder of the survey",
    )
    parser.add_argument("--format", choices=EXPORTS.names(), required=True, help="what to write")
    parser.add_argument(
        "--domain",
        choices=("frequency", "time"),
        help="formats that hold A-scans: over frequency or, by inverse Fourier transform, over "
        "time; default: as in the data",
    )
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Write the survey; return the exit status."""
    form = export_format(chosen.format)
    if chosen.output is None:
        if form.in_survey is None:
            raise ExportError(
                Message(
                    "the format {format} needs an output: give a file or folder behind the survey",
                    format=chosen.format,
                ),
                fault=faults.INPUT,
            )
        return _say(form.in_survey(chosen.survey), chosen.survey, catalogue)
    check_ending(chosen.output, chosen.format)
    _check([chosen.output], chosen)
    if form.of_recording is not None:
        progress = inputs.progress_bar("writing")
        return _say(
            form.of_recording(chosen.survey, chosen.output, progress), chosen.output, catalogue
        )
    survey = inputs.load(chosen, catalogue)
    _check(output_paths(survey, chosen.output, chosen.format), chosen)
    transformed = _transformed(survey, chosen)
    progress = inputs.progress_bar("writing")
    written = export_survey(transformed, chosen.output, chosen.format, progress)
    for path, content in written.items():
        say(f"{path}: {catalogue.text(content)}")
    return inputs.status_of(survey)


def _say(written: RecordingExport, path: Path, catalogue: Catalogue) -> int:
    """Print what was written, and on stderr what is left out or doubted; return the status."""
    content, said = written
    survey = xr.Dataset(attrs=said)
    inputs.print_warnings(survey, catalogue)
    say(f"{path}: {catalogue.text(content)}")
    return inputs.status_of(survey)


def _transformed(survey: xr.Dataset, chosen: argparse.Namespace) -> xr.Dataset:
    if not export_format(chosen.format).over_time:
        return survey
    if dataset.A_SCAN in survey:
        if chosen.domain == "frequency":
            return to_frequency(survey)
    elif chosen.domain == "time":
        return to_time(survey, Window.NONE, _padding_for_real_parts(survey))
    return survey


def _padding_for_real_parts(survey: xr.Dataset) -> float:
    # The group's programs use only the real part, which needs two samples per period of the
    # highest frequency; complex values would need fewer.
    sweep = FrequencyGrid.of(survey)
    return 2.0 * float(sweep.frequency_hz[-1]) / (sweep.step_hz * sweep.count)


def _check(paths: Sequence[Path], chosen: argparse.Namespace) -> None:
    form = export_format(chosen.format)
    if form.ending in (NETCDF, ZARR):
        written = [outputs.dataset_output(path) for path in paths]
    else:
        written = [Output(path, form.holds) for path in paths]
        if not form.has_own_checksum:
            written += [Output(sums_path(path)) for path in paths]
    outputs.check(written, [chosen.survey], chosen.overwrite)


COMMAND = Command("Write a survey in another format.", add_arguments, run)

"""gpr20 export: write a survey in another format."""

from __future__ import annotations

import argparse
from pathlib import Path

import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats.bags import RecordingExport, export_recording, make_survey_bag
from gpr20_analysis.formats.exports import (
    ENDINGS,
    HOLDS,
    OF_RECORDINGS,
    WRITERS,
    check_ending,
    export_survey,
    output_paths,
)
from gpr20_analysis.formats.facts import facts_path
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    endings = ", ".join(f"{ending} ({name})" for name, ending in ENDINGS.items() if ending)
    parser.add_argument(
        "output",
        type=Path,
        nargs="?",
        help=f"file, ending in {endings}; a new folder for the others; without it, a bag is made "
        "in the folder of the survey",
    )
    parser.add_argument("--format", choices=ENDINGS, required=True, help="what to write")
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Write the survey; return the exit status."""
    form, output = chosen.format, chosen.output
    if output is None:
        if form != "bag":
            raise ExportError(
                Message(
                    "the format {format} needs an output: give a file or folder behind the survey",
                    format=form,
                ),
                fault=faults.INPUT,
            )
        return _say(make_survey_bag(chosen.survey), chosen.survey, catalogue)
    check_ending(output, form)
    _check([output], chosen)
    progress = inputs.progress_bar("writing")
    if form in OF_RECORDINGS:
        written = export_recording(chosen.survey, output, form, progress)
        return _say(written, output, catalogue)
    survey = inputs.load(chosen, catalogue)
    _check(output_paths(survey, output, form), chosen)
    for path, content in export_survey(survey, output, form, progress).items():
        say(f"{path}: {content}")
    return inputs.status_of(survey)


def _say(written: RecordingExport, path: Path, catalogue: Catalogue) -> int:
    """Print what was written, and on stderr what is left out or doubted; return the status."""
    content, said = written
    survey = xr.Dataset(attrs=said)
    inputs.print_warnings(survey, catalogue)
    say(f"{path}: {content}")
    return inputs.status_of(survey)


def _check(paths: list, chosen: argparse.Namespace) -> None:
    written = [Output(path, HOLDS.get(chosen.format, ())) for path in paths]
    written += [Output(facts_path(path)) for path in paths if chosen.format in WRITERS]
    outputs.check(written, [chosen.survey], chosen.overwrite)


COMMAND = Command("Write a survey in another format.", add_arguments, run)

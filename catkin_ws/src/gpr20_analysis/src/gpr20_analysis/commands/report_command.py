"""gpr20 report: one self-contained page about a survey."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gpr20_analysis import dataset
from gpr20_analysis.commands import image_command, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.hiding_command import add_hiding, hiding_of
from gpr20_analysis.commands.outputs import Output
from gpr20_common.catalogue import Catalogue
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    parser.add_argument(
        "--output", "-o", type=Path, required=True, help="report to write: .html or .pdf"
    )
    image_command.add_image_options(parser)
    add_hiding(parser)
    outputs.add_overwrite(parser)
    parser.add_argument(
        "--json", action="store_true", help="print the result, or the error, as JSON, for programs"
    )


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Write the report; return the exit status."""
    from gpr20_analysis.report.build import check_report_path, write_report

    check_report_path(chosen.output)
    options = image_command.options_of(chosen)
    antenna, steps = image_command.antenna_steps(chosen), inputs.steps_of(chosen)
    outputs.check(
        [Output(chosen.output)], inputs.inputs_of(chosen, [*antenna, *steps]), chosen.overwrite
    )
    survey = inputs.load(chosen, catalogue)
    dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    survey, status = inputs.process(survey, antenna, catalogue)
    progress = inputs.progress_bar("creating the report")
    hiding = hiding_of(chosen, survey)
    write_report(
        survey, chosen.survey, chosen.output, options, steps, chosen.language, progress, hiding
    )
    say(json.dumps({"output": str(chosen.output)}) if chosen.json else chosen.output)
    return status


COMMAND = Command(
    "Write one HTML page, or a PDF, with verdict, candidates, image, quality and parameters of a "
    "survey. The page is self-contained.",
    add_arguments,
    run,
)

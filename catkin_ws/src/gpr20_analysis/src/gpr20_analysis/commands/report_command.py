"""gpr20 report: one self-contained page about a survey."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gpr20_analysis import dataset
from gpr20_analysis.commands import image_options, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.hiding_command import add_hiding, hiding_of
from gpr20_analysis.commands.outputs import Output
from gpr20_common.catalogue import Catalogue
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    image_options.add_options(parser)
    add = parser.add_argument
    add("--output", "-o", type=Path, required=True, help="report to write: .html")
    add("--pdf", type=Path, help="print it as PDF, too, by Chromium or WeasyPrint")
    add_hiding(parser)
    outputs.add_overwrite(parser)
    add("--json", action="store_true", help="print the result as JSON, for programs")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Write the report; return the exit status."""
    from gpr20_analysis.report.page import check_report_path, write_pdf
    from gpr20_analysis.report.sections import write_report

    check_report_path(chosen.output)
    options, steps = image_options.options_of(chosen), inputs.steps_of(chosen)
    written = [Output(one) for one in (chosen.output, chosen.pdf) if one]
    read = inputs.inputs_of(chosen, image_options.steps_of(chosen))
    outputs.check(written, read, chosen.overwrite)
    chosen.step, chosen.recipe = [], None  # the report shows the survey before and after them
    survey, status = image_options.processed(chosen, options, catalogue)
    dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    progress = inputs.progress_bar("creating the report")
    hiding = hiding_of(chosen, survey)
    write_report(
        survey, chosen.survey, chosen.output, options, steps, chosen.language, progress, hiding
    )
    if chosen.pdf:
        write_pdf(chosen.output, chosen.pdf)
    said = {"output": str(chosen.output)}
    say(json.dumps(said) if chosen.json else chosen.output)
    return status


COMMAND = Command(
    "Write one HTML page with verdict, candidates, image, quality and parameters of a "
    "survey. The page is self-contained.",
    add_arguments,
    run,
)

"""gpr20 report: one self-contained page about a survey."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gpr20_analysis import dataset
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import image_command, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError, wrong_ending
from gpr20_common.catalogue import Catalogue
from gpr20_common.low.catalogue_file import language_from_code

HTML, PDF = ".html", ".pdf"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    parser.add_argument(
        "--output", "-o", type=Path, required=True, help="report to write: .html or .pdf"
    )
    image_command.add_image_options(parser)
    outputs.add_overwrite(parser)
    parser.add_argument(
        "--json", action="store_true", help="print the result, or the error, as JSON, for programs"
    )


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Write the report; return the exit status."""
    if chosen.output.suffix not in (HTML, PDF):
        raise ExportError(wrong_ending(chosen.output, (HTML, PDF)))
    from gpr20_analysis.report.build import report_of
    from gpr20_analysis.report.page import page

    is_pdf = chosen.output.suffix == PDF
    if is_pdf:
        from gpr20_analysis.report.pdf import write_pdf

    options = image_command.options_of(chosen)
    steps = inputs.steps_of(chosen, image_command.DEFAULT_STEPS)
    outputs.check([Output(chosen.output)], inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = inputs.load(chosen, catalogue)
    dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    progress = inputs.progress_bar(catalogue.tr("creating the report"))
    report = report_of(
        survey,
        chosen.survey,
        steps,
        options,
        language_from_code(chosen.language),
        catalogue,
        progress,
    )
    with atomic_output(chosen.output) as place:
        if is_pdf:
            write_pdf(place, report, catalogue)
        else:
            place.write_text(page(report), encoding="utf-8")
    print(json.dumps({"output": str(chosen.output)}) if chosen.json else chosen.output)
    return inputs.status_of(survey)


COMMAND = Command(
    "Write one HTML page, or a PDF, with verdict, candidates, image, quality and parameters of a "
    "survey. The page is self-contained.",
    add_arguments,
    run,
)

"""gpr20 report: one self-contained page of a survey."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis import cluster, dataset
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import image_command, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError

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
    inputs.add_scheduler(parser)


def run(chosen: argparse.Namespace) -> int:
    """Write the report; return the exit status."""
    if chosen.output.suffix not in (HTML, PDF):
        raise ExportError(f"{chosen.output.name} must end in {HTML} or {PDF}")
    from gpr20_analysis.report.page import page
    from gpr20_analysis.report.pdf_pages import write_pdf
    from gpr20_analysis.report.sections import sections_of

    options = image_command.options_of(chosen)
    steps = inputs.steps_of(chosen, image_command.DEFAULT_STEPS)
    outputs.check([Output(chosen.output)], inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = inputs.load(chosen)
    dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    progress = inputs.progress_bar("making the report")
    with cluster.connected(chosen.scheduler):
        spread = cluster.spread(survey)
        sections = sections_of(spread, chosen.survey, steps, options, progress)
    title = f"GPR-20 survey {survey.attrs.get('survey_id', survey.attrs.get('source', ''))}"
    with atomic_output(chosen.output) as place:
        if chosen.output.suffix == PDF:
            write_pdf(place, title, sections)
        else:
            place.write_text(page(title, sections), encoding="utf-8")
    print(chosen.output)
    return inputs.status_of(survey)


COMMAND = Command(
    "Write one HTML page, or a PDF, with verdict, parameters, quality, views and the image of a "
    "survey. The page needs nothing else and loads nothing.",
    add_arguments,
    run,
)

"""gpr20 report: one self-contained page of a survey."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis.commands import image_command, processing_input, survey_input
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.info_command import status_of
from gpr20_analysis.errors import ExportError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    survey_input.add_survey(parser)
    processing_input.add_steps(parser)
    parser.add_argument("--output", "-o", type=Path, required=True, help="page to write, .html")
    image_command.add_image_options(parser)


def run(chosen: argparse.Namespace) -> int:
    """Write the report; return the exit status."""
    if chosen.output.suffix != ".html":
        raise ExportError(f"{chosen.output.name} must end in .html")
    from gpr20_analysis.mid.report.page import page
    from gpr20_analysis.mid.report.sections import sections_of

    options = image_command.options_of(chosen)
    survey = survey_input.load(chosen)
    steps = processing_input.steps_of(chosen, image_command.DEFAULT_STEPS)
    sections = sections_of(survey, chosen.survey, steps, options)
    title = f"GPR-20 survey {survey.attrs.get('survey_id', survey.attrs.get('source', ''))}"
    chosen.output.write_text(page(title, sections), encoding="utf-8")
    print(chosen.output)
    return status_of(survey)


COMMAND = Command(
    "Write one HTML page with parameters, verdict, quality, views and the image of a survey. The "
    "page needs nothing else and loads nothing.",
    add_arguments,
    run,
)

"""gpr20 process: apply a chain of steps and store the result."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.errors import StepError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.processing.chain import recorded_steps, text_of
from gpr20_analysis.processing.step_functions import STEPS
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    parser.add_argument("--output", "-o", type=Path, required=True, help="result: .nc")
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Process the survey and return the exit status."""
    steps = inputs.steps_of(chosen)
    if not steps:
        raise StepError(
            Message(
                "no step was given; use --step with one of: {steps}",
                steps=", ".join(STEPS.names()),
            )
        )
    written = [outputs.dataset_output(chosen.output)]
    outputs.check(written, inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = inputs.load(chosen, catalogue)
    result, status = inputs.process(survey, steps, catalogue)
    write_dataset(result, chosen.output)
    say(catalogue.tr("{path}, made by the steps:", path=chosen.output))
    say(*map(text_of, recorded_steps(result)))
    return status


COMMAND = Command(
    "Apply a chain of processing steps to a survey. The result records them.",
    add_arguments,
    run,
)

"""gpr20 process: apply a chain of steps and store the result with its recipe."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import RecipeError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.processing.chain import recipe_of, recipe_text
from gpr20_analysis.processing.step_functions import STEPS
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    parser.add_argument("--output", "-o", type=Path, required=True, help="result: .nc")
    parser.add_argument("--save-recipe", type=Path, help="write the whole recipe to this YAML file")
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Process the survey and return the exit status."""
    steps = inputs.steps_of(chosen)
    if not steps:
        raise RecipeError(
            Message(
                "no step was given; use --step or --recipe with: {steps}",
                steps=", ".join(STEPS.names()),
            )
        )
    written = [outputs.dataset_output(chosen.output)]
    written += [Output(chosen.save_recipe)] if chosen.save_recipe else []
    outputs.check(written, inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = inputs.load(chosen, catalogue)
    result, status = inputs.process(survey, steps, catalogue)
    write_dataset(result, chosen.output)
    recipe = recipe_text(recipe_of(result))
    if chosen.save_recipe:
        with atomic_output(chosen.save_recipe) as place:
            place.write_text(recipe, encoding="utf-8")
    say(catalogue.tr("{path}, made by the steps:", path=chosen.output))
    say(*recipe.splitlines())
    return status


COMMAND = Command(
    "Apply a chain of processing steps to a survey. The recipe is stored in the result.",
    add_arguments,
    run,
)

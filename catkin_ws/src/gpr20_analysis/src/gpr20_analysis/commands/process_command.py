"""gpr20 process: apply a chain of steps and keep the result with its recipe."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis.commands import outputs, processing_input, scheduler, survey_input
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.low.recipe_file import recipe_text
from gpr20_analysis.low.whole_output import whole_output
from gpr20_analysis.mid.dataset_files import write_dataset
from gpr20_analysis.mid.processing.chain import recipe_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    survey_input.add_survey(parser)
    processing_input.add_steps(parser)
    parser.add_argument("--output", "-o", type=Path, required=True, help="result: .nc or .zarr")
    parser.add_argument("--save-recipe", type=Path, help="write the whole recipe to this YAML file")
    outputs.add_overwrite(parser)
    scheduler.add_scheduler(parser)


def run(chosen: argparse.Namespace) -> int:
    """Process the survey and return the exit status."""
    steps = processing_input.steps_of(chosen)
    processing_input.require_steps(steps)
    written = [outputs.dataset_output(chosen.output)]
    written += [Output(chosen.save_recipe)] if chosen.save_recipe else []
    outputs.check(written, processing_input.inputs_of(chosen, steps), chosen.overwrite)
    survey = survey_input.load(chosen)
    with scheduler.machines(chosen) as machines:
        result, status = processing_input.process(machines.spread(survey), steps)
        with machines.fetched(result) as fetched:
            write_dataset(fetched, chosen.output)
    recipe = recipe_text(recipe_of(result))
    if chosen.save_recipe:
        with whole_output(chosen.save_recipe) as place:
            place.write_text(recipe, encoding="utf-8")
    print(f"{chosen.output}, made by\n{recipe}", end="")
    return status


COMMAND = Command(
    "Apply a chain of processing steps to a survey. The recipe is kept in the result.",
    add_arguments,
    run,
)

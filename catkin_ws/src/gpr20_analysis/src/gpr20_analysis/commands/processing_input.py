"""The arguments by which a subcommand takes a chain of steps."""

from __future__ import annotations

import argparse
import enum
from pathlib import Path
from typing import List, Sequence, Tuple

import xarray as xr

from gpr20_analysis.commands import survey_input
from gpr20_analysis.errors import RecipeError
from gpr20_analysis.low.recipe_file import read_recipe
from gpr20_analysis.mid.loading import load_survey
from gpr20_analysis.mid.processing.chain import (
    FUNCTIONS,
    Step,
    apply_steps,
    parameters_of,
    step_from_text,
    steps_from_recipe,
)


def add_steps(parser: argparse.ArgumentParser) -> None:
    """Declare the steps."""
    parser.add_argument(
        "--step",
        action="append",
        default=[],
        metavar="NAME[:PARAMETER=VALUE,...]",
        help="a step, as often as wanted, in their order; " + "; ".join(map(_shown, FUNCTIONS)),
    )
    parser.add_argument("--recipe", type=Path, help="YAML file with a list of steps, taken first")


def steps_of(chosen: argparse.Namespace, default: Sequence[str] = ()) -> List[Step]:
    """Return the steps that were asked for, or the default if none was.

    Raises:
        RecipeError: A step is not written as it must be.
    """
    steps = steps_from_recipe(read_recipe(chosen.recipe)) if chosen.recipe else []
    steps += [step_from_text(text) for text in chosen.step]
    return steps or [step_from_text(text) for text in default]


def inputs_of(chosen: argparse.Namespace, steps: Sequence[Step]) -> List[Path]:
    """Return every file and folder that is read, which must not be written."""
    named = [
        Path(step.parameters[key])
        for step in steps
        for key, (kind, _) in parameters_of(step.name).items()
        if kind is xr.Dataset
    ]
    return [chosen.survey, *([chosen.recipe] if chosen.recipe else []), *named]


def process(survey: xr.Dataset, steps: Sequence[Step]) -> Tuple[xr.Dataset, int]:
    """Apply the steps; return the result and the exit status for the surveys it was made of.

    A survey that a step names is refused if it is damaged, and what it lacks is told.
    """
    statuses = [survey_input.status_of(survey)]

    def read(path: str) -> xr.Dataset:
        reference = load_survey(path, progress=survey_input.progress_bar(f"reading {path}"))
        survey_input.tell(reference, f" in {path}")
        statuses.append(survey_input.status_of(reference))
        return reference

    for step in survey_input.progress_bar("processing")(steps, len(steps)):
        survey = apply_steps(survey, [step], read)
    return survey, max(statuses)


def require_steps(steps: Sequence[Step]) -> None:
    """Check that something is to be done.

    Raises:
        RecipeError: There is no step.
    """
    if not steps:
        raise RecipeError(f"no step was given; use --step or --recipe with {', '.join(FUNCTIONS)}")


def _shown(name: str) -> str:
    parameters = ",".join(
        f"{key}={_choice(kind)}" for key, (kind, _) in parameters_of(name).items()
    )
    return f"{name}:{parameters}" if parameters else name


def _choice(kind: type) -> str:
    return "|".join(one.value for one in kind) if issubclass(kind, enum.Enum) else kind.__name__

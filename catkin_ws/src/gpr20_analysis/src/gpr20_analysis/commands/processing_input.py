"""The arguments by which a subcommand takes a chain of steps."""

from __future__ import annotations

import argparse
import enum
from pathlib import Path
from typing import List, Sequence

import xarray as xr

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


def process(survey: xr.Dataset, steps: Sequence[Step]) -> xr.Dataset:
    """Apply the steps; a survey that one of them names is loaded whole or refused."""
    return apply_steps(survey, steps, load_survey)


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

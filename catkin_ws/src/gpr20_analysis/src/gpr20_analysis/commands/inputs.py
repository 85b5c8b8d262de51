"""The arguments by which a subcommand takes a survey, and how it tells of what is wrong in it."""

from __future__ import annotations

import argparse
import enum
import sys
from pathlib import Path
from typing import Any, Iterable, List, Optional, Sequence, Tuple

import xarray as xr
from tqdm import tqdm

from gpr20_analysis.commands.command import DAMAGED, DONE, NOT_COMPLETE
from gpr20_analysis.errors import RecipeError
from gpr20_analysis.processing.chain import (
    FUNCTIONS,
    Step,
    apply_steps,
    parameters_of,
    read_recipe,
    step_from_text,
    steps_from_recipe,
)
from gpr20_analysis.read.load import load_survey

TOLD = 8


def add_survey(parser: argparse.ArgumentParser) -> None:
    """Declare the survey and what may be wrong in it."""
    parser.add_argument(
        "survey",
        type=Path,
        help="folder of a survey, folder of its JSON files, .bag, .mcap, or a .nc or .zarr",
    )
    parser.add_argument(
        "--accept-damaged",
        action="store_true",
        help="leave damaged samples out, marked, instead of refusing the survey",
    )


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Declare the cluster that computes instead of this process."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="compute on a dask cluster, such as tcp://127.0.0.1:8786; its workers need this "
        "package and, for surveys of more than 1 GiB, see the same files",
    )


def load(chosen: argparse.Namespace) -> xr.Dataset:
    """Load the survey that was named, and say on stderr what is missing or damaged in it.

    Raises:
        AnalysisError: It cannot be loaded.
    """
    survey = load_survey(chosen.survey, chosen.accept_damaged, progress_bar("reading traces"))
    tell(survey)
    return survey


def status_of(survey: xr.Dataset) -> int:
    """Return the exit status that says how whole a survey is, or was before steps filled it."""
    if survey.attrs.get("faults"):
        return DAMAGED
    return NOT_COMPLETE if survey.attrs.get("missing") else DONE


def tell(survey: xr.Dataset, where: str = "") -> None:
    """Say on stderr what is missing or damaged in a survey."""
    for key, word in (("faults", "DAMAGED"), ("missing", "NO NUMBERS"), ("notes", "note")):
        sentences = survey.attrs.get(key, [])
        for sentence in sentences[:TOLD]:
            print(f"{word}{where}: {sentence}", file=sys.stderr)
        if len(sentences) > TOLD:
            print(f"{word}{where}: and {len(sentences) - TOLD} more", file=sys.stderr)


def progress_bar(what: str) -> Any:
    """Return a `Progress` that draws a bar on a terminal and is silent elsewhere."""

    def shown(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
        return tqdm(items, total=total, desc=what, disable=None, leave=False)

    return shown


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
    statuses = [status_of(survey)]

    def read(path: str) -> xr.Dataset:
        reference = load_survey(path, progress=progress_bar(f"reading {path}"))
        tell(reference, f" in {path}")
        statuses.append(status_of(reference))
        return reference

    for step in progress_bar("processing")(steps, len(steps)):
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

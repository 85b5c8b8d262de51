"""The input of a subcommand: its arguments, and the warnings about a survey."""

from __future__ import annotations

import argparse
import enum
import sys
from pathlib import Path
from typing import Any, Iterable, List, Optional, Sequence, Tuple

import xarray as xr
from tqdm import tqdm

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DAMAGED, DONE, NOT_COMPLETE
from gpr20_analysis.dataset import ANTENNA
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.chain import (
    Step,
    apply_steps,
    step_from_text,
)
from gpr20_analysis.processing.step_functions import FUNCTIONS, StepFunction
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sentences import remark_lines
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable, say


def add_survey(parser: argparse.ArgumentParser) -> None:
    """Declare the survey, and whether it may be damaged."""
    parser.add_argument(
        "survey",
        type=Path,
        help="folder of a survey, folder of its JSON files, .bag, .bag.active, .mcap, or .nc",
    )
    parser.add_argument(
        "--accept-damaged",
        action="store_true",
        help="mark damaged samples and leave them out, instead of refusing the survey",
    )


def load(chosen: argparse.Namespace, catalogue: Catalogue) -> xr.Dataset:
    """Load the survey and print on stderr what is missing or damaged in it.

    Raises:
        AnalysisError: It cannot be loaded.
    """
    progress = progress_bar("reading traces")
    survey = load_survey(chosen.survey, chosen.accept_damaged, progress)
    if ANTENNA in survey:
        raise WrongDatasetError(
            Message(
                "{path} is a model of antennas and no survey; use it with --antenna",
                path=chosen.survey,
            ),
            fault=faults.INPUT,
        )
    print_warnings(survey, catalogue)
    return survey


def status_of(survey: xr.Dataset) -> int:
    """Return the exit status for a survey."""
    if survey.attrs.get("faults"):
        return DAMAGED
    return NOT_COMPLETE if survey.attrs.get("missing") else DONE


def print_warnings(survey: xr.Dataset, catalogue: Catalogue, path: str = "") -> None:
    """Print on stderr what is missing or damaged in a survey.

    Args:
        survey: The survey.
        catalogue: Language of the output.
        path: Where it was read from, if it is not the survey of the command.
    """
    for line in remark_lines(survey, catalogue, path):
        say(line, file=sys.stderr)


def progress_bar(what: str) -> Any:
    """Return a `Progress` that draws a bar on a terminal and nothing elsewhere."""

    def shown(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
        return tqdm(items, total=total, desc=printable(what), disable=None, leave=False)

    return shown


def add_steps(parser: argparse.ArgumentParser) -> None:
    """Declare the steps."""
    parser.add_argument(
        "--step",
        action="append",
        default=[],
        metavar="NAME[:PARAMETER=VALUE,...]",
        help="a step; may be repeated, steps are applied in order; "
        + "; ".join(map(_usage, FUNCTIONS)),
    )


def steps_of(chosen: argparse.Namespace, default: Sequence[str] = ()) -> List[Step]:
    """Return the chosen steps, or the default without any.

    Raises:
        StepError: A step is malformed.
    """
    return [step_from_text(text) for text in chosen.step or default]


def inputs_of(chosen: argparse.Namespace, steps: Sequence[Step]) -> List[Path]:
    """Return all files and folders that are read, which must not be written."""
    named = [
        Path(step.parameters[key])
        for step in steps
        for key, (kind, _) in step.function.parameters.items()
        if kind is xr.Dataset
    ]
    return [chosen.survey, *named]


def process(
    survey: xr.Dataset, steps: Sequence[Step], catalogue: Catalogue
) -> Tuple[xr.Dataset, int]:
    """Apply the steps; return the result and the exit status for all surveys that were read.

    A survey that a step names is refused if it is damaged; warnings about it are printed.
    """
    statuses = [status_of(survey)]

    def read(path: str) -> xr.Dataset:
        progress = progress_bar(f"reading {path}")
        reference = load_survey(path, progress=progress)
        print_warnings(reference, catalogue, path)
        statuses.append(status_of(reference))
        return reference

    for step in progress_bar("processing")(steps, len(steps)):
        survey = apply_steps(survey, [step], read)
    return survey, max(statuses)


def _usage(name: str) -> str:
    known = StepFunction(name, FUNCTIONS[name]).parameters
    parameters = ",".join(f"{key}={_choice(kind)}" for key, (kind, _) in known.items())
    return f"{name}:{parameters}" if parameters else name


def _choice(kind: type) -> str:
    return "|".join(one.value for one in kind) if issubclass(kind, enum.Enum) else kind.__name__

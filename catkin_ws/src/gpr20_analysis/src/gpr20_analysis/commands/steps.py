"""The processing steps that a subcommand is given."""

from __future__ import annotations

import argparse
import enum
from pathlib import Path
from typing import List, Sequence, Tuple

import xarray as xr

from gpr20_analysis.commands.inputs import print_warnings, progress_bar, status_of
from gpr20_analysis.processing.chain import Step, apply_steps, step_from_text
from gpr20_analysis.processing.step_functions import FUNCTIONS, StepFunction
from gpr20_analysis.read.load import load_survey
from gpr20_common.catalogue import Catalogue


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


def steps_of(chosen: argparse.Namespace) -> List[Step]:
    """Return the chosen steps.

    Raises:
        StepError: A step is malformed.
    """
    return [step_from_text(text) for text in chosen.step]


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
        reference = load_survey(path, progress=progress_bar(f"reading {path}"))
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

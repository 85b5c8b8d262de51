"""The processing steps that a subcommand is given, and the options of an image."""

from __future__ import annotations

import argparse
import enum
from pathlib import Path
from typing import List, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.answer import with_height
from gpr20_analysis.commands import arguments
from gpr20_analysis.commands.command import per
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image_options import METHODS, ImageOptions, Method, imaging_method
from gpr20_analysis.imaging.permittivity import GIVEN_UNCERTAINTY, BuriedReference
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import (
    FUNCTIONS,
    STEPS,
    Step,
    StepFunction,
    apply_steps,
    checked,
    step_from_text,
)
from gpr20_analysis.read.load import load_survey
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.plan.annotation import USUAL_FALSE_ALARMS_PER_M2
from gpr20_survey.radar import ANY_SOIL, Soils

MOST_DEPTHS = 5000
SOILS = {one.name.lower().replace("_", "-"): one for one in Soils}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Declare survey, steps, and how an image is made."""
    arguments.add_survey(parser)
    add_steps(parser)
    add = parser.add_argument
    add("--method", choices=METHODS.names(), default=Method.PHASE_SHIFT.name)
    add("--antenna", type=Path, metavar="MODEL",
        help="model of the antennas, by gpr20 antenna, which is removed first of all; the "
        "reflection of the surface then gives the permittivity")  # fmt: skip
    add("--permittivity", type=float,
        help="relative permittivity; without this, --soil and --buried it is that of the surface "
        "(--antenna), else that of the survey: entered later, or of its plan; else that of any "
        f"soil is assumed ({ANY_SOIL.lowest:g} to {ANY_SOIL.highest:g})")  # fmt: skip
    add("--permittivity-uncertainty", type=float, metavar="SHARE", default=GIVEN_UNCERTAINTY,
        help="what a given permittivity may be off, as a share of it, for the uncertainty of "
        f"depths; default {GIVEN_UNCERTAINTY:g}")  # fmt: skip
    add("--soil", choices=list(SOILS), help="kind of soil, with its usual range of permittivity")
    add("--buried", type=per(MM_PER_M), nargs=3, metavar=("X_MM", "Y_MM", "DEPTH_MM"),
        help="buried metal object: its place and the depth of its top, which give the "
        "permittivity")  # fmt: skip
    add("--depth", type=float, nargs=3, default=(0.0, 0.3, 0.003),
        metavar=("FIRST", "LAST", "STEP"),
        help="depths of the image [m]; default 0 0.3 0.003")  # fmt: skip
    add("--height", type=float, metavar="M",
        help="one antenna height for all samples instead of the recorded ones")  # fmt: skip
    add("--leave-out-missing", action="store_true",
        help="make the image without the missing samples")  # fmt: skip
    add("--separation", type=float, default=0.0, metavar="M",
        help="distance between the antennas; used by back-projection and --buried; default: the "
        "one that the survey records, else 0")  # fmt: skip
    add("--ground", choices=[one.value for one in Ground],
        help="why the recorded heights differ: level: the antennas moved up and down; uneven: the "
        "ground rises and falls, which only back-projection supports")  # fmt: skip
    add("--delay", type=per(1e9), metavar="NS",
        help="delay of cables and antennas to remove [ns]; default: the one of the survey, see "
        "gpr20 delay")  # fmt: skip
    add("--false-alarms", type=float, metavar="N",
        help="where the list of candidates is cut: so many places per m2 there are on ground "
        "without bodies; default: as the survey's site has set it, else "
        f"{USUAL_FALSE_ALARMS_PER_M2:g}")  # fmt: skip


def options_of(chosen: argparse.Namespace) -> ImageOptions:
    """Return the options of the image.

    Raises:
        WrongDatasetError: An argument is not allowed.
    """
    return ImageOptions(
        method=imaging_method(chosen.method),
        permittivity=chosen.permittivity,
        permittivity_uncertainty=chosen.permittivity_uncertainty,
        soil=SOILS[chosen.soil] if chosen.soil else None,
        buried=BuriedReference(*chosen.buried) if chosen.buried else None,
        depth_m=_depths_m(*chosen.depth),
        height_m=chosen.height,
        leave_out_missing=chosen.leave_out_missing,
        separation_m=chosen.separation,
        ground=Ground(chosen.ground) if chosen.ground else None,
        delay_s=chosen.delay,
        false_alarms_per_m2=chosen.false_alarms,
    )


def _depths_m(first: float, last: float, step: float) -> Tuple[float, ...]:
    count = np.floor((last - first) / step + 1e-9) + 1.0 if step else np.nan
    # Written so that NaN is refused too.
    if not 2.0 <= count <= MOST_DEPTHS:
        raise WrongDatasetError(
            Message(
                "--depth {first_m:g} {last_m:g} {step_m:g} gives {count:.0f} depths; use 2 to "
                "{most}",
                first_m=first,
                last_m=last,
                step_m=step,
                count=max(count, 0.0),
                most=MOST_DEPTHS,
            ),
            fault=NOT_ALLOWED,
        )
    return tuple(first + step * np.arange(int(count)))


def steps_of(chosen: argparse.Namespace) -> List[Step]:
    """Return the step that removes the antennas, if they are given, and the chosen steps.

    Raises:
        StepError: A step is malformed.
    """
    antenna = [checked("antenna", {"model": str(chosen.antenna)})] if chosen.antenna else []
    return [*antenna, *chosen_steps(chosen)]


def processed(
    chosen: argparse.Namespace, options: ImageOptions, wanted: List[Step], catalogue: Catalogue
) -> Tuple[xr.Dataset, int]:
    """Return the survey after some steps, and the exit status.

    Raises:
        AnalysisError: The survey cannot be read, or a step cannot be applied.
    """
    survey = arguments.load(chosen, catalogue)
    if chosen.antenna:
        survey = with_height(survey, options.height_m)
    return process(survey, wanted, catalogue)


def add_steps(parser: argparse.ArgumentParser) -> None:
    """Declare the steps."""
    parser.add_argument(
        "--step",
        action="append",
        default=[],
        metavar="NAME[:PARAMETER=VALUE,...]",
        help="a step; may be repeated, steps are applied in order; "
        + "; ".join([*map(_usage, FUNCTIONS), *STEPS.added()]),
    )


def chosen_steps(chosen: argparse.Namespace) -> List[Step]:
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
    statuses = [arguments.status_of(survey)]

    def read(path: str) -> xr.Dataset:
        reference = load_survey(path, progress=arguments.progress_bar(f"reading {path}"))
        arguments.print_warnings(reference, catalogue, path)
        statuses.append(arguments.status_of(reference))
        return reference

    for step in arguments.progress_bar("processing")(steps, len(steps)):
        survey = apply_steps(survey, [step], read)
    return survey, max(statuses)


def _usage(name: str) -> str:
    known = StepFunction(name, FUNCTIONS[name]).parameters
    parameters = ",".join(f"{key}={_choice(kind)}" for key, (kind, _) in known.items())
    return f"{name}:{parameters}" if parameters else name


def _choice(kind: type) -> str:
    return "|".join(one.value for one in kind) if issubclass(kind, enum.Enum) else kind.__name__

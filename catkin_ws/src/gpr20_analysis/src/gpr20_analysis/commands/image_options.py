"""The options of an image, for every command that makes one."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import List, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.answer import Answer, answer, with_height
from gpr20_analysis.candidates.table import candidate_lines
from gpr20_analysis.commands import inputs
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import METHODS, Method, imaging_method
from gpr20_analysis.imaging.permittivity import GIVEN_UNCERTAINTY, permittivity_line
from gpr20_analysis.imaging.permittivity_source import BuriedReference
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import Step, checked
from gpr20_analysis.read.survey_attributes import S_PER_NS
from gpr20_analysis.sentences import DOUBTS, NOTES, labelled, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.plan.annotation import USUAL_FALSE_ALARMS_PER_M2
from gpr20_survey.radar.soils import ANY_SOIL, Soils
from gpr20_survey.results.candidates import CandidateList, json_text

MOST_DEPTHS = 5000
SOILS = {one.name.lower().replace("_", "-"): one for one in Soils}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Declare survey, steps, and how an image is made."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
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
    add("--buried", type=float, nargs=3, metavar=("X_MM", "Y_MM", "DEPTH_MM"),
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
    add("--grid-step", type=float, metavar="MM",
        help="step of the image along X and Y; default the positions of the survey")  # fmt: skip
    add("--ground", choices=[one.value for one in Ground],
        help="why the recorded heights differ: level: the antennas moved up and down; uneven: the "
        "ground rises and falls, which only back-projection supports")  # fmt: skip
    add("--delay", type=float, metavar="NS",
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
    first, last, step = chosen.depth
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
    buried = chosen.buried and BuriedReference(*(one / MM_PER_M for one in chosen.buried))
    return ImageOptions(
        method=imaging_method(chosen.method),
        permittivity=chosen.permittivity,
        permittivity_uncertainty=chosen.permittivity_uncertainty,
        soil=SOILS[chosen.soil] if chosen.soil else None,
        buried=buried or None,
        depth_m=tuple(first + step * np.arange(int(count))),
        height_m=chosen.height,
        leave_out_missing=chosen.leave_out_missing,
        separation_m=chosen.separation,
        grid_step_m=None if chosen.grid_step is None else chosen.grid_step / MM_PER_M,
        ground=Ground(chosen.ground) if chosen.ground else None,
        delay_s=None if chosen.delay is None else chosen.delay * S_PER_NS,
        false_alarms_per_m2=chosen.false_alarms,
    )


def steps_of(chosen: argparse.Namespace) -> List[Step]:
    """Return the step that removes the antennas, if they are given, and the chosen steps.

    Raises:
        StepError: A step is malformed.
    """
    antenna = [checked("antenna", {"model": str(chosen.antenna)})] if chosen.antenna else []
    return [*antenna, *inputs.steps_of(chosen)]


def processed(
    chosen: argparse.Namespace, options: ImageOptions, catalogue: Catalogue
) -> Tuple[xr.Dataset, int]:
    """Return the survey after the chosen steps, and the exit status.

    Raises:
        AnalysisError: The survey cannot be read, or a step cannot be applied.
    """
    survey = inputs.load(chosen, catalogue)
    if chosen.antenna:
        survey = with_height(survey, options.height_m)
    return inputs.process(survey, steps_of(chosen), catalogue)


def answer_of(
    chosen: argparse.Namespace, options: ImageOptions, catalogue: Catalogue
) -> Tuple[Answer, int]:
    """Return what the survey shows, and the exit status.

    Raises:
        AnalysisError: The survey cannot be read or imaged.
    """
    survey, status = processed(chosen, options, catalogue)
    return answer(survey, options, inputs.progress_bar("imaging")), status


def add_list_options(parser: argparse.ArgumentParser) -> None:
    """Declare how the list of candidates is printed."""
    parser.add_argument("--weaker", action="store_true",
                        help="print the weaker echoes too, which are below the cut")  # fmt: skip
    parser.add_argument("--json", action="store_true",
                        help="print the list as JSON, for programs")  # fmt: skip


def print_answer(found: Answer, chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    """Print the notes on an image, its permittivity and the table of candidates."""
    if chosen.json:
        print(json.dumps(json.loads(json_text(found.found)), indent=2))
        return
    notes = notes_of(found.found)
    for line in [*notes, permittivity_line(found.image)]:
        say(shown(line, catalogue))
    say(*candidate_lines(found.found, catalogue, chosen.weaker))


def notes_of(found: CandidateList) -> List[Message]:
    """Return the notes on a list, those first that doubt it."""
    return [labelled(DOUBTS if one.fault_code else NOTES, one) for one in found.notes]

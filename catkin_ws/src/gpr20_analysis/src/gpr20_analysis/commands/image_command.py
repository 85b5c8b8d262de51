"""gpr20 image: the image of the ground, and the candidates in it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.candidates.search import CandidateOptions, find_candidates
from gpr20_analysis.candidates.table import candidate_lines
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output, save_figure
from gpr20_analysis.dataset import DEPTH, HEIGHT, MM_PER_M, POLARIZATION, PROCESSING, is_line
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import METHODS, Method, imaging_method
from gpr20_analysis.imaging.permittivity import GIVEN_UNCERTAINTY, permittivity_line
from gpr20_analysis.imaging.permittivity_source import BuriedReference
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.antenna_step import HARMLESS
from gpr20_analysis.processing.chain import Step, checked, recorded_steps
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.survey_attributes import S_PER_NS
from gpr20_analysis.sentences import DOUBTS, NOTES, labelled, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.radar.frequency_to_delay import Window
from gpr20_survey.radar.soils import ANY_SOIL, Soils
from gpr20_survey.results.candidates import (
    MOST_DOUBTFUL,
    CandidateList,
    candidate_record,
    list_record,
)

MOST_DEPTHS = 5000
FIGURES = ("projections_*.png", "slice_*mm.png")
ESTIMATE = ("depth_uncertainty",)
SOILS = {one.name.lower().replace("_", "-"): one for one in Soils}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    add_image_options(parser)
    add = parser.add_argument
    add("--output", "-o", type=Path, help="image, .nc")
    add(
        "--figures",
        type=Path,
        metavar="FOLDER",
        help="folder for PNG figures: maximum projections, slices at the depths of candidates",
    )
    outputs.add_overwrite(parser)
    add_candidate_options(parser)
    add("--json", action="store_true", help="print the candidates as JSON, for programs")


def add_candidate_options(parser: argparse.ArgumentParser) -> None:
    """Declare what is a candidate."""
    standard = CandidateOptions()
    add = parser.add_argument
    add("--false-alarms", type=float, default=standard.false_alarms_per_m2, metavar="N",
        help="how many echoes of the ground's own clutter per m2 may be as strong as a candidate; "
        f"default {standard.false_alarms_per_m2:g}")  # fmt: skip
    add("--clean-ground", type=Path, metavar="IMAGE",
        help="image, made in the same way, of such ground without bodies: its echoes give the "
        "density of false alarms")  # fmt: skip
    add("--most", type=int, metavar="N",
        help=f"longest list, in files too; default {standard.most}, of which at most "
        f"{MOST_DOUBTFUL} doubtful ones are printed")  # fmt: skip


def candidate_options_of(chosen: argparse.Namespace) -> CandidateOptions:
    """Return what is a candidate.

    Raises:
        WrongDatasetError: An argument is not allowed.
    """
    most = CandidateOptions().most if chosen.most is None else chosen.most
    return CandidateOptions(chosen.false_alarms, most)


def add_image_options(parser: argparse.ArgumentParser) -> None:
    """Declare how an image is made."""
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
    add(
        "--height",
        type=float,
        metavar="M",
        help="one antenna height for all samples instead of the recorded ones",
    )
    add(
        "--leave-out-missing",
        action="store_true",
        help="make the image without the missing samples",
    )
    add("--window", choices=[one.value for one in Window], default=Window.HANN.value,
        help="weights over the band")  # fmt: skip
    add("--widest-angle", type=float, default=70.0, metavar="DEG", help="to the vertical in air")
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


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Make the image and return the exit status."""
    options = options_of(chosen)
    listed = candidate_options_of(chosen)
    steps = steps_of(chosen)
    outputs.check(_outputs(chosen), inputs.inputs_of(chosen, steps), chosen.overwrite)
    image, status = image_of(chosen, options, catalogue)
    found = find_candidates(image, listed, clean_ground_of(chosen))
    _write(image, found, chosen, catalogue)
    _print(image, found, chosen, catalogue)
    return status


def clean_ground_of(chosen: argparse.Namespace) -> Optional[xr.Dataset]:
    """Return the image of clean ground; None if there is none."""
    return None if chosen.clean_ground is None else load_survey(chosen.clean_ground)


def image_of(
    chosen: argparse.Namespace, options: ImageOptions, catalogue: Catalogue
) -> Tuple[xr.Dataset, int]:
    """Return the image of the survey after its steps, and the exit status.

    Raises:
        AnalysisError: The survey cannot be read or imaged.
    """
    survey = inputs.load(chosen, catalogue)
    if chosen.antenna and options.height_m is not None:
        survey = survey.assign({HEIGHT: xr.full_like(survey[HEIGHT], options.height_m)})
    steps = steps_of(chosen, _default_steps(survey, options))
    processed, status = inputs.process(survey, steps, catalogue)
    progress = inputs.progress_bar("imaging")
    return image_survey(processed, options, progress), status


def steps_of(chosen: argparse.Namespace, default: Sequence[str] = ()) -> List[Step]:
    """Return the step that removes the antennas, if they are given, and the other steps.

    Raises:
        StepError: A step is malformed.
    """
    return [*antenna_steps(chosen), *inputs.steps_of(chosen, default)]


def antenna_steps(chosen: argparse.Namespace) -> List[Step]:
    """Return the step that removes the antennas, if they are given."""
    return [checked("antenna", {"model": str(chosen.antenna)})] if chosen.antenna else []


def _default_steps(survey: xr.Dataset, options: ImageOptions) -> Sequence[str]:
    """Return the steps of the method, unless a step before has left no surface echo to remove."""
    before = {one["step"] for one in recorded_steps(survey)}
    is_measured = not before or ("antenna" in before and before <= {"antenna", *HARMLESS})
    return options.method.default_steps if is_measured else ()


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
    return ImageOptions(
        method=imaging_method(chosen.method),
        permittivity=chosen.permittivity,
        permittivity_uncertainty=chosen.permittivity_uncertainty,
        soil=SOILS[chosen.soil] if chosen.soil else None,
        buried=BuriedReference(*(one / MM_PER_M for one in chosen.buried))
        if chosen.buried
        else None,
        depth_m=tuple(first + step * np.arange(int(count))),
        height_m=chosen.height,
        leave_out_missing=chosen.leave_out_missing,
        window=Window(chosen.window),
        widest_angle_deg=chosen.widest_angle,
        separation_m=chosen.separation,
        grid_step_m=None if chosen.grid_step is None else chosen.grid_step / MM_PER_M,
        ground=Ground(chosen.ground) if chosen.ground else None,
        delay_s=None if chosen.delay is None else chosen.delay * S_PER_NS,
    )


def _outputs(chosen: argparse.Namespace) -> List[Output]:
    found = [Output(chosen.figures, FIGURES)] if chosen.figures else []
    return [*found, *([outputs.dataset_output(chosen.output)] if chosen.output else [])]


def _write(
    image: xr.Dataset, found: CandidateList, chosen: argparse.Namespace, catalogue: Catalogue
) -> None:
    if chosen.output:
        write_dataset(image, chosen.output)
    if chosen.figures:
        with atomic_output(chosen.figures) as folder:
            _draw(image, found, folder, catalogue)


def _draw(image: xr.Dataset, found: CandidateList, folder: Path, catalogue: Catalogue) -> None:
    from gpr20_analysis.plotting.projections import marked_of, projection_figure
    from gpr20_analysis.plotting.scans import c_scan_figure

    folder.mkdir()
    for turn, degrees in enumerate(image[POLARIZATION].values):
        figure = projection_figure(image, turn, found.candidates, catalogue)
        word = "combined" if np.isnan(degrees) else f"{degrees:g}deg"
        save_figure(figure, folder / f"projections_{word}.png")
    marked = [] if is_line(image) else marked_of(found.candidates)
    depths_m = image[DEPTH].sel(depth=[one.depth_m for one in marked], method="nearest")
    for depth_m in list(dict.fromkeys(depths_m.values.tolist())):
        figure = c_scan_figure(image, depth_m, catalogue)
        save_figure(figure, folder / f"slice_{round(depth_m * MM_PER_M):04d}mm.png")


def _print(
    image: xr.Dataset, found: CandidateList, chosen: argparse.Namespace, catalogue: Catalogue
) -> None:
    if chosen.json:
        answer = {
            **list_record(found),
            **{key: image.attrs[key] for key in ESTIMATE if key in image.attrs},
            "processing": json.loads(image.attrs.get(PROCESSING, "[]")),
            "candidates": [candidate_record(one, found) for one in found.candidates],
        }
        print(json.dumps(answer, indent=2, allow_nan=False))
        return
    print_candidates(image, found, chosen, catalogue)


def print_candidates(
    image: xr.Dataset, found: CandidateList, chosen: argparse.Namespace, catalogue: Catalogue
) -> None:
    """Print the notes on an image, its permittivity and the table of candidates."""
    notes = [labelled(DOUBTS if one.fault_code else NOTES, one) for one in found.notes]
    for line in [*notes, permittivity_line(image)]:
        say(shown(line, catalogue))
    # Who asks for a number gets all of the list.
    most_doubtful = MOST_DOUBTFUL if chosen.most is None else None
    say(*candidate_lines(found, catalogue, most_doubtful))


COMMAND = Command(
    "Image the ground below a survey and list the candidates in it. Without steps coupling "
    "and surface echo are subtracted first (background:method=surface).",
    add_arguments,
    run,
)

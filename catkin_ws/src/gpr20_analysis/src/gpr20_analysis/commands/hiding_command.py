"""gpr20 hiding: where in a survey a mine could hide from its own detector."""

from __future__ import annotations

import argparse
import functools
from dataclasses import replace
from pathlib import Path
from typing import Optional

import numpy as np
import xarray as xr

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.candidates.answer import with_height
from gpr20_analysis.candidates.files import JSON, check_ending, output_paths
from gpr20_analysis.commands import image_options, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import FORMATS, Output, save_figure
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.hiding.files import read_hiding, write_hiding
from gpr20_analysis.hiding.search import Detector, HidingOptions, map_hidden
from gpr20_analysis.processing.chain import apply_steps
from gpr20_analysis.processing.delay import recorded_separation_m
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.results.hidden_target import Targets, target_of
from gpr20_survey.results.hiding_map import HidingMap

STANDARD = HidingOptions()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    image_options.add_options(parser)
    add = parser.add_argument
    names = ", ".join(one.value.name for one in Targets)
    depths_mm = " ".join(f"{MM_PER_M * one:g}" for one in STANDARD.depth_m)
    add("--target", default=Targets.TYPE_72.value.name, metavar="TARGET",
        help=f"{names}, disc:DIAMETER:HEIGHT:PERMITTIVITY or ball:DIAMETER of metal, sizes in mm; "
        f"default {Targets.TYPE_72.value.name}")  # fmt: skip
    add("--target-depths", type=float, nargs="+", metavar="MM",
        help=f"depths of its top; default {depths_mm}")  # fmt: skip
    add("--loss-tangent", type=float, default=STANDARD.loss_tangent,
        help="of the soil: about 0.01 of dry sand, 0.05 of moist sand, 0.2 of wet clay; default "
        f"{STANDARD.loss_tangent:g}")  # fmt: skip
    add("--needed", type=float, default=STANDARD.needed, metavar="SHARE",
        help="share of the targets that must be found near a place, else one could hide there; "
        f"default {STANDARD.needed:g}")  # fmt: skip
    add("--rounds", type=int, default=STANDARD.rounds, metavar="N",
        help=f"how many lattices of targets are tried at each depth; default {STANDARD.rounds}; "
        "more give a finer map")  # fmt: skip
    add("--seed", type=int, default=STANDARD.seed, help="of the random places; default 0")
    add("--output", "-o", type=Path, action="append", default=[],
        help="map as .json, which report and view read, or a picture "
        f"({', '.join(FORMATS)}); may be given more than once")  # fmt: skip
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Make, print and write the map; return the exit status."""
    options = image_options.options_of(chosen)
    target, hiding = target_of(chosen.target), _options_of(chosen)
    steps = image_options.steps_of(chosen)
    written = []
    for path in chosen.output:
        if path.suffix in FORMATS:
            written.append(Output(path))
        else:
            check_ending(path, (JSON,))
            written += [Output(one) for one in output_paths(path)]
    outputs.check(written, inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = with_height(inputs.load(chosen, catalogue), options.height_m)
    read = functools.lru_cache(maxsize=None)(load_survey)
    detector = Detector(options, lambda one: apply_steps(one, steps, read))
    antenna: Optional[xr.Dataset] = load_survey(chosen.antenna) if chosen.antenna else None
    progress = inputs.progress_bar("hiding targets")
    hiding = replace(hiding, separation_m=chosen.separation or recorded_separation_m(survey))
    found = map_hidden(survey, detector, target, hiding, antenna, progress)
    _write(found, chosen, catalogue)
    say(*(shown(one, catalogue) for one in found.sentences))
    return inputs.status_of(survey)


def add_hiding(parser: argparse.ArgumentParser) -> None:
    """Declare a map to show."""
    parser.add_argument(
        "--hiding",
        type=Path,
        metavar="FILE",
        help="show where a mine could hide: a map by gpr20 hiding SURVEY -o FILE.json",
    )


def hiding_of(chosen: argparse.Namespace, survey: xr.Dataset) -> Optional[HidingMap]:
    """Return the map to show; None if none was given.

    Raises:
        AnalysisError: It cannot be read, or is one of another survey.
    """
    if chosen.hiding is None:
        return None
    found = read_hiding(chosen.hiding)
    survey_id = str(survey.attrs.get("survey_id", ""))
    if not survey_id or found.survey_id != survey_id:
        raise WrongDatasetError(
            Message(
                "{path} is a map of the survey {other}, not of {survey}; gpr20 import into a "
                "folder gives data an id",
                path=chosen.hiding,
                other=found.survey_id or "-",
                survey=survey_id or "-",
            ),
            fault=NOT_ALLOWED,
        )
    return found


def _options_of(chosen: argparse.Namespace) -> HidingOptions:
    depths_mm = chosen.target_depths
    return HidingOptions(
        depth_m=STANDARD.depth_m
        if depths_mm is None
        else tuple(np.round(np.array(depths_mm) / MM_PER_M, 6).tolist()),
        rounds=chosen.rounds,
        needed=chosen.needed,
        loss_tangent=chosen.loss_tangent,
        seed=chosen.seed,
    )


def _write(found: HidingMap, chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    for path in chosen.output:
        if path.suffix in FORMATS:
            from gpr20_analysis.plotting.maps import hiding_figure

            with atomic_output(path) as place:
                save_figure(hiding_figure(found, catalogue), place)
        else:
            write_hiding(found, path)


COMMAND = Command(
    "Map where a mine could hide: put a synthetic target into the survey's own spectra at many "
    "places and depths, and search it with the same detector. It holds for that target only.",
    add_arguments,
    run,
)

"""gpr20 report and hiding: the page about a survey, and where a mine could hide in it."""

from __future__ import annotations

import argparse
import functools
from pathlib import Path
from typing import List, Optional

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.candidates.answer import with_height
from gpr20_analysis.candidates.files import JSON, output_paths, read_hiding, write_hiding
from gpr20_analysis.commands import arguments, image_options
from gpr20_analysis.commands.command import Command, per
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.hiding.search import Detector, HidingOptions, map_hidden
from gpr20_analysis.processing.chain import apply_steps
from gpr20_analysis.processing.delay import recorded_separation_m
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.results.hiding_map import HidingMap, Targets, target_of

STANDARD = HidingOptions()


def _add_report(parser: argparse.ArgumentParser) -> None:
    image_options.add_options(parser)
    arguments.add_output(parser, [".html"], "report to write: .html", required=True)
    add_hiding(parser)


def _report(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    from gpr20_analysis.report.sections import write_report

    options, wanted = image_options.options_of(chosen), image_options.steps_of(chosen)
    arguments.check_outputs(
        [chosen.output], image_options.inputs_of(chosen, wanted), chosen.overwrite
    )
    # The report shows the survey before and after the chosen steps.
    first, later = (wanted[:1], wanted[1:]) if chosen.antenna else ([], wanted)
    survey, status = image_options.processed(chosen, options, first, catalogue)
    dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    progress = arguments.progress_bar("creating the report")
    hiding = hiding_of(chosen, survey)
    write_report(
        survey, chosen.survey, chosen.output, options, later, chosen.language, progress, hiding
    )
    say(chosen.output)
    return status


def _add_hiding_map(parser: argparse.ArgumentParser) -> None:
    image_options.add_options(parser)
    add = parser.add_argument
    names = ", ".join(one.value.name for one in Targets)
    depths_mm = " ".join(f"{dataset.MM_PER_M * one:g}" for one in STANDARD.depth_m)
    add("--target", default=Targets.TYPE_72.value.name, metavar="TARGET",
        help=f"{names}, disc:DIAMETER:HEIGHT:PERMITTIVITY or ball:DIAMETER of metal, sizes in mm; "
        f"default {Targets.TYPE_72.value.name}")  # fmt: skip
    add("--target-depths", type=per(dataset.MM_PER_M), nargs="+", metavar="MM",
        default=STANDARD.depth_m, help=f"depths of its top; default {depths_mm}")  # fmt: skip
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
    arguments.add_output(
        parser,
        [JSON, *arguments.PICTURES],
        "map as .json, which report and view read, or a picture "
        f"({', '.join(arguments.PICTURES)}); may be given more than once",
        action="append",
        default=[],
    )


def _map_hiding(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    options, wanted = image_options.options_of(chosen), image_options.steps_of(chosen)
    target = target_of(chosen.target)
    written: List[Path] = []
    for path in chosen.output:
        written += [path] if path.suffix in arguments.PICTURES else output_paths(path)
    arguments.check_outputs(written, image_options.inputs_of(chosen, wanted), chosen.overwrite)
    survey = with_height(arguments.load(chosen, catalogue), options.height_m)
    hiding = HidingOptions(
        depth_m=tuple(np.round(chosen.target_depths, 6).tolist()),
        rounds=chosen.rounds,
        needed=chosen.needed,
        loss_tangent=chosen.loss_tangent,
        seed=chosen.seed,
        separation_m=chosen.separation or recorded_separation_m(survey),
    )
    read = functools.lru_cache(maxsize=None)(load_survey)
    detector = Detector(options, lambda one: apply_steps(one, wanted, read))
    antenna: Optional[xr.Dataset] = load_survey(chosen.antenna) if chosen.antenna else None
    progress = arguments.progress_bar("hiding targets")
    found = map_hidden(survey, detector, target, hiding, antenna, progress)
    for path in chosen.output:
        if path.suffix in arguments.PICTURES:
            from gpr20_analysis.plotting.maps import hiding_figure

            arguments.save_figure(hiding_figure(found, catalogue), path)
        else:
            write_hiding(found, path)
    say(*(shown(one, catalogue) for one in found.sentences))
    return arguments.status_of(survey)


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


REPORT = Command(
    "Write one HTML page with verdict, candidates, image, quality and parameters of a "
    "survey. The page is self-contained.",
    _add_report,
    _report,
)
HIDING = Command(
    "Map where a mine could hide: put a synthetic target into the survey's own spectra at many "
    "places and depths, and search it with the same detector. It holds for that target only.",
    _add_hiding_map,
    _map_hiding,
)

"""gpr20 process, image, candidates and plot: steps, the image, places to check, figures."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, List, Optional, Tuple

import xarray as xr

from gpr20_analysis.candidates.answer import Answer, answer
from gpr20_analysis.candidates.files import ENDINGS, output_paths, write_candidates
from gpr20_analysis.candidates.table import candidate_lines
from gpr20_analysis.commands import arguments, image_options
from gpr20_analysis.commands.command import Command
from gpr20_analysis.dataset import A_SCAN, DELAY, MM_PER_M, X, Y
from gpr20_analysis.errors import StepError
from gpr20_analysis.formats.dataset_files import NETCDF, write_dataset
from gpr20_analysis.imaging.image_options import ImageOptions, check_range
from gpr20_analysis.imaging.permittivity import permittivity_line
from gpr20_analysis.processing.chain import STEPS, recorded_steps, text_of
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.sentences import DOUBTS, NOTES, labelled, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.results.candidates import json_text


def _add_process(parser: argparse.ArgumentParser) -> None:
    arguments.add_survey(parser)
    image_options.add_steps(parser)
    arguments.add_output(parser, [NETCDF], "result: .nc", required=True)


def _process(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    wanted = image_options.chosen_steps(chosen)
    if not wanted:
        names = ", ".join(STEPS.names())
        raise StepError(Message("no step was given; use --step with one of: {steps}", steps=names))
    arguments.check_outputs(
        [chosen.output], image_options.inputs_of(chosen, wanted), chosen.overwrite
    )
    result, status = image_options.process(arguments.load(chosen, catalogue), wanted, catalogue)
    write_dataset(result, chosen.output)
    say(f"{chosen.output}, made by the steps:", *map(text_of, recorded_steps(result)))
    return status


def _add_image(parser: argparse.ArgumentParser) -> None:
    _add_answer(parser)
    meaning = "image as .nc; may be given more than once"
    arguments.add_output(parser, [NETCDF], meaning, action="append", default=[])


def _image(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    found, status = _answer(chosen, chosen.output, catalogue)
    for path in chosen.output:
        write_dataset(found.image, path)
    _print(found, chosen, catalogue)
    return status


def _add_candidates(parser: argparse.ArgumentParser) -> None:
    _add_answer(parser)
    meaning = "list as .csv, .json or .geojson, with all weaker echoes; may be given more than once"
    arguments.add_output(parser, ENDINGS, meaning, action="append", default=[])


def _candidates(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    written = [one for path in chosen.output for one in output_paths(path)]
    found, status = _answer(chosen, written, catalogue)
    for path in chosen.output:
        write_candidates(found.found, path)
    _print(found, chosen, catalogue)
    return status


def _add_answer(parser: argparse.ArgumentParser) -> None:
    image_options.add_options(parser)
    add = parser.add_argument
    add("--weaker", action="store_true", help="print the weaker echoes too, below the cut")
    add("--json", action="store_true", help="print the list as JSON, for programs")


def _answer(
    chosen: argparse.Namespace, written: List[Path], catalogue: Catalogue
) -> Tuple[Answer, int]:
    options = image_options.options_of(chosen)
    wanted = image_options.steps_of(chosen)
    arguments.check_outputs(written, image_options.inputs_of(chosen, wanted), chosen.overwrite)
    survey, status = image_options.processed(chosen, options, wanted, catalogue)
    return answer(survey, options, arguments.progress_bar("imaging")), status


def _print(found: Answer, chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    if chosen.json:
        print(json.dumps(json.loads(json_text(found.found)), indent=2))  # noqa: T201
        return
    notes = [labelled(DOUBTS if one.fault_code else NOTES, one) for one in found.found.notes]
    for line in [*notes, permittivity_line(found.image)]:
        say(shown(line, catalogue))
    say(*candidate_lines(found.found, catalogue, chosen.weaker))


PROCESS = Command(
    "Apply a chain of processing steps to a survey. The result records them.",
    _add_process,
    _process,
)
IMAGE = Command(
    "Image the ground below a survey and list the candidates in it. Without steps coupling "
    "and surface echo are subtracted first (background:method=surface).",
    _add_image,
    _image,
)
CANDIDATES = Command(
    "List the candidates in the ground below a survey: places where its image is brighter than "
    "clutter. It is a list, no clearance. Without steps coupling and surface echo are subtracted.",
    _add_candidates,
    _candidates,
)


if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("a-scan", "b-scan", "c-scan", "coverage", "height")
NS_PER_S = 1e9


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("kind", choices=KINDS, help="what to draw")
    arguments.add_survey(parser)
    image_options.add_steps(parser)
    add("--x", type=float, metavar="MM", help="place of an A- or B-scan; default the middle")
    add("--y", type=float, metavar="MM", help="place of an A- or B-scan; default the middle")
    add("--along", choices=(X, Y), help="direction of a B-scan; default x")
    add("--delay", type=float, metavar="NS", help="delay of a C-scan; default the middle")
    add("--until", type=float, metavar="NS",
        help="last delay of A- and B-scans, inf for all; default that of an echo from 0.3 m in "
        "moist soil")  # fmt: skip
    add("--permittivity", type=float,
        help="relative permittivity: adds an axis of depth to a B-scan")  # fmt: skip
    arguments.add_output(parser, arguments.PICTURES, ".png, .svg or .pdf", required=True)


def _plot(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    wanted = image_options.chosen_steps(chosen)
    arguments.check_outputs(
        [chosen.output], image_options.inputs_of(chosen, wanted), chosen.overwrite
    )
    data, status = image_options.process(arguments.load(chosen, catalogue), wanted, catalogue)
    arguments.save_figure(_figure(data, chosen, catalogue), chosen.output)
    return status


def _figure(data: xr.Dataset, chosen: argparse.Namespace, catalogue: Catalogue) -> Figure:
    """Return the chosen figure.

    Raises:
        WrongDatasetError: The data do not contain what it shows.
    """
    from gpr20_analysis.plotting import maps, scans

    if chosen.kind == "coverage":
        return maps.coverage_figure(data, catalogue)
    if chosen.kind == "height":
        return maps.height_figure(data, catalogue)
    in_time = data if A_SCAN in data else to_time(data)
    if chosen.kind == "c-scan":
        delay_s = _within(in_time, DELAY, chosen.delay, NS_PER_S, "ns")
        return scans.c_scan_figure(in_time, delay_s, catalogue)
    x_m, y_m = (_within(data, axis, getattr(chosen, axis), MM_PER_M, "mm") for axis in (X, Y))
    shortest_ns = float(in_time[DELAY][1]) * NS_PER_S
    check_range("--until", chosen.until, shortest_ns, float("inf"), "ns")
    last_s = None if chosen.until is None else chosen.until / NS_PER_S
    if chosen.kind == "a-scan":
        return scans.a_scan_figure(in_time, x_m, y_m, last_s, catalogue)
    along = chosen.along or (Y if data.sizes[X] == 1 else X)
    return scans.b_scan_figure(
        in_time,
        along,
        y_m if along == X else x_m,
        last_s=last_s,
        permittivity=ImageOptions(permittivity=chosen.permittivity).permittivity,  # checked
        catalogue=catalogue,
    )


def _within(data: xr.Dataset, axis: str, given: Optional[float], scale: float, unit: str) -> float:
    """Return a place on an axis in SI units, which must be within the data; default the middle."""
    lowest, highest = (float(end) * scale for end in (data[axis].min(), data[axis].max()))
    check_range(f"--{axis}", given, lowest, highest, unit)
    return ((lowest + highest) / 2.0 if given is None else given) / scale


PLOT = Command(
    "Draw a survey or its A-scans. Missing samples are grey and counted below it. The image "
    "is in gpr20 report and gpr20 view.",
    _add_arguments,
    _plot,
)

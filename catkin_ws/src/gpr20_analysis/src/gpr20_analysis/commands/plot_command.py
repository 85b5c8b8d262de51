"""gpr20 plot: one figure of a survey or an image."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from gpr20_analysis.commands import outputs, processing_input, survey_input
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import ExportError, WrongDatasetError
from gpr20_analysis.low.figure_file import FORMATS, save_figure
from gpr20_analysis.low.whole_output import whole_output
from gpr20_analysis.mid.dataset import A_SCAN, DELAY, IMAGE, MM_PER_M, X, Y
from gpr20_analysis.mid.processing.delay import to_time

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("a-scan", "b-scan", "c-scan", "coverage", "height", "projection")
S_PER_NS = 1e-9


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("kind", choices=KINDS, help="what to draw")
    survey_input.add_survey(parser)
    processing_input.add_steps(parser)
    parser.add_argument("--x", type=float, metavar="MM", help="place; default the middle")
    parser.add_argument("--y", type=float, metavar="MM", help="place; default the middle")
    parser.add_argument("--along", choices=(X, Y), default=X, help="direction of a B-scan")
    parser.add_argument(
        "--value", choices=("magnitude", "real"), default="magnitude", help="B-scan"
    )
    parser.add_argument("--depth", type=float, metavar="MM", help="of a C-scan of an image")
    parser.add_argument("--delay", type=float, metavar="NS", help="of a C-scan of a survey")
    parser.add_argument("--until", type=float, metavar="NS", help="last delay of A- and B-scans")
    parser.add_argument("--rotation", type=float, metavar="DEG", help="of a projection")
    parser.add_argument("--output", "-o", type=Path, required=True, help=".png, .svg or .pdf")
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace) -> int:
    """Draw the figure and return the exit status."""
    if chosen.output.suffix not in FORMATS:
        raise ExportError(f"{chosen.output.name} must end in {', '.join(FORMATS)}")
    steps = processing_input.steps_of(chosen)
    inputs = processing_input.inputs_of(chosen, steps)
    outputs.check([Output(chosen.output)], inputs, chosen.overwrite)
    survey = survey_input.load(chosen)
    data, status = processing_input.process(survey, steps)
    figure = figure_of(data, chosen)
    with whole_output(chosen.output) as place:
        save_figure(figure, place)
    return status


def figure_of(data: xr.Dataset, chosen: argparse.Namespace) -> Figure:
    """Return the figure that was asked for.

    Raises:
        WrongDatasetError: The data do not hold what it shows.
    """
    from gpr20_analysis.mid.plotting import maps, scans

    if chosen.kind == "coverage":
        return maps.coverage_figure(data)
    if chosen.kind == "height":
        return maps.height_figure(data)
    if chosen.kind == "projection":
        return scans.projection_figure(data, _turn(data, chosen.rotation))
    if chosen.kind == "c-scan" and IMAGE in data:
        return scans.c_scan_figure(data, _needed(chosen.depth, "--depth") / MM_PER_M)
    in_time = data if A_SCAN in data else to_time(data)
    if chosen.kind == "c-scan":
        return scans.c_scan_figure(in_time, _needed(chosen.delay, "--delay") * S_PER_NS)
    if chosen.until is not None:
        in_time = _until(in_time, chosen.until * S_PER_NS)
    x_m, y_m = _place(data, X, chosen.x), _place(data, Y, chosen.y)
    if chosen.kind == "a-scan":
        return scans.a_scan_figure(in_time, x_m, y_m)
    at_m = y_m if chosen.along == X else x_m
    return scans.b_scan_figure(in_time, chosen.along, at_m, scans.Value(chosen.value))


def _place(data: xr.Dataset, axis: str, given_mm: float) -> float:
    lowest_m, highest_m = float(data[axis].min()), float(data[axis].max())
    if given_mm is None:
        return (lowest_m + highest_m) / 2.0
    if not lowest_m <= given_mm / MM_PER_M <= highest_m:
        raise WrongDatasetError(
            f"--{axis} {given_mm:g} mm is outside of the survey, which spans "
            f"{lowest_m * MM_PER_M:g}..{highest_m * MM_PER_M:g} mm"
        )
    return given_mm / MM_PER_M


def _until(in_time: xr.Dataset, last_s: float) -> xr.Dataset:
    shown = in_time.sel({DELAY: slice(None, last_s)})
    if shown.sizes[DELAY] < 2:
        raise WrongDatasetError(f"--until {last_s / S_PER_NS:g} ns leaves no trace to draw")
    return shown


def _needed(value: float, option: str) -> float:
    if value is None:
        raise WrongDatasetError(f"this figure needs {option}")
    return value


def _turn(data: xr.Dataset, rotation_deg: float) -> int:
    turns = data["polarization"].values
    if rotation_deg is None:
        return 0
    near = np.flatnonzero(np.abs(turns - rotation_deg) < 0.5)
    if near.size == 0:
        raise WrongDatasetError(f"--rotation {rotation_deg:g} was not measured; there is {turns}")
    return int(near[0])


COMMAND = Command(
    "Draw a survey, its A-scans or an image. Missing samples are grey, and said below the figure.",
    add_arguments,
    run,
)

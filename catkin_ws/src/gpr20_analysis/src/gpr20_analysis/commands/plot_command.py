"""gpr20 plot: one figure of a survey or an image."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Dict, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import cluster
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import FORMATS, Output, save_figure
from gpr20_analysis.dataset import A_SCAN, DELAY, DEPTH, IMAGE, MM_PER_M, X, Y
from gpr20_analysis.errors import ExportError, WrongDatasetError
from gpr20_analysis.processing.delay import to_time

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS: Dict[str, Tuple[str, ...]] = {
    "a-scan": ("x", "y", "until"),
    "b-scan": ("x", "y", "until", "along", "value"),
    "c-scan": ("depth", "delay"),
    "coverage": (),
    "height": (),
    "projection": ("rotation",),
}
"""The figures, and the options that say what of the data each shows."""
NS_PER_S = 1e9


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("kind", choices=KINDS, help="what to draw")
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    parser.add_argument("--x", type=float, metavar="MM", help="place; default the middle")
    parser.add_argument("--y", type=float, metavar="MM", help="place; default the middle")
    parser.add_argument("--along", choices=(X, Y), help="direction of a B-scan; default x")
    parser.add_argument(
        "--value", choices=("magnitude", "real"), help="of a B-scan; default magnitude"
    )
    parser.add_argument("--depth", type=float, metavar="MM", help="of a C-scan of an image")
    parser.add_argument("--delay", type=float, metavar="NS", help="of a C-scan of a survey")
    parser.add_argument("--until", type=float, metavar="NS", help="last delay of A- and B-scans")
    parser.add_argument("--rotation", type=float, metavar="DEG", help="of a projection")
    parser.add_argument("--output", "-o", type=Path, required=True, help=".png, .svg or .pdf")
    outputs.add_overwrite(parser)
    inputs.add_scheduler(parser)


def run(chosen: argparse.Namespace) -> int:
    """Draw the figure and return the exit status."""
    if chosen.output.suffix not in FORMATS:
        raise ExportError(f"{chosen.output.name} must end in {', '.join(FORMATS)}")
    _check_options(chosen)
    steps = inputs.steps_of(chosen)
    outputs.check([Output(chosen.output)], inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = inputs.load(chosen)
    with cluster.connected(chosen.scheduler):
        data, status = inputs.process(cluster.spread(survey), steps)
        figure = figure_of(data, chosen)
    with atomic_output(chosen.output) as place:
        save_figure(figure, place)
    return status


def _check_options(chosen: argparse.Namespace) -> None:
    own = KINDS[chosen.kind]
    for option in sorted({name for names in KINDS.values() for name in names} - set(own)):
        if getattr(chosen, option) is not None:
            allowed = ", ".join(f"--{name}" for name in own) or "none"
            raise WrongDatasetError(
                f"--{option} says nothing about the figure {chosen.kind}; its options are {allowed}"
            )


def figure_of(data: xr.Dataset, chosen: argparse.Namespace) -> Figure:
    """Return the figure that was asked for.

    Raises:
        WrongDatasetError: The data do not hold what it shows.
    """
    from gpr20_analysis.plotting import maps, scans

    if chosen.kind == "coverage":
        return maps.coverage_figure(data)
    if chosen.kind == "height":
        return maps.height_figure(data)
    if chosen.kind == "projection":
        return scans.projection_figure(data, _turn(data, chosen.rotation))
    if chosen.kind == "c-scan":
        return _c_scan(data, chosen)
    in_time = data if A_SCAN in data else to_time(data)
    if chosen.until is not None:
        in_time = _until(in_time, chosen.until)
    x_m, y_m = _place(data, X, chosen.x), _place(data, Y, chosen.y)
    if chosen.kind == "a-scan":
        return scans.a_scan_figure(in_time, x_m, y_m)
    along = chosen.along or X
    value = scans.Value(chosen.value) if chosen.value else scans.Value.MAGNITUDE
    return scans.b_scan_figure(in_time, along, y_m if along == X else x_m, value)


def _c_scan(data: xr.Dataset, chosen: argparse.Namespace) -> Figure:
    from gpr20_analysis.plotting import scans

    if IMAGE in data:
        if chosen.delay is not None:
            raise WrongDatasetError("--delay is of a survey; of an image name a --depth")
        return scans.c_scan_figure(data, _level(data, DEPTH, chosen.depth, MM_PER_M, "mm"))
    if chosen.depth is not None:
        raise WrongDatasetError(
            "--depth is of an image; make one with gpr20 image, or name a --delay of the survey"
        )
    in_time = data if A_SCAN in data else to_time(data)
    return scans.c_scan_figure(in_time, _level(in_time, DELAY, chosen.delay, NS_PER_S, "ns"))


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


def _until(in_time: xr.Dataset, last_ns: float) -> xr.Dataset:
    shown = in_time.sel({DELAY: in_time[DELAY].values * NS_PER_S <= last_ns})
    if shown.sizes[DELAY] < 2:
        raise WrongDatasetError(f"--until {last_ns:g} ns leaves no trace to draw")
    return shown


def _level(data: xr.Dataset, axis: str, given: Optional[float], scale: float, unit: str) -> float:
    """Return a depth or delay in SI units; it must be within the data."""
    if given is None:
        raise WrongDatasetError(f"this figure needs --{axis}")
    lowest, highest = (float(end) * scale for end in data[axis].values[[0, -1]])
    # Written so that NaN is refused too.
    if not lowest <= given <= highest:
        raise WrongDatasetError(
            f"--{axis} {given:g} {unit} is outside of the data, which span {lowest:g}.."
            f"{highest:g} {unit}"
        )
    return given / scale


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

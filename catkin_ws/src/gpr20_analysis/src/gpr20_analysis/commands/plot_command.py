"""gpr20 plot: one figure of a survey or an image."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Dict, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import FORMATS, Output, save_figure
from gpr20_analysis.dataset import A_SCAN, DELAY, DEPTH, IMAGE, MM_PER_M, X, Y
from gpr20_analysis.errors import ExportError, WrongDatasetError, wrong_ending
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.delay import to_time
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS: Dict[str, Tuple[str, ...]] = {
    "a-scan": ("x", "y", "until", "all_delays"),
    "b-scan": ("x", "y", "until", "all_delays", "along", "value", "permittivity"),
    "c-scan": ("depth", "delay"),
    "coverage": (),
    "height": (),
    "projection": ("rotation",),
}
"""The figures, and the options of each."""
NS_PER_S = 1e9


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("kind", choices=KINDS, help="what to draw")
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    parser.add_argument("--x", type=float, metavar="MM", help="position; default the middle")
    parser.add_argument("--y", type=float, metavar="MM", help="position; default the middle")
    parser.add_argument("--along", choices=(X, Y), help="direction of a B-scan; default x")
    parser.add_argument(
        "--value", choices=("magnitude", "real"), help="of a B-scan; default magnitude"
    )
    parser.add_argument("--depth", type=float, metavar="MM", help="depth of a C-scan of an image")
    parser.add_argument("--delay", type=float, metavar="NS", help="delay of a C-scan of a survey")
    parser.add_argument(
        "--until",
        type=float,
        metavar="NS",
        help="last delay of A- and B-scans; default that of an echo from 0.3 m in moist soil",
    )
    parser.add_argument(
        "--all-delays", action="store_true", default=None, help="A- and B-scans with all delays"
    )
    parser.add_argument(
        "--permittivity",
        type=float,
        help="relative permittivity: adds an axis of depth to a B-scan",
    )
    parser.add_argument("--rotation", type=float, metavar="DEG", help="rotation of a projection")
    parser.add_argument("--output", "-o", type=Path, required=True, help=".png, .svg or .pdf")
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Draw the figure and return the exit status."""
    if chosen.output.suffix not in FORMATS:
        raise ExportError(wrong_ending(chosen.output, FORMATS))
    _check_options(chosen)
    steps = inputs.steps_of(chosen)
    outputs.check([Output(chosen.output)], inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = inputs.load(chosen, catalogue)
    data, status = inputs.process(survey, steps, catalogue)
    figure = figure_of(data, chosen, catalogue)
    with atomic_output(chosen.output) as place:
        save_figure(figure, place)
    return status


def _check_options(chosen: argparse.Namespace) -> None:
    own = KINDS[chosen.kind]
    for option in sorted({name for names in KINDS.values() for name in names} - set(own)):
        if getattr(chosen, option) is not None:
            raise WrongDatasetError(
                Message(
                    "the figure {kind} has no option --{option}; its options are: {allowed}",
                    kind=chosen.kind,
                    option=option.replace("_", "-"),
                    allowed=", ".join(f"--{name}".replace("_", "-") for name in own) or "-",
                ),
                fault=NOT_ALLOWED,
            )


def figure_of(data: xr.Dataset, chosen: argparse.Namespace, catalogue: Catalogue) -> Figure:
    """Return the chosen figure.

    Raises:
        WrongDatasetError: The data do not contain what it shows.
    """
    from gpr20_analysis.plotting import maps, projections, scans

    if chosen.kind == "coverage":
        return maps.coverage_figure(data, catalogue)
    if chosen.kind == "height":
        return maps.height_figure(data, catalogue)
    if chosen.kind == "projection":
        turn = _turn(data, chosen.rotation)
        return projections.projection_figure(data, turn, catalogue=catalogue)
    if chosen.kind == "c-scan":
        return _c_scan(data, chosen, catalogue)
    in_time = data if A_SCAN in data else to_time(data)
    last_s = _last_s(in_time, chosen)
    x_m, y_m = _place(data, X, chosen.x), _place(data, Y, chosen.y)
    if chosen.kind == "a-scan":
        return scans.a_scan_figure(in_time, x_m, y_m, last_s, catalogue)
    along = chosen.along or (Y if data.sizes[X] == 1 else X)
    return scans.b_scan_figure(
        in_time,
        along,
        y_m if along == X else x_m,
        scans.Value(chosen.value) if chosen.value else scans.Value.MAGNITUDE,
        last_s,
        _permittivity(chosen.permittivity),
        catalogue,
    )


def _permittivity(given: Optional[float]) -> Optional[float]:
    # The same check as for an image.
    return ImageOptions(permittivity=given).permittivity


def _c_scan(data: xr.Dataset, chosen: argparse.Namespace, catalogue: Catalogue) -> Figure:
    from gpr20_analysis.plotting import scans

    if IMAGE in data:
        if chosen.delay is not None:
            raise WrongDatasetError(
                Message("--delay is for surveys; an image needs --depth"), fault=NOT_ALLOWED
            )
        depth_m = _level(data, DEPTH, chosen.depth, MM_PER_M, "mm")
        return scans.c_scan_figure(data, depth_m, catalogue)
    if chosen.depth is not None:
        raise WrongDatasetError(
            Message("--depth is for images; make one with gpr20 image, or use --delay"),
            fault=NOT_ALLOWED,
        )
    in_time = data if A_SCAN in data else to_time(data)
    delay_s = _level(in_time, DELAY, chosen.delay, NS_PER_S, "ns")
    return scans.c_scan_figure(in_time, delay_s, catalogue)


def _place(data: xr.Dataset, axis: str, given_mm: float) -> float:
    lowest_m, highest_m = float(data[axis].min()), float(data[axis].max())
    if given_mm is None:
        return (lowest_m + highest_m) / 2.0
    if not lowest_m <= given_mm / MM_PER_M <= highest_m:
        raise WrongDatasetError(
            _outside(axis, given_mm, lowest_m * MM_PER_M, highest_m * MM_PER_M, "mm"),
            fault=NOT_ALLOWED,
        )
    return given_mm / MM_PER_M


def _last_s(in_time: xr.Dataset, chosen: argparse.Namespace) -> Optional[float]:
    """Return the last delay that is shown [s]; None: the default."""
    if chosen.all_delays:
        return math.inf
    if chosen.until is None:
        return None
    # Written so that NaN is refused too.
    if not chosen.until >= float(in_time[DELAY][1]) * NS_PER_S:
        raise WrongDatasetError(
            Message("--until {last_ns:g} ns is too short, no trace is left", last_ns=chosen.until),
            fault=NOT_ALLOWED,
        )
    return float(chosen.until) / NS_PER_S


def _level(data: xr.Dataset, axis: str, given: Optional[float], scale: float, unit: str) -> float:
    """Return a depth or delay in SI units; it must be within the data."""
    if given is None:
        raise WrongDatasetError(
            Message("this figure needs --{option}", option=axis), fault=NOT_ALLOWED
        )
    lowest, highest = (float(end) * scale for end in data[axis].values[[0, -1]])
    # Written so that NaN is refused too.
    if not lowest <= given <= highest:
        raise WrongDatasetError(_outside(axis, given, lowest, highest, unit), fault=NOT_ALLOWED)
    return given / scale


def _outside(option: str, given: float, lowest: float, highest: float, unit: str) -> Message:
    return Message(
        "--{option} {value:g} {unit} is outside the data, which cover {lowest:g} to {highest:g} "
        "{unit}",
        option=option,
        value=given,
        unit=unit,
        lowest=lowest,
        highest=highest,
    )


def _turn(data: xr.Dataset, rotation_deg: float) -> int:
    turns = data["polarization"].values
    if rotation_deg is None:
        return 0
    near = np.flatnonzero(np.abs(turns - rotation_deg) < 0.5)
    if near.size == 0:
        raise WrongDatasetError(
            Message(
                "rotation {rotation_deg:g} deg was not measured; the data have {rotations} deg",
                rotation_deg=rotation_deg,
                rotations=", ".join(f"{turn:g}" for turn in turns),
            ),
            fault=NOT_ALLOWED,
        )
    return int(near[0])


COMMAND = Command(
    "Draw a survey, its A-scans or an image. Missing samples are grey and counted below it.",
    add_arguments,
    run,
)

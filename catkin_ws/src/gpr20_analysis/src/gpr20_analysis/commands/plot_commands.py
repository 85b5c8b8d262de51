"""gpr20 plot: one figure of a survey."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Optional

import xarray as xr

from gpr20_analysis.commands import image_options, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.dataset import A_SCAN, DELAY, MM_PER_M, X, Y
from gpr20_analysis.imaging.image_options import ImageOptions, check_range
from gpr20_analysis.processing.delay import to_time
from gpr20_common.catalogue import Catalogue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("a-scan", "b-scan", "c-scan", "coverage", "height")
NS_PER_S = 1e9


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("kind", choices=KINDS, help="what to draw")
    inputs.add_survey(parser)
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
    outputs.add_output(parser, outputs.PICTURES, ".png, .svg or .pdf", required=True)


def _plot(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    wanted = image_options.chosen_steps(chosen)
    outputs.check([chosen.output], image_options.inputs_of(chosen, wanted), chosen.overwrite)
    data, status = image_options.process(inputs.load(chosen, catalogue), wanted, catalogue)
    outputs.save_figure(_figure(data, chosen, catalogue), chosen.output)
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

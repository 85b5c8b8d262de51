"""A-, B- and C-scans."""

from __future__ import annotations

import enum

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from gpr20_analysis.dataset import (
    A_SCAN,
    DELAY,
    DEPTH,
    IMAGE,
    POLARIZATION,
    SAMPLE_DIMS,
    X,
    Y,
    require,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.plotting.style import (
    SIGNED_MAP,
    decibels,
    draw,
    draw_decibels,
    in_mm,
    new_figure,
    plan_axes,
    rotation_name,
)

NS_PER_S = 1e9


class Value(enum.Enum):
    """What of a complex trace is drawn."""

    MAGNITUDE = "magnitude"
    REAL = "real"


def a_scan_figure(in_time: xr.Dataset, x_m: float, y_m: float) -> Figure:
    """Draw the trace nearest to a place: envelope and real part of each polarization."""
    a_scans = require(in_time, A_SCAN, (*SAMPLE_DIMS, DELAY))
    trace = a_scans.sel({X: x_m, Y: y_m}, method="nearest")
    if not bool(np.isfinite(trace).any()):
        raise WrongDatasetError(f"at x {x_m:g} m, y {y_m:g} m no sample holds numbers")
    place = f"x {in_mm(trace[X]):g} mm, y {in_mm(trace[Y]):g} mm"
    figure = new_figure(in_time, title=f"A-scan at {place}")
    axes = figure.subplots()
    delay_ns = in_time[DELAY].values * NS_PER_S
    for turn, values in zip(in_time[POLARIZATION].values, trace.values):
        name = rotation_name(float(turn), in_time)
        (line,) = axes.plot(delay_ns, np.abs(values), label=f"{name}, envelope")
        axes.plot(delay_ns, values.real, lw=0.6, color=line.get_color(), label=f"{name}, real part")
    axes.set_xlabel("two-way delay [ns]")
    axes.set_ylabel("S21, linear")
    axes.legend(fontsize=8)
    return figure


def b_scan_figure(
    in_time: xr.Dataset, along: str, at_m: float, value: Value = Value.MAGNITUDE
) -> Figure:
    """Draw all traces of a line.

    Args:
        in_time: Dataset with `a_scan`.
        along: "x" or "y".
        at_m: Where the line crosses the other axis [m]; the nearest is taken.
        value: Envelope in dB, or the real part.
    """
    other = {X: Y, Y: X}[along]
    line = require(in_time, A_SCAN, (*SAMPLE_DIMS, DELAY)).sel({other: at_m}, method="nearest")
    turns = in_time[POLARIZATION].values
    figure = new_figure(
        in_time, len(turns), f"B-scan along {along} at {other} {in_mm(line[other]):g} mm"
    )
    line = line.compute()
    largest = float(np.nanmax(np.abs(line.values)))
    for axes, turn, values in zip(
        figure.subplots(1, len(turns), squeeze=False)[0], turns, line.values
    ):
        across, down = in_mm(in_time[along]), in_time[DELAY].values * NS_PER_S
        if value is Value.REAL:
            limits = {"cmap": SIGNED_MAP, "vmin": -largest, "vmax": largest}
            drawn = draw(axes, values.real.T, across, down, **limits)
            figure.colorbar(drawn, ax=axes, label="real part of S21, linear")
        else:
            draw_decibels(axes, decibels(values, largest).T, across, down)
        axes.invert_yaxis()
        axes.set_xlabel(f"{along} [mm]")
        axes.set_ylabel("two-way delay [ns]")
        axes.set_title(rotation_name(float(turn), in_time), fontsize=9)
    return figure


def c_scan_figure(data: xr.Dataset, at: float) -> Figure:
    """Draw a horizontal slice: of an image at a depth [m], of A-scans at a delay [s]."""
    if IMAGE in data:
        volume, level = require(data, IMAGE, (POLARIZATION, DEPTH, Y, X)), DEPTH
    else:
        volume, level = require(data, A_SCAN, (*SAMPLE_DIMS, DELAY)), DELAY
    taken = volume.sel({level: at}, method="nearest")
    scale, unit = (1000.0, "mm") if level == DEPTH else (NS_PER_S, "ns")
    turns = data[POLARIZATION].values
    figure = new_figure(
        data, len(turns), f"C-scan at {level} {float(taken[level]) * scale:.4g} {unit}"
    )
    largest = float(abs(volume).max())
    for axes, turn in zip(figure.subplots(1, len(turns), squeeze=False)[0], range(len(turns))):
        values = taken.isel({POLARIZATION: turn}).transpose(Y, X).values
        draw_decibels(axes, decibels(values, largest), in_mm(data[X]), in_mm(data[Y]))
        plan_axes(axes)
        axes.set_title(rotation_name(float(turns[turn]), data), fontsize=9)
    return figure


def projection_figure(image: xr.Dataset, turn: int) -> Figure:
    """Draw the maxima of one polarization over depth, over y and over x."""
    magnitude = abs(require(image, IMAGE, (POLARIZATION, DEPTH, Y, X)))
    largest = float(magnitude.max())
    volume = magnitude.isel({POLARIZATION: turn})
    name = rotation_name(float(image[POLARIZATION][turn]), image)
    title = (
        f"Maximum projections, {name}, permittivity {image.attrs.get('permittivity', np.nan):.3g}"
    )
    figure = new_figure(image, 3, title)
    for axes, over, down, across in zip(
        figure.subplots(1, 3), (DEPTH, Y, X), (Y, DEPTH, DEPTH), (X, X, Y)
    ):
        values = volume.max(over).transpose(down, across).values
        draw_decibels(axes, decibels(values, largest), in_mm(image[across]), in_mm(image[down]))
        axes.set_xlabel(f"{across} [mm]")
        axes.set_ylabel(f"{down} [mm]")
        axes.set_aspect("equal")
        axes.set_title(f"over {over}", fontsize=9)
        if down == DEPTH:
            axes.invert_yaxis()
    return figure

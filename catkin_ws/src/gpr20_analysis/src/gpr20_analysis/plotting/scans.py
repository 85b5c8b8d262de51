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
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message

NS_PER_S = 1e9


class Value(enum.Enum):
    """The part of a complex trace that is drawn."""

    MAGNITUDE = "magnitude"
    REAL = "real"


def a_scan_figure(
    in_time: xr.Dataset, x_m: float, y_m: float, catalogue: Catalogue = ENGLISH
) -> Figure:
    """Draw the trace nearest to a position: envelope and real part of each polarization."""
    a_scans = require(in_time, A_SCAN, (*SAMPLE_DIMS, DELAY))
    trace = a_scans.sel({X: x_m, Y: y_m}, method="nearest")
    if not bool(np.isfinite(trace).any()):
        raise WrongDatasetError(
            Message("no sample at x {x_m:g} m, y {y_m:g} m has data", x_m=x_m, y_m=y_m)
        )
    x_mm, y_mm = float(in_mm(trace[X])), float(in_mm(trace[Y]))
    title = catalogue.tr("A-scan at x {x_mm:g} mm, y {y_mm:g} mm", x_mm=x_mm, y_mm=y_mm)
    figure = new_figure(in_time, title=title, catalogue=catalogue)
    axes = figure.subplots()
    delay_ns = in_time[DELAY].values * NS_PER_S
    for turn, values in zip(in_time[POLARIZATION].values, trace.values):
        name = rotation_name(float(turn), in_time, catalogue)
        label = catalogue.tr("{rotation}, envelope", rotation=name)
        (line,) = axes.plot(delay_ns, np.abs(values), label=label)
        label = catalogue.tr("{rotation}, real part", rotation=name)
        axes.plot(delay_ns, values.real, lw=0.6, color=line.get_color(), label=label)
    axes.set_xlabel(catalogue.tr("two-way delay [ns]"))
    axes.set_ylabel(catalogue.tr("S21, linear"))
    axes.legend(fontsize=8)
    return figure


def b_scan_figure(
    in_time: xr.Dataset,
    along: str,
    at_m: float,
    value: Value = Value.MAGNITUDE,
    catalogue: Catalogue = ENGLISH,
) -> Figure:
    """Draw all traces of a line.

    Args:
        in_time: Dataset with `a_scan`.
        along: "x" or "y".
        at_m: Position of the line on the other axis [m]; the nearest line is drawn.
        value: Envelope in dB, or the real part.
        catalogue: Language of the texts.
    """
    other = {X: Y, Y: X}[along]
    line = require(in_time, A_SCAN, (*SAMPLE_DIMS, DELAY)).sel({other: at_m}, method="nearest")
    turns = in_time[POLARIZATION].values
    title = catalogue.tr(
        "B-scan along {axis} at {other} {position_mm:g} mm",
        axis=along,
        other=other,
        position_mm=float(in_mm(line[other])),
    )
    figure = new_figure(in_time, len(turns), title, catalogue)
    line = line.compute()
    largest = float(np.nanmax(np.abs(line.values)))
    for axes, turn, values in zip(
        figure.subplots(1, len(turns), squeeze=False)[0], turns, line.values
    ):
        across, down = in_mm(in_time[along]), in_time[DELAY].values * NS_PER_S
        if value is Value.REAL:
            limits = {"cmap": SIGNED_MAP, "vmin": -largest, "vmax": largest}
            drawn = draw(axes, values.real.T, across, down, **limits)
            figure.colorbar(drawn, ax=axes, label=catalogue.tr("real part of S21, linear"))
        else:
            draw_decibels(axes, decibels(values, largest).T, across, down, catalogue)
        axes.invert_yaxis()
        axes.set_xlabel(f"{along} [mm]")
        axes.set_ylabel(catalogue.tr("two-way delay [ns]"))
        axes.set_title(rotation_name(float(turn), in_time, catalogue), fontsize=9)
    return figure


def c_scan_figure(data: xr.Dataset, at: float, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw a horizontal slice: of an image at a depth [m], of A-scans at a delay [s]."""
    if IMAGE in data:
        volume, level = require(data, IMAGE, (POLARIZATION, DEPTH, Y, X)), DEPTH
    else:
        volume, level = require(data, A_SCAN, (*SAMPLE_DIMS, DELAY)), DELAY
    taken = volume.sel({level: at}, method="nearest")
    turns = data[POLARIZATION].values
    if level == DEPTH:
        depth_mm = float(in_mm(taken[level]))
        title = catalogue.tr("C-scan at depth {depth_mm:.4g} mm", depth_mm=depth_mm)
    else:
        delay_ns = float(taken[level]) * NS_PER_S
        title = catalogue.tr("C-scan at delay {delay_ns:.4g} ns", delay_ns=delay_ns)
    figure = new_figure(data, len(turns), title, catalogue)
    largest = float(abs(volume).max())
    for axes, turn in zip(figure.subplots(1, len(turns), squeeze=False)[0], range(len(turns))):
        values = taken.isel({POLARIZATION: turn}).transpose(Y, X).values
        draw_decibels(axes, decibels(values, largest), in_mm(data[X]), in_mm(data[Y]), catalogue)
        plan_axes(axes)
        axes.set_title(rotation_name(float(turns[turn]), data, catalogue), fontsize=9)
    return figure


def projection_figure(image: xr.Dataset, turn: int, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw the maxima of one polarization over depth, over y and over x."""
    magnitude = abs(require(image, IMAGE, (POLARIZATION, DEPTH, Y, X)))
    largest = float(magnitude.max())
    volume = magnitude.isel({POLARIZATION: turn})
    title = catalogue.tr(
        "Maximum projections, {rotation}, permittivity {permittivity:.3g}",
        rotation=rotation_name(float(image[POLARIZATION][turn]), image, catalogue),
        permittivity=float(image.attrs.get("permittivity", np.nan)),
    )
    figure = new_figure(image, 3, title, catalogue)
    names = {DEPTH: catalogue.tr("depth"), X: X, Y: Y}
    for axes, over, down, across in zip(
        figure.subplots(1, 3), (DEPTH, Y, X), (Y, DEPTH, DEPTH), (X, X, Y)
    ):
        values = volume.max(over).transpose(down, across).values
        across_mm, down_mm = in_mm(image[across]), in_mm(image[down])
        draw_decibels(axes, decibels(values, largest), across_mm, down_mm, catalogue)
        axes.set_xlabel(f"{names[across]} [mm]")
        axes.set_ylabel(f"{names[down]} [mm]")
        axes.set_aspect("equal")
        axes.set_title(catalogue.tr("over {axis}", axis=names[over]), fontsize=9)
        if down == DEPTH:
            axes.invert_yaxis()
    return figure

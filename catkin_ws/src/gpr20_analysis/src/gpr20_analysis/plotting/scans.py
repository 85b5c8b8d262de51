"""A-, B- and C-scans."""

from __future__ import annotations

import enum
from typing import Any, Optional

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from gpr20_analysis.dataset import (
    A_SCAN,
    DELAY,
    DEPTH,
    IMAGE,
    MM_PER_M,
    POLARIZATION,
    SAMPLE_DIMS,
    X,
    Y,
    require,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.plotting.ranges import brightest, surface_delay_s, until
from gpr20_analysis.plotting.style import (
    PANEL_TITLE_PT,
    SIGNED_MAP,
    DecibelScale,
    draw,
    in_mm,
    new_figure,
    plan_axes,
    rotation_name,
)
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar.depth import one_way_path_m

NS_PER_S = 1e9
DEPTH_TICKS = 8


class Value(enum.Enum):
    """The part of a complex trace that is drawn."""

    MAGNITUDE = "magnitude"
    REAL = "real"


def a_scan_figure(
    in_time: xr.Dataset,
    x_m: float,
    y_m: float,
    last_s: Optional[float] = None,
    catalogue: Catalogue = ENGLISH,
) -> Figure:
    """Draw the trace nearest to a position: envelope and real part of each polarization.

    Args:
        in_time: Dataset with `a_scan`.
        x_m: Position along X [m].
        y_m: Position along Y [m].
        last_s: Last delay [s]; None: that of an echo from a depth of 0.3 m in moist soil;
            `math.inf`: all delays.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There are no A-scans, or the sample has no data.
    """
    shown = until(in_time, last_s)
    a_scans = require(shown, A_SCAN, (*SAMPLE_DIMS, DELAY))
    trace = a_scans.sel({X: x_m, Y: y_m}, method="nearest")
    if not bool(np.isfinite(trace).any()):
        raise WrongDatasetError(
            Message(
                "no sample at x {x_m:g} m, y {y_m:g} m has data; choose another place",
                x_m=x_m,
                y_m=y_m,
            ),
            fault=NOT_ALLOWED,
        )
    x_mm, y_mm = float(in_mm(trace[X])), float(in_mm(trace[Y]))
    title = catalogue.tr("A-scan at x {x_mm:g} mm, y {y_mm:g} mm", x_mm=x_mm, y_mm=y_mm)
    figure = new_figure(in_time, 2, title, catalogue)
    axes = figure.subplots()
    delay_ns = shown[DELAY].values * NS_PER_S
    for turn, values in zip(in_time[POLARIZATION].values, trace.values):
        name = rotation_name(float(turn), in_time, catalogue)
        label = catalogue.tr("{rotation}, envelope", rotation=name)
        (line,) = axes.plot(delay_ns, np.abs(values), label=label)
        label = catalogue.tr("{rotation}, real part", rotation=name)
        axes.plot(delay_ns, values.real, lw=0.6, color=line.get_color(), label=label)
    axes.margins(x=0.0)
    axes.set_xlabel(catalogue.tr("two-way delay [ns]"))
    axes.set_ylabel(catalogue.tr("S21, linear"))
    axes.legend(fontsize=8)
    return figure


def b_scan_figure(
    in_time: xr.Dataset,
    along: str,
    at_m: float,
    value: Value = Value.MAGNITUDE,
    last_s: Optional[float] = None,
    permittivity: Optional[float] = None,
    catalogue: Catalogue = ENGLISH,
) -> Figure:
    """Draw all traces of a line.

    Args:
        in_time: Dataset with `a_scan`.
        along: "x" or "y".
        at_m: Position of the line on the other axis [m]; the nearest line is drawn.
        value: Envelope in dB, or the real part.
        last_s: Last delay [s]; None: that of an echo from a depth of 0.3 m; `math.inf`: all delays.
        permittivity: Relative permittivity of the soil; adds an axis of depth if heights are known.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There are no A-scans.
    """
    other = {X: Y, Y: X}[along]
    shown = until(in_time, last_s, permittivity)
    line = require(shown, A_SCAN, (*SAMPLE_DIMS, DELAY)).sel({other: at_m}, method="nearest")
    turns = in_time[POLARIZATION].values
    title = catalogue.tr(
        "B-scan along {axis} at {other} {position_mm:g} mm",
        axis=along,
        other=other,
        position_mm=float(in_mm(line[other])),
    )
    figure = new_figure(in_time, len(turns), title, catalogue)
    traces = line.compute().values
    reference = brightest(traces)
    across, down = in_mm(in_time[along]), shown[DELAY].values * NS_PER_S
    panels = figure.subplots(1, len(turns), squeeze=False, sharey=True)[0]
    scale = DecibelScale(traces, reference)
    for axes, turn, values in zip(panels, turns, traces):
        if value is Value.REAL:
            limits = {"cmap": SIGNED_MAP, "vmin": -reference, "vmax": reference}
            drawn = draw(axes, values.real.T, across, down, **limits)
        else:
            scale.draw(axes, values.T, across, down)
        axes.set_xlabel(f"{along} [mm]")
        axes.set_title(rotation_name(float(turn), in_time, catalogue), fontsize=PANEL_TITLE_PT)
    panels[0].invert_yaxis()  # that of all of them
    panels[0].set_ylabel(catalogue.tr("two-way delay [ns]"))
    surface_s = surface_delay_s(shown)
    if permittivity is not None and surface_s is not None:
        _add_depth_axis(panels[-1], surface_s, permittivity, catalogue)
    if value is Value.REAL:
        label = catalogue.tr("real part of S21, linear")
        figure.colorbar(drawn, ax=list(panels), label=label, extend="both")
    else:
        scale.add_bar(figure, panels, catalogue.tr("magnitude [dB relative to brightest traces]"))
    return figure


def _add_depth_axis(
    axes: Axes, surface_s: float, permittivity: float, catalogue: Catalogue
) -> None:
    surface_ns = surface_s * NS_PER_S
    air_mm_per_ns, soil_mm_per_ns = (
        one_way_path_m(1.0 / NS_PER_S, one) * MM_PER_M for one in (1.0, permittivity)
    )

    def depth_mm(delay_ns: Any) -> Any:
        below_ns = np.asarray(delay_ns, dtype=np.float64) - surface_ns
        return below_ns * np.where(below_ns > 0.0, soil_mm_per_ns, air_mm_per_ns)

    def delay_ns(depth_mm: Any) -> Any:
        below_mm = np.asarray(depth_mm, dtype=np.float64)
        return surface_ns + below_mm / np.where(below_mm > 0.0, soil_mm_per_ns, air_mm_per_ns)

    depths = axes.secondary_yaxis("right", functions=(depth_mm, delay_ns))
    deepest_mm = float(depth_mm(np.array(max(axes.get_ylim()))))
    depths.set_yticks(MaxNLocator(DEPTH_TICKS).tick_values(0.0, max(deepest_mm, 1.0)))
    depths.set_ylabel(
        catalogue.tr("depth at permittivity {permittivity:.3g} [mm]", permittivity=permittivity)
    )


def c_scan_figure(data: xr.Dataset, at: float, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw a horizontal slice: of an image at a depth [m], of A-scans at a delay [s].

    Args:
        data: Dataset with `image` or `a_scan`.
        at: Depth [m] or delay [s]; the nearest one is drawn.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There is neither an image nor A-scans.
    """
    if IMAGE in data:
        volume, level = require(data, IMAGE, (POLARIZATION, Y, X, DEPTH)), DEPTH
    else:
        volume, level = require(data, A_SCAN, (*SAMPLE_DIMS, DELAY)), DELAY
    taken = volume.sel({level: at}, method="nearest").transpose(POLARIZATION, Y, X)
    turns = data[POLARIZATION].values
    if level == DEPTH:
        depth_mm = float(in_mm(taken[level]))
        title = catalogue.tr("C-scan at depth {depth_mm:.4g} mm", depth_mm=depth_mm)
        label = catalogue.tr("magnitude [dB relative to the whole image]")
        # Slices of one image can be compared.
        every = volume.values
        scale = DecibelScale(every, float(np.nanmax(np.abs(every), initial=0.0)))
    else:
        delay_ns = float(taken[level]) * NS_PER_S
        title = catalogue.tr("C-scan at delay {delay_ns:.4g} ns", delay_ns=delay_ns)
        label = catalogue.tr("magnitude [dB relative to brightest traces]")
        every = taken.values
        scale = DecibelScale(every, brightest(every[..., np.newaxis]))
    figure = new_figure(data, len(turns), title, catalogue)
    panels = figure.subplots(1, len(turns), squeeze=False)[0]
    for axes, turn, values in zip(panels, turns, taken.values):
        scale.draw(axes, values, in_mm(data[X]), in_mm(data[Y]))
        plan_axes(axes, data)
        axes.set_title(rotation_name(float(turn), data, catalogue), fontsize=PANEL_TITLE_PT)
    scale.add_bar(figure, panels, label)
    return figure

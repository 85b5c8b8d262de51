"""A-, B- and C-scans; A- and B-scans end where no ground is seen any more."""

from __future__ import annotations

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
    HEIGHT,
    IMAGE,
    MM_PER_M,
    POLARIZATION,
    SAMPLE_DIMS,
    X,
    Y,
    require,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.plotting.style import (
    DecibelScale,
    draw,
    draw_plan,
    in_mm,
    new_figure,
    turn_panels,
)
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.read.survey_attributes import ANTENNA_DELAY
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import one_way_path_m, two_way_delay_s

NS_PER_S = 1e9
DEPTH_TICKS = 8
# Without other values: depth of a default image, moist soil, antennas as high as usual.
DEEPEST_M, PERMITTIVITY, HEIGHT_M = 0.3, 9.0, 0.3
MARGIN_S = 0.5e-9
# A few disturbed traces are brighter than the scale, instead of hiding all others.
PART_OF_TRACES = 0.95


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
        name = f"{turn:g}°"
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
    last_s: Optional[float] = None,
    permittivity: Optional[float] = None,
    catalogue: Catalogue = ENGLISH,
) -> Figure:
    """Draw the envelopes of all traces of a line.

    Args:
        in_time: Dataset with `a_scan`.
        along: "x" or "y".
        at_m: Position of the line on the other axis [m]; the nearest line is drawn.
        last_s: Last delay [s]; None: that of an echo from a depth of 0.3 m; `math.inf`: all delays.
        permittivity: Relative permittivity of the soil; adds an axis of depth if heights are known.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There are no A-scans.
    """
    other = {X: Y, Y: X}[along]
    shown = until(in_time, last_s, permittivity)
    line = require(shown, A_SCAN, (*SAMPLE_DIMS, DELAY)).sel({other: at_m}, method="nearest")
    title = catalogue.tr(
        "B-scan along {axis} at {other} {position_mm:g} mm",
        axis=along,
        other=other,
        position_mm=float(in_mm(line[other])),
    )
    traces = line.compute().values
    scale = DecibelScale(traces, _brightest(traces))
    figure, panels = turn_panels(in_time, title, catalogue, sharey=True)
    across, down = in_mm(in_time[along]), shown[DELAY].values * NS_PER_S
    for axes, values in zip(panels, traces):
        drawn = draw(axes, scale.levels_db(values.T), across, down, **scale.colours)
        axes.set_xlabel(f"{along} [mm]")
    panels[0].invert_yaxis()  # that of all of them
    panels[0].set_ylabel(catalogue.tr("two-way delay [ns]"))
    surface_s = _surface_delay_s(shown)
    if permittivity is not None and surface_s is not None:
        _add_depth_axis(panels[-1], surface_s, permittivity, catalogue)
    scale.add_bar(figure, drawn, panels, catalogue)
    return figure


def _add_depth_axis(
    axes: Axes, surface_s: float, permittivity: float, catalogue: Catalogue
) -> None:
    surface_ns = surface_s * NS_PER_S
    mm_per_ns = one_way_path_m(1.0 / NS_PER_S, permittivity) * MM_PER_M

    def depth_mm(delay_ns: Any) -> Any:
        return (delay_ns - surface_ns) * mm_per_ns

    def delay_ns(depth_mm: Any) -> Any:
        return surface_ns + depth_mm / mm_per_ns

    depths = axes.secondary_yaxis("right", functions=(depth_mm, delay_ns))
    deepest_mm = depth_mm(max(axes.get_ylim()))
    # Above the surface there is no depth.
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
        volume = require(data, IMAGE, (POLARIZATION, Y, X, DEPTH))
        taken = volume.sel({DEPTH: at}, method="nearest").transpose(*SAMPLE_DIMS)
        title = catalogue.tr(
            "C-scan at depth {depth_mm:.4g} mm", depth_mm=float(in_mm(taken[DEPTH]))
        )
        # Slices of one image can be compared.
        scale = DecibelScale(volume.values, float(np.abs(volume).max()))
    else:
        volume = require(data, A_SCAN, (*SAMPLE_DIMS, DELAY))
        taken = volume.sel({DELAY: at}, method="nearest")
        delay_ns = float(taken[DELAY]) * NS_PER_S
        title = catalogue.tr("C-scan at delay {delay_ns:.4g} ns", delay_ns=delay_ns)
        scale = DecibelScale(taken.values, _brightest(taken.values[..., np.newaxis]))
    figure, panels = turn_panels(data, title, catalogue)
    for axes, values in zip(panels, taken.values):
        drawn = draw_plan(axes, data, scale.levels_db(values), **scale.colours)
    scale.add_bar(figure, drawn, panels, catalogue)
    return figure


def until(
    in_time: xr.Dataset, last_s: Optional[float] = None, permittivity: Optional[float] = None
) -> xr.Dataset:
    """Return A-scans up to a delay, at least two.

    Args:
        in_time: Dataset with `a_scan`.
        last_s: The last delay [s]; `math.inf` keeps all; None: a little after the echo of the
            deepest layer of an image.
        permittivity: Relative permittivity of the soil above it; None: that of moist soil.
    """
    if last_s is None:
        surface_s = _surface_delay_s(in_time)
        if surface_s is None:
            surface_s = float(in_time.attrs.get(ANTENNA_DELAY, 0.0)) + two_way_delay_s(HEIGHT_M)
        soil_s = two_way_delay_s(DEEPEST_M * np.sqrt(permittivity or PERMITTIVITY))
        last_s = surface_s + soil_s + MARGIN_S
    count = int(np.searchsorted(in_time[DELAY].values, last_s, side="right"))
    return in_time.isel({DELAY: slice(None, max(count, 2))})


def _surface_delay_s(data: xr.Dataset) -> Optional[float]:
    """Return the mean two-way delay of the surface [s]; None if no height is known."""
    antennas_s = float(data.attrs.get(ANTENNA_DELAY, 0.0))
    if ADVANCE in data:
        return antennas_s
    heights_m = data[HEIGHT].values if HEIGHT in data else np.array([])
    known = heights_m[np.isfinite(heights_m)]
    return antennas_s + two_way_delay_s(float(known.mean())) if known.size else None


def _brightest(traces: np.ndarray) -> float:
    """Return the magnitude of 0 dB: the largest, except for a few disturbed traces; 0 if none."""
    magnitudes = np.abs(traces).reshape(-1, traces.shape[-1])
    largest = magnitudes[np.isfinite(magnitudes).all(axis=1)].max(axis=1, initial=0.0)
    return float(np.quantile(largest, PART_OF_TRACES, method="lower")) if largest.size else 0.0

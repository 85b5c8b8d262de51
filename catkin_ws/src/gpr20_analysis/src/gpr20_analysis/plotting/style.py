"""Common parts of all figures: size, scales, colours, and the notes below them."""

from __future__ import annotations

from typing import Any, List, Optional, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from gpr20_analysis.dataset import DISPLAY_ONLY, MM_PER_M, is_line
from gpr20_analysis.plotting.noted_figure import NotedFigure
from gpr20_analysis.plotting.ranges import range_db
from gpr20_analysis.processing.samples import COMBINED
from gpr20_analysis.sentences import (
    DOUBTS,
    ENGLISH,
    NOTES,
    limited,
    sentence_of,
    sentences_of,
    shown,
)
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_survey.radar.frequency_to_delay import decibels

# A perceptually uniform map, readable by the colour-blind.
MAGNITUDE_MAP = "viridis"
SIGNED_MAP = "RdBu_r"
NOT_MEASURED = "lightgrey"
WIDTH_IN, HEIGHT_IN, COLOUR_BAR_IN = 4.3, 3.9, 0.9
PANEL_TITLE_PT = 9.0
# Two halves of the cell of a single position, whose width is arbitrary.
LONE_MM = np.array([-2.5, 2.5])
# What is brighter than the scale by less is not marked at its end.
LEAST_CLIPPED = 1.01
SMALLEST_PART = 1e-15  # of the reference, where nothing has no logarithm
LISTED = 6
"""Number of notes below a figure."""


def new_figure(
    data: xr.Dataset,
    columns: int = 1,
    title: str = "",
    catalogue: Catalogue = ENGLISH,
    rows: float = 1.0,
) -> NotedFigure:
    """Return an empty figure with notes on the data below it.

    Args:
        data: What it shows.
        columns: Number of panels beside each other.
        title: Title of the figure.
        catalogue: Language of the notes.
        rows: Height in rows of panels.
    """
    notes = [shown(one, catalogue) for one in remarks_of(data)]
    return NotedFigure((WIDTH_IN * columns + COLOUR_BAR_IN, HEIGHT_IN * rows), title, notes)


def remarks_of(data: xr.Dataset) -> List[Message]:
    """Return the remarks that every figure of the data shows."""
    remarks = [Message("SIMULATED")] if data.attrs.get("simulated") else []
    missing = len(data.attrs.get("missing", []))
    if missing:
        remarks.append(Message("{count} samples missing", count=missing))
    changed = sentence_of(data, DISPLAY_ONLY)
    remarks += [] if changed is None else [changed]
    return [*remarks, *sentences_of(data, DOUBTS), *limited(sentences_of(data, NOTES), LISTED)]


def relative_db(values: np.ndarray, reference: Optional[float] = None) -> np.ndarray:
    """Return magnitudes in dB relative to a reference, by default the maximum; NaN stays NaN."""
    magnitude = np.abs(values)
    largest = float(np.nanmax(magnitude)) if reference is None else reference
    if not largest > 0.0:
        return decibels(magnitude, 1.0)
    return decibels(magnitude / largest, SMALLEST_PART)


def rotation_name(turn_deg: float, data: xr.Dataset, catalogue: Catalogue = ENGLISH) -> str:
    """Return the name of a polarization."""
    if np.isnan(turn_deg):
        return catalogue.text(sentence_of(data, COMBINED) or Message("combination"))
    return f"{turn_deg:g}°"


def draw(
    axes: Axes,
    values: np.ndarray,
    across: np.ndarray,
    down: np.ndarray,
    **options: Any,
) -> Any:
    """Draw values (down, across) as cells; NaN is grey."""
    axes.set_facecolor(NOT_MEASURED)
    if len(across) == 1:
        axes.set_xticks(across)
        across, values = across + LONE_MM, np.repeat(values, 2, axis=1)
    if len(down) == 1:
        axes.set_yticks(down)
        down, values = down + LONE_MM, np.repeat(values, 2, axis=0)
    # As a bitmap also in PDF and SVG, since viewers draw thin lines between vector cells.
    return axes.pcolormesh(
        across, down, np.ma.masked_invalid(values), shading="nearest", rasterized=True, **options
    )


class DecibelScale:
    """One colour scale for all panels of a figure.

    Args:
        values: Everything that the scale is for; its median is the darkest colour.
        reference: Magnitude of 0 dB.
    """

    def __init__(self, values: np.ndarray, reference: float) -> None:
        magnitudes = np.abs(values)
        self._reference = reference
        self._range_db = range_db(magnitudes, reference)
        brighter = np.nanmax(magnitudes, initial=0.0) > reference * LEAST_CLIPPED
        self._extend = "both" if brighter else "min"
        self._drawn: Any = None

    def draw(self, axes: Axes, values: np.ndarray, across: np.ndarray, down: np.ndarray) -> None:
        """Draw magnitudes (down, across)."""
        limits = {"cmap": MAGNITUDE_MAP, "vmin": -self._range_db, "vmax": 0.0}
        self._drawn = draw(axes, relative_db(values, self._reference), across, down, **limits)

    def add_bar(self, figure: NotedFigure, panels: Sequence[Axes], label: str) -> None:
        """Add the colour bar beside the panels."""
        bar = figure.colorbar(self._drawn, ax=list(panels), extend=self._extend)
        bar.set_label(label, fontsize=PANEL_TITLE_PT)


def plan_axes(axes: Axes, data: xr.Dataset) -> None:
    """Label the axes of a map, which is to scale unless it is that of a single line."""
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.set_aspect("auto" if is_line(data) else "equal")


def in_mm(values_m: Any) -> np.ndarray:
    """Return metres in millimetres."""
    return np.asarray(values_m, dtype=np.float64) * MM_PER_M

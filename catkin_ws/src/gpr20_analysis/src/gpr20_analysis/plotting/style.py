"""Common parts of all figures: size, scales, colours, and the notes below them."""

from __future__ import annotations

import textwrap
from typing import Any, Dict, List, Literal, Sequence, Tuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gpr20_analysis.dataset import DISPLAY_ONLY, MM_PER_M, POLARIZATION, is_line
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
from gpr20_survey.radar import decibels

# A perceptually uniform map, readable by the colour-blind.
MAGNITUDE_MAP = "viridis"
NOT_MEASURED = "lightgrey"
WIDTH_IN, HEIGHT_IN, COLOUR_BAR_IN = 4.3, 3.9, 0.9
TITLE_PT, PANEL_TITLE_PT, NOTE_PT = 10.0, 9.0, 7.0
# Of the size of letters: their mean width in a wide text, and the distance of lines.
LETTER_WIDTH, LINE_SPACING = 0.66, 1.3
POINTS_PER_IN = 72.0
# Two halves of the cell of a single position, whose width is arbitrary.
LONE_MM = np.array([-2.5, 2.5])
RANGE_STEP_DB, SMALLEST_RANGE_DB, LARGEST_RANGE_DB = 5.0, 20.0, 50.0
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
) -> Figure:
    """Return an empty figure with notes on the data below it.

    Args:
        data: What it shows.
        columns: Number of panels beside each other.
        title: Title of the figure.
        catalogue: Language of the notes.
        rows: Height in rows of panels.
    """
    notes = [shown(one, catalogue) for one in remarks_of(data)]
    width_in, axes_height_in = WIDTH_IN * columns + COLOUR_BAR_IN, HEIGHT_IN * rows
    heading, remarks = _wrapped([title], width_in, TITLE_PT), _wrapped(notes, width_in, NOTE_PT)
    # Higher by the lines of title and notes.
    points = LINE_SPACING * (len(heading) * TITLE_PT + len(remarks) * NOTE_PT)
    height_in = axes_height_in + points / POINTS_PER_IN
    figure = Figure(figsize=(width_in, height_in), layout="compressed")
    # A dollar sign is no formula.
    figure.suptitle("\n".join(heading), fontsize=TITLE_PT, parse_math=False)
    figure.supxlabel("\n".join(remarks), fontsize=NOTE_PT, color="firebrick", parse_math=False)
    return figure


def _wrapped(texts: Sequence[str], width_in: float, size_pt: float) -> List[str]:
    letters = int(width_in * POINTS_PER_IN / (LETTER_WIDTH * size_pt))
    return [line for one in texts for line in textwrap.wrap(one, letters)]


def remarks_of(data: xr.Dataset) -> List[Message]:
    """Return the remarks that every figure of the data shows."""
    remarks = [Message("SIMULATED")] if data.attrs.get("simulated") else []
    missing = len(data.attrs.get("missing", []))
    if missing:
        remarks.append(Message("{count} samples missing", count=missing))
    changed = sentence_of(data, DISPLAY_ONLY)
    remarks += [] if changed is None else [changed]
    return [*remarks, *sentences_of(data, DOUBTS), *limited(sentences_of(data, NOTES), LISTED)]


def turn_panels(
    data: xr.Dataset, title: str, catalogue: Catalogue, **options: Any
) -> Tuple[Figure, List[Axes]]:
    """Return a figure with a panel for each polarization beside each other."""
    turns = data[POLARIZATION].values
    figure = new_figure(data, len(turns), title, catalogue)
    panels = list(figure.subplots(1, len(turns), squeeze=False, **options)[0])
    for axes, turn in zip(panels, turns):
        axes.set_title(f"{turn:g}°", fontsize=PANEL_TITLE_PT)
    return figure, panels


def draw(
    axes: Axes,
    values: np.ndarray,
    across: np.ndarray,
    down: np.ndarray,
    shading: Literal["nearest", "gouraud"] = "nearest",
    **options: Any,
) -> Any:
    """Draw values (down, across) as cells, or "gouraud" between them; NaN is grey."""
    axes.set_facecolor(NOT_MEASURED)
    if len(across) == 1:
        axes.set_xticks(across)
        across, values = across + LONE_MM, np.repeat(values, 2, axis=1)
    if len(down) == 1:
        axes.set_yticks(down)
        down, values = down + LONE_MM, np.repeat(values, 2, axis=0)
    # As a bitmap also in PDF and SVG, since viewers draw thin lines between vector cells.
    return axes.pcolormesh(
        across, down, np.ma.masked_invalid(values), shading=shading, rasterized=True, **options
    )


def draw_plan(axes: Axes, data: xr.Dataset, values: np.ndarray, **options: Any) -> Any:
    """Draw values (y, x) as a map, which is to scale unless it is that of a single line."""
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.set_aspect("auto" if is_line(data) else "equal")
    return draw(axes, values, in_mm(data["x"]), in_mm(data["y"]), **options)


class DecibelScale:
    """One colour scale for all panels of a figure.

    Args:
        values: Everything that the scale is for; half of it is darkest, within limits.
        reference: Magnitude of 0 dB.
    """

    def __init__(self, values: np.ndarray, reference: float) -> None:
        magnitudes = np.abs(values)
        known = magnitudes[np.isfinite(magnitudes)]
        self._reference = reference or 1.0
        middle = float(np.median(known)) if known.size else 0.0
        reach_db = -float(decibels(middle / self._reference, SMALLEST_PART))
        steps = RANGE_STEP_DB * np.ceil(reach_db / RANGE_STEP_DB)
        lowest_db = -float(np.clip(steps, SMALLEST_RANGE_DB, LARGEST_RANGE_DB))
        self.colours: Dict[str, Any] = {"cmap": MAGNITUDE_MAP, "vmin": lowest_db, "vmax": 0.0}
        is_brighter = known.max(initial=0.0) > self._reference * LEAST_CLIPPED
        self._extend = "both" if is_brighter else "min"

    def levels_db(self, values: np.ndarray) -> np.ndarray:
        """Return magnitudes in dB relative to the reference; NaN stays NaN."""
        return decibels(np.abs(values) / self._reference, SMALLEST_PART)

    def add_bar(
        self, figure: Figure, drawn: Any, panels: Sequence[Axes], catalogue: Catalogue
    ) -> None:
        """Add the colour bar beside the panels."""
        bar = figure.colorbar(drawn, ax=list(panels), extend=self._extend)
        bar.set_label(catalogue.tr("magnitude [dB]"), fontsize=PANEL_TITLE_PT)


def in_mm(values_m: Any) -> np.ndarray:
    """Return metres in millimetres."""
    return np.asarray(values_m, dtype=np.float64) * MM_PER_M

"""The maxima of an image over one of its axes, with the candidates."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y, is_line, require
from gpr20_analysis.plotting.style import (
    HEIGHT_IN,
    PANEL_TITLE_PT,
    WIDTH_IN,
    DecibelScale,
    in_mm,
    new_figure,
    plan_axes,
    rotation_name,
)
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_survey.results.candidates import Candidate

MARK_PT, MARK_LETTERS_PT, OUTLINE_PT = 9.0, 9.0, 2.0
ROWS = 1.7
# Of the width of a map: its lowest and highest height.
LOWEST, HIGHEST = 0.25, 0.9
# More would hide the image.
MOST_MARKED = 12


def projection_figure(
    image: xr.Dataset,
    turn: int,
    candidates: Sequence[Candidate] = (),
    catalogue: Catalogue = ENGLISH,
) -> Figure:
    """Draw the maxima of one polarization over depth, over y and over x.

    The plan is on the left; below it the view from the front, and beside it that from the side. Of
    a single line there is the section below it alone.

    Args:
        image: Dataset with `image`.
        turn: Index of the polarization.
        candidates: The candidates, of which the first are marked.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There is no image.
    """
    magnitude = abs(require(image, IMAGE, (POLARIZATION, DEPTH, Y, X)))
    scale = DecibelScale(magnitude.values, float(magnitude.max()))
    volume = magnitude.isel({POLARIZATION: turn})
    title = catalogue.tr(
        "Maximum projections, {rotation}, permittivity {permittivity:.3g}",
        rotation=rotation_name(float(image[POLARIZATION][turn]), image, catalogue),
        permittivity=float(image.attrs.get("permittivity", np.nan)),
    )
    figure = new_figure(image, 2, title, catalogue, 1.0 if is_line(image) else ROWS)
    if is_line(image):
        along, across = _along(image)
        places = [(figure.subplots(), across, (DEPTH, along))]
    else:
        lengths = {axis: float(np.ptp(image[axis].values)) or 1.0 for axis in (X, Y, DEPTH)}
        panels = figure.subplots(
            2,
            2,
            gridspec_kw={
                "width_ratios": (lengths[X], lengths[DEPTH]),
                "height_ratios": (lengths[Y], lengths[DEPTH]),
            },
        )
        places = [
            (panels[0, 0], DEPTH, (Y, X)),
            (panels[0, 1], X, (Y, DEPTH)),
            (panels[1, 0], Y, (DEPTH, X)),
        ]
        panels[1, 1].set_axis_off()
    names = {DEPTH: catalogue.tr("depth"), X: X, Y: Y}
    for axes, over, (down, across) in places:
        values = volume.max(over).transpose(down, across).values
        scale.draw(axes, values, in_mm(image[across]), in_mm(image[down]))
        axes.set_xlabel(f"{names[across]} [mm]")
        axes.set_ylabel(f"{names[down]} [mm]")
        axes.set_aspect("equal")
        axes.set_title(catalogue.tr("over {axis}", axis=names[over]), fontsize=PANEL_TITLE_PT)
        if down == DEPTH:
            axes.invert_yaxis()
        mark(axes, marked_of(candidates), (across, down))
    scale.add_bar(
        figure,
        [axes for axes, _, _ in places],
        catalogue.tr("magnitude [dB relative to the whole image]"),
    )
    return figure


def candidate_map_figure(
    image: xr.Dataset, candidates: Sequence[Candidate], catalogue: Catalogue = ENGLISH
) -> Figure:
    """Draw the candidates on a map of the maxima over depth and polarizations.

    Of a single line they are drawn on the section below it.

    Args:
        image: Dataset with `image`.
        candidates: The candidates, of which the first are marked with their ids.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There is no image.
    """
    magnitude = abs(require(image, IMAGE, (POLARIZATION, DEPTH, Y, X)))
    over, down, across = (DEPTH, Y, X)
    if is_line(image):
        across, over = _along(image)
        down = DEPTH
    values = magnitude.max((POLARIZATION, over)).transpose(down, across).values
    marked = marked_of(candidates)
    if len(marked) < len(candidates):
        title = catalogue.tr("The first {count} places to check", count=len(marked))
    else:
        title = catalogue.tr("Places to check")
    # As wide as a page, and as high as the ground is; a long line is drawn deeper than it is.
    down_m, across_m = (float(np.ptp(image[axis].values)) for axis in (down, across))
    share = min(max(down_m / (across_m or 1.0), LOWEST), HIGHEST)
    figure = new_figure(image, 2, title, catalogue, share * 2.0 * WIDTH_IN / HEIGHT_IN + 0.2)
    axes = figure.subplots()
    scale = DecibelScale(magnitude.values, float(magnitude.max()))
    scale.draw(axes, values, in_mm(image[across]), in_mm(image[down]))
    if down == DEPTH:
        axes.set_xlabel(f"{across} [mm]")
        depth = catalogue.tr("depth")
        axes.set_ylabel(f"{depth} [mm]")
        axes.set_aspect("equal" if down_m > LOWEST * across_m else "auto")
        axes.invert_yaxis()
    else:
        plan_axes(axes, image)
    mark(axes, marked, (across, down))
    label = catalogue.tr("magnitude [dB relative to the whole image]")
    scale.add_bar(
        figure, [axes], label if over != DEPTH else catalogue.tr("maximum over depth [dB]")
    )
    return figure


def _along(image: xr.Dataset) -> Tuple[str, str]:
    """Return the axis along a single line, and the one across it."""
    return (X, Y) if image.sizes[Y] == 1 else (Y, X)


def marked_of(candidates: Sequence[Candidate]) -> Sequence[Candidate]:
    """Return the first places to check.

    Args:
        candidates: The candidates in the order of their list.

    Returns:
        Those that figures mark: at most `MOST_MARKED`.
    """
    return [one for one in candidates if not one.is_doubtful][:MOST_MARKED]


def mark(axes: Axes, candidates: Sequence[Candidate], plane: Tuple[str, str]) -> None:
    """Mark candidates with their ids in a panel.

    Args:
        axes: The panel, in millimetres.
        candidates: The candidates.
        plane: Its axis across and its axis down.
    """
    outline = [withStroke(linewidth=OUTLINE_PT, foreground="black")]
    for one in candidates:
        place_m = {X: one.x_m, Y: one.y_m, DEPTH: one.depth_m}
        across_mm, down_mm = (float(in_mm(place_m[axis])) for axis in plane)
        axes.plot(
            across_mm,
            down_mm,
            marker="o",
            markersize=MARK_PT,
            markerfacecolor="none",
            markeredgecolor="white",
            path_effects=outline,
        )
        # Towards the middle, where there is room.
        right = across_mm > np.mean(axes.get_xlim())
        axes.annotate(
            one.id,
            (across_mm, down_mm),
            xytext=((-1.0 if right else 1.0) * MARK_PT / 2.0, MARK_PT / 2.0),
            textcoords="offset points",
            ha="right" if right else "left",
            color="white",
            fontsize=MARK_LETTERS_PT,
            path_effects=outline,
        )

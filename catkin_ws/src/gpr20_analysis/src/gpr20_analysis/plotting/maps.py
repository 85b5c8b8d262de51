"""Maps of a survey: coverage, height, where a target could hide, and the maxima of an image."""

from __future__ import annotations

import textwrap
from typing import Any, Sequence, Tuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from gpr20_analysis.dataset import (
    DEPTH,
    HEIGHT,
    IMAGE,
    POLARIZATION,
    QUALITY,
    SAMPLE_DIMS,
    UNUSABLE,
    Quality,
    X,
    Y,
    is_line,
    require,
)
from gpr20_analysis.plotting.style import (
    HEIGHT_IN,
    MAGNITUDE_MAP,
    PANEL_TITLE_PT,
    WIDTH_IN,
    DecibelScale,
    draw,
    draw_plan,
    in_mm,
    new_figure,
    turn_panels,
)
from gpr20_analysis.sentences import ENGLISH, with_sentences
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.results.hiding_map import ONLY_THIS, HidingMap

STATE_LETTERS, STATE_PT = 14, 7.0
# From a palette for the colour-blind.
STATES = (
    (Message("good"), "#009e73"),
    (Message("remark of the robot, or no height"), "#f0e442"),
    (Message("damaged"), "#d55e00"),
    (Message("missing"), "#000000"),
)
# The shallower a target can hide, the darker. Where it was found it is no green, which would say
# more than is known.
DARKEST, BRIGHTEST = 0.1, 0.8
FOUND = "#9ecae1"
MARK_PT, OUTLINE_PT = 9.0, 2.0
ROWS = 1.7
# Of the width of a map: its lowest and highest height.
LOWEST, HIGHEST = 0.25, 0.9


def coverage_figure(survey: xr.Dataset, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw a map of the quality of each sample, one for each polarization.

    Raises:
        WrongDatasetError: The data have no `quality`.
    """
    quality = require(survey, QUALITY, SAMPLE_DIMS).values
    state = np.where(quality & int(Quality.REMARKED | Quality.NO_HEIGHT), 1, 0)
    state[(quality & int(Quality.DAMAGED)) != 0] = 2
    state[(quality & int(Quality.MISSING)) != 0] = 3
    usable = np.count_nonzero((quality & int(UNUSABLE)) == 0)
    title = catalogue.tr(
        "Coverage: {usable} of {total} samples usable", usable=usable, total=quality.size
    )
    figure, panels = turn_panels(survey, title, catalogue)
    colours = ListedColormap([colour for _, colour in STATES])
    norm = BoundaryNorm(np.arange(len(STATES) + 1) - 0.5, len(STATES))
    for axes, values in zip(panels, state):
        drawn = draw_plan(axes, survey, values, cmap=colours, norm=norm)
    bar = figure.colorbar(drawn, ax=panels, ticks=range(len(STATES)), shrink=0.5)
    names = [textwrap.fill(catalogue.text(name), STATE_LETTERS) for name, _ in STATES]
    bar.ax.set_yticklabels(names, fontsize=STATE_PT)
    return figure


def height_figure(survey: xr.Dataset, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw a map of the recorded antenna height, one for each polarization.

    Raises:
        WrongDatasetError: The data have no `height`.
    """
    height_mm = in_mm(require(survey, HEIGHT, SAMPLE_DIMS).values)
    limits = {"vmin": np.nanmin(height_mm), "vmax": np.nanmax(height_mm)}
    title = catalogue.tr("Antenna height above the ground")
    figure, panels = turn_panels(survey, title, catalogue)
    for axes, values in zip(panels, height_mm):
        drawn = draw_plan(axes, survey, values, cmap=MAGNITUDE_MAP, **limits)
    figure.colorbar(drawn, ax=panels, label=catalogue.tr("height [mm]"))
    return figure


def hiding_figure(found: HidingMap, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw from which depth on a target could hide."""
    noted = [ONLY_THIS, *(one for one in found.notes if one.cause)]
    attributes = with_sentences({"simulated": found.simulated}, notes=noted)
    described = xr.Dataset(coords={"x": found.x_m, "y": found.y_m}, attrs=attributes)
    title = catalogue.tr(
        "Where could a mine hide? Target: {target}", target=catalogue.text(found.target.sentence)
    )
    figure = new_figure(described, 2, title, catalogue, 1.7)
    axes = figure.subplots()
    depths_mm = in_mm(found.depth_m)
    greys = np.linspace(DARKEST, BRIGHTEST, len(depths_mm))
    colours = ListedColormap([(one, one, one) for one in greys])
    norm = BoundaryNorm(np.append(depths_mm, depths_mm[-1] * 1.25), len(depths_mm))
    drawn = draw_plan(axes, described, in_mm(found.missed_m), cmap=colours, norm=norm)
    axes.set_facecolor(FOUND)
    bar = figure.colorbar(drawn, ax=axes, ticks=depths_mm)
    bar.ax.set_yticklabels([f"{one:.0f}" for one in depths_mm])
    bar.set_label(catalogue.tr("could hide from this depth on [mm]; blue: at none of these depths"))
    return figure


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
        candidates: What is marked, with ids.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There is no image.
    """
    title = catalogue.tr(
        "Maximum projections, {rotation}, permittivity {permittivity:.3g}",
        rotation=f"{float(image[POLARIZATION][turn]):g}°",
        permittivity=float(image.attrs.get("permittivity", np.nan)),
    )
    magnitude, scale = _magnitude(image)
    volume = magnitude.isel({POLARIZATION: turn})
    if is_line(image):
        return _single(volume, image, candidates, title, scale, catalogue)
    figure = new_figure(image, 2, title, catalogue, ROWS)
    wide, high, deep = (float(np.ptp(image[axis].values)) or 1.0 for axis in (X, Y, DEPTH))
    ratios = {"width_ratios": (wide, deep), "height_ratios": (high, deep)}
    panels = figure.subplots(2, 2, gridspec_kw=ratios)
    panels[1, 1].set_axis_off()
    places = [(panels[0, 0], (Y, X)), (panels[0, 1], (Y, DEPTH)), (panels[1, 0], (DEPTH, X))]
    for axes, plane in places:
        drawn = _view(axes, volume, plane, candidates, scale, catalogue)
        axes.set_aspect("equal")
    scale.add_bar(figure, drawn, [axes for axes, _ in places], catalogue)
    return figure


def candidate_map_figure(
    image: xr.Dataset, candidates: Sequence[Candidate], catalogue: Catalogue = ENGLISH
) -> Figure:
    """Draw candidates on a map of the maxima over depth and polarizations.

    Of a single line they are drawn on the section below it.

    Args:
        image: Dataset with `image`.
        candidates: What is marked, with ids.
        catalogue: Language of the texts.

    Raises:
        WrongDatasetError: There is no image.
    """
    magnitude, scale = _magnitude(image)
    title = catalogue.tr("Places to check")
    return _single(magnitude.max(POLARIZATION), image, candidates, title, scale, catalogue)


def _magnitude(image: xr.Dataset) -> Tuple[xr.DataArray, DecibelScale]:
    magnitude = abs(require(image, IMAGE, (POLARIZATION, DEPTH, Y, X)))
    return magnitude, DecibelScale(magnitude.values, float(magnitude.max()))


def _single(
    volume: xr.DataArray,
    image: xr.Dataset,
    candidates: Sequence[Candidate],
    title: str,
    scale: DecibelScale,
    catalogue: Catalogue,
) -> Figure:
    """Draw one view as wide as a page: the plan of an area, the section below a line."""
    down, across = Y, X
    if is_line(image):
        down, across = DEPTH, X if image.sizes[Y] == 1 else Y
    down_m, across_m = (float(np.ptp(image[axis].values)) or 1.0 for axis in (down, across))
    share = float(np.clip(down_m / across_m, LOWEST, HIGHEST))
    figure = new_figure(image, 2, title, catalogue, share * 2.0 * WIDTH_IN / HEIGHT_IN + 0.2)
    axes = figure.subplots()
    drawn = _view(axes, volume, (down, across), candidates, scale, catalogue)
    # A long line is drawn deeper than it is.
    axes.set_aspect("equal" if down_m > LOWEST * across_m else "auto")
    scale.add_bar(figure, drawn, [axes], catalogue)
    return figure


def _view(
    axes: Axes,
    volume: xr.DataArray,
    plane: Tuple[str, str],
    candidates: Sequence[Candidate],
    scale: DecibelScale,
    catalogue: Catalogue,
) -> Any:
    """Draw the maxima over the axis that is not in a plane (down, across)."""
    down, across = plane
    (over,) = {X, Y, DEPTH} - set(plane)
    names = {DEPTH: catalogue.tr("depth"), X: X, Y: Y}
    levels_db = scale.levels_db(volume.max(over).transpose(down, across).values)
    places_mm = in_mm(volume[across]), in_mm(volume[down])
    drawn = draw(axes, levels_db, *places_mm, shading="gouraud", **scale.colours)
    axes.set_xlabel(f"{names[across]} [mm]")
    axes.set_ylabel(f"{names[down]} [mm]")
    axes.set_title(catalogue.tr("over {axis}", axis=names[over]), fontsize=PANEL_TITLE_PT)
    if down == DEPTH:
        axes.invert_yaxis()
    for one in candidates:
        place_mm = {X: one.x_mm, Y: one.y_mm, DEPTH: one.depth_mm}
        _mark(axes, one.id, place_mm[across], place_mm[down])
    return drawn


def _mark(axes: Axes, name: str, across_mm: float, down_mm: float) -> None:
    outline = [withStroke(linewidth=OUTLINE_PT, foreground="black")]
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
    side = -1.0 if across_mm > np.mean(axes.get_xlim()) else 1.0
    axes.annotate(
        name,
        (across_mm, down_mm),
        xytext=(side * MARK_PT / 2.0, MARK_PT / 2.0),
        textcoords="offset points",
        ha="right" if side < 0.0 else "left",
        color="white",
        fontsize=MARK_PT,
        path_effects=outline,
    )

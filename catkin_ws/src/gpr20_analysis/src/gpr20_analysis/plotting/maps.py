"""Maps of a survey: coverage, antenna height, and where a target could hide."""

from __future__ import annotations

import textwrap

import numpy as np
import xarray as xr
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from gpr20_analysis.dataset import HEIGHT, QUALITY, SAMPLE_DIMS, UNUSABLE, Quality, require
from gpr20_analysis.plotting.style import (
    MAGNITUDE_MAP,
    draw_plan,
    in_mm,
    new_figure,
    turn_panels,
)
from gpr20_analysis.sentences import ENGLISH, with_sentences
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
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

"""Maps of a survey: coverage and antenna height."""

from __future__ import annotations

import textwrap

import numpy as np
import xarray as xr
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from gpr20_analysis.dataset import (
    HEIGHT,
    POLARIZATION,
    QUALITY,
    SAMPLE_DIMS,
    UNUSABLE,
    Quality,
    X,
    Y,
    require,
)
from gpr20_analysis.plotting.style import (
    MAGNITUDE_MAP,
    PANEL_TITLE_PT,
    draw,
    in_mm,
    new_figure,
    plan_axes,
    rotation_name,
)
from gpr20_analysis.sentences import ENGLISH
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message

STATE_LETTERS, STATE_PT = 14, 7.0
# From a palette for the colour-blind.
STATES = (
    (Message("good"), "#009e73"),
    (Message("remark of the robot, or no height"), "#f0e442"),
    (Message("damaged"), "#d55e00"),
    (Message("missing"), "#000000"),
)


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
    turns = survey[POLARIZATION].values
    title = catalogue.tr(
        "Coverage: {usable} of {total} samples usable", usable=usable, total=quality.size
    )
    figure = new_figure(survey, len(turns), title, catalogue)
    colours = ListedColormap([colour for _, colour in STATES])
    norm = BoundaryNorm(np.arange(len(STATES) + 1) - 0.5, len(STATES))
    panels = figure.subplots(1, len(turns), squeeze=False)[0]
    for axes, turn, values in zip(panels, turns, state):
        drawn = draw(axes, values, in_mm(survey[X]), in_mm(survey[Y]), cmap=colours, norm=norm)
        plan_axes(axes, survey)
        axes.set_title(rotation_name(float(turn), survey, catalogue), fontsize=PANEL_TITLE_PT)
    bar = figure.colorbar(drawn, ax=list(panels), ticks=range(len(STATES)), shrink=0.5)
    names = [textwrap.fill(catalogue.text(name), STATE_LETTERS) for name, _ in STATES]
    bar.ax.set_yticklabels(names, fontsize=STATE_PT)
    return figure


def height_figure(survey: xr.Dataset, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw a map of the recorded antenna height, one for each polarization.

    Raises:
        WrongDatasetError: The data have no `height`.
    """
    height_mm = in_mm(require(survey, HEIGHT, SAMPLE_DIMS).values)
    turns = survey[POLARIZATION].values
    title = catalogue.tr("Antenna height above the ground")
    figure = new_figure(survey, len(turns), title, catalogue)
    panels = figure.subplots(1, len(turns), squeeze=False)[0]
    for axes, turn, values in zip(panels, turns, height_mm):
        limits = {"vmin": np.nanmin(height_mm), "vmax": np.nanmax(height_mm)}
        drawn = draw(axes, values, in_mm(survey[X]), in_mm(survey[Y]), cmap=MAGNITUDE_MAP, **limits)
        plan_axes(axes, survey)
        axes.set_title(rotation_name(float(turn), survey, catalogue), fontsize=PANEL_TITLE_PT)
    figure.colorbar(drawn, ax=list(panels), label=catalogue.tr("height [mm]"))
    return figure

"""The curve of a trial: share of targets found over false alarms per m2 (FROC), per stratum."""

from __future__ import annotations

import math
from typing import List, Sequence

import numpy as np
from matplotlib.figure import Figure

from gpr20_analysis.plotting.noted_figure import NotedFigure
from gpr20_analysis.plotting.style import HEIGHT_IN, PANEL_TITLE_PT, WIDTH_IN
from gpr20_analysis.trial.score import GroupScore
from gpr20_common.catalogue import Catalogue

COLUMNS, MOST_PANELS = 3, 12


def froc_figure(groups: Sequence[GroupScore], notes: Sequence[str], catalogue: Catalogue) -> Figure:
    """Draw a panel for each stratum, the first of them, with a curve for each method.

    A dot with its intervals is what counts; the curve goes on over doubtful candidates.

    Args:
        groups: Scores of methods, those of a stratum together.
        notes: Sentences below the figure.
        catalogue: Language of the texts.

    Returns:
        The figure.
    """
    strata: List[str] = list(dict.fromkeys(one.stratum for one in groups))[:MOST_PANELS]
    columns = min(len(strata), COLUMNS)
    rows = math.ceil(len(strata) / columns)
    size_in = (WIDTH_IN * 0.8 * columns, HEIGHT_IN * 0.75 * rows)
    figure = NotedFigure(size_in, "", notes)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for panel, stratum in zip(panels, strata):
        panel.set_title(stratum or catalogue.tr("all targets"), fontsize=PANEL_TITLE_PT)
        for at, one in enumerate(own for own in groups if own.stratum == stratum):
            colour = f"C{at}"
            panel.step(*np.transpose(one.curve), where="post", color=colour, label=one.method)
            if one.targets and one.area_m2 > 0.0:
                place = np.array([[one.alarms_per_m2], [one.detection]])
                spans = [np.abs(np.transpose([ends]) - at) for ends, at in zip(
                    (one.alarms_range, one.detection_range), place)]  # fmt: skip
                panel.errorbar(*place, spans[1], spans[0], fmt="o", color=colour, capsize=3)
        panel.set_ylim(0.0, 1.03)
    for panel in panels[len(strata) :]:
        panel.set_visible(False)
    panels[0].legend(fontsize=PANEL_TITLE_PT)
    figure.supylabel(catalogue.tr("share of targets found"), fontsize=PANEL_TITLE_PT)
    for panel in panels[len(strata) - columns : len(strata)]:
        panel.set_xlabel(catalogue.tr("false alarms per m2"), fontsize=PANEL_TITLE_PT)
        panel.tick_params(labelbottom=True)
    return figure

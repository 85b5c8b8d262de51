"""The curve of a trial: share of targets found over false alarms per m2 (FROC), per stratum."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from matplotlib.figure import Figure

from gpr20_analysis.plotting.noted_figure import NotedFigure
from gpr20_analysis.plotting.style import HEIGHT_IN, PANEL_TITLE_PT, WIDTH_IN
from gpr20_analysis.trial.score import GroupScore
from gpr20_common.catalogue import Catalogue

COLUMNS, MOST_PANELS = 3, 12


def froc_figure(groups: Sequence[GroupScore], notes: Sequence[str], catalogue: Catalogue) -> Figure:
    """Draw a panel for each of the first strata, with a curve for each method.

    A dot with its intervals is what counts; the curve also has doubtful candidates.
    """
    strata = list(dict.fromkeys(one.stratum for one in groups))[:MOST_PANELS]
    columns = min(len(strata), COLUMNS)
    rows = math.ceil(len(strata) / columns)
    figure = NotedFigure((WIDTH_IN * 0.8 * columns, HEIGHT_IN * 0.75 * rows), "", notes)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for panel, stratum in zip(panels, strata):
        panel.set_title(stratum or catalogue.tr("all targets"), fontsize=PANEL_TITLE_PT)
        panel.set_xlabel(catalogue.tr("false alarms per m2"), fontsize=PANEL_TITLE_PT)
        panel.tick_params(labelbottom=True)
        panel.set_ylim(0.0, 1.03)
        for at, one in enumerate(own for own in groups if own.stratum == stratum):
            panel.step(*np.transpose(one.curve), where="post", color=f"C{at}", label=one.method)
            if one.detection is not None and one.alarms_per_m2 is not None:
                place = one.alarms_per_m2, one.detection
                ends = np.array([one.detection_range, one.alarms_range])
                spans = np.abs(ends - [place[1:], place[:1]])[..., None]
                panel.errorbar(*place, *spans, fmt="o", color=f"C{at}", capsize=3)
    for panel in panels[len(strata) :]:
        panel.set_visible(False)
    panels[0].legend(fontsize=PANEL_TITLE_PT)
    figure.supylabel(catalogue.tr("share of targets found"), fontsize=PANEL_TITLE_PT)
    return figure

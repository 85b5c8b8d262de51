"""The map of where a target could hide."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from gpr20_analysis.plotting.style import PANEL_TITLE_PT, draw, in_mm, new_figure
from gpr20_analysis.sentences import ENGLISH, with_sentences
from gpr20_common.catalogue import Catalogue
from gpr20_survey.results.hiding_map import ONLY_THIS, HidingMap

# The shallower a target can hide, the darker. Where it was found it is no green, which would say
# more than is known.
DARKEST, BRIGHTEST = 0.1, 0.8
FOUND = "#9ecae1"


def hiding_figure(found: HidingMap, catalogue: Catalogue = ENGLISH) -> Figure:
    """Draw from which depth on a target could hide, and the share that is found at each depth.

    Raises:
        ValueError: The map has no places.
    """
    noted = [ONLY_THIS, *(one for one in found.notes if one.cause)]
    described = xr.Dataset(attrs=with_sentences({"simulated": found.simulated}, notes=noted))
    title = catalogue.tr(
        "Where could a mine hide? Target: {target}", target=catalogue.text(found.target.sentence)
    )
    figure = new_figure(described, 2, title, catalogue, 1.1)
    panels = figure.subplots(1, 2)
    depths_mm = in_mm(found.depth_m)
    missed_mm = in_mm(found.missed_m)
    steps = np.append(depths_mm, depths_mm[-1] * 1.25)
    greys = np.linspace(DARKEST, BRIGHTEST, len(depths_mm))
    colours = ListedColormap([(one, one, one) for one in greys])
    norm = BoundaryNorm(steps, len(depths_mm))
    x_mm, y_mm = in_mm(found.x_m), in_mm(found.y_m)
    drawn = draw(panels[0], missed_mm, x_mm, y_mm, cmap=colours, norm=norm)
    panels[0].set_facecolor(FOUND)
    bar = figure.colorbar(drawn, ax=panels[0], ticks=depths_mm)
    bar.ax.set_yticklabels([f"{one:.0f}" for one in depths_mm])
    bar.set_label(catalogue.tr("could hide from this depth on [mm]"))
    panels[0].set_title(
        catalogue.tr("shallowest missed depth; blue: none of these depths"), fontsize=PANEL_TITLE_PT
    )
    panels[0].set_xlabel("x [mm]")
    panels[0].set_ylabel("y [mm]")
    panels[0].set_aspect("equal" if min(len(x_mm), len(y_mm)) > 1 else "auto")
    _shares(panels[1], found, catalogue)
    return figure


def _shares(axes: object, found: HidingMap, catalogue: Catalogue) -> None:
    """Draw the share that was found, over all places of each depth, with its range over them."""
    depths_mm, share = in_mm(found.depth_m), 100.0 * found.share.reshape(len(found.depth_m), -1)
    with np.errstate(invalid="ignore"):
        middle = np.nanmedian(share, axis=1)
        low, high = np.nanpercentile(share, [10.0, 90.0], axis=1)
    axes.fill_betweenx(depths_mm, low, high, alpha=0.3)  # type: ignore[attr-defined]
    axes.plot(middle, depths_mm, marker="o")  # type: ignore[attr-defined]
    axes.axvline(100.0 * found.needed, color="black", linestyle="--")  # type: ignore[attr-defined]
    axes.set(  # type: ignore[attr-defined]
        xlim=(-3.0, 103.0),
        ylim=(depths_mm[-1] * 1.05, 0.0),
        xlabel=catalogue.tr("found [%]: median of the places, 10 to 90 %"),
        ylabel=catalogue.tr("depth of the top [mm]"),
    )
    axes.set_title(  # type: ignore[attr-defined]
        catalogue.tr("share that was found"), fontsize=PANEL_TITLE_PT
    )

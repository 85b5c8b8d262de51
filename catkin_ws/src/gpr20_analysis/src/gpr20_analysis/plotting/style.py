"""Common parts of all figures: size, scales, colours, and the remarks below them."""

from __future__ import annotations

from typing import Any, List, Optional

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.processing.display import DISPLAY_ONLY
from gpr20_analysis.processing.polarization import COMBINED
from gpr20_analysis.sentences import ENGLISH, sentence_of, sentences_of
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message, in_a_row

# A perceptually uniform map, readable by the colour-blind.
MAGNITUDE_MAP = "viridis"
SIGNED_MAP = "RdBu_r"
NOT_MEASURED = "lightgrey"
RANGE_DB = 40.0
WIDTH_IN, HEIGHT_IN = 5.6, 4.4


def new_figure(
    data: xr.Dataset, columns: int = 1, title: str = "", catalogue: Catalogue = ENGLISH
) -> Figure:
    """Return an empty figure with remarks on the data below it."""
    figure = Figure(figsize=(WIDTH_IN * columns, HEIGHT_IN), layout="constrained")
    figure.suptitle(title, fontsize=10)
    remarks = remarks_of(data)
    if remarks:
        text = catalogue.text(in_a_row(remarks))
        figure.supxlabel(text, fontsize=7, color="firebrick", wrap=True)
    return figure


def remarks_of(data: xr.Dataset) -> List[Message]:
    """Return the remarks that every figure of the data shows."""
    remarks = [Message("SIMULATED")] if data.attrs.get("simulated") else []
    damaged, missing = (len(data.attrs.get(name, [])) for name in ("faults", "missing"))
    if damaged:
        remarks.append(Message("{count} samples damaged", count=damaged))
    if missing:
        remarks.append(Message("{count} samples missing", count=missing))
    remarks += sentences_of(data, "notes")
    changed = sentence_of(data, DISPLAY_ONLY)
    return remarks if changed is None else [*remarks, changed]


def decibels(values: np.ndarray, reference: Optional[float] = None) -> np.ndarray:
    """Return magnitudes in dB relative to a reference, by default the maximum; NaN stays NaN."""
    magnitude = np.abs(values)
    largest = float(np.nanmax(magnitude)) if reference is None else reference
    floor = largest * 1e-15 if largest > 0.0 else 1.0
    return 20.0 * np.log10(np.maximum(magnitude, floor) / (largest if largest > 0.0 else 1.0))


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
    # As a bitmap also in PDF and SVG, since viewers draw thin lines between vector cells.
    return axes.pcolormesh(
        across, down, np.ma.masked_invalid(values), shading="nearest", rasterized=True, **options
    )


def draw_decibels(
    axes: Axes,
    values_db: np.ndarray,
    across: np.ndarray,
    down: np.ndarray,
    catalogue: Catalogue = ENGLISH,
) -> None:
    """Draw dB values with their colour bar."""
    drawn = draw(axes, values_db, across, down, cmap=MAGNITUDE_MAP, vmin=-RANGE_DB, vmax=0.0)
    label = catalogue.tr("magnitude [dB relative to maximum]")
    axes.figure.colorbar(drawn, ax=axes, label=label, extend="min")


def plan_axes(axes: Axes) -> None:
    """Label the axes of a map."""
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.set_aspect("equal")


def in_mm(values_m: Any) -> np.ndarray:
    """Return metres in millimetres."""
    return np.asarray(values_m, dtype=np.float64) * MM_PER_M

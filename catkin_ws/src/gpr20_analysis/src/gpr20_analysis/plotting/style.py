"""What all figures share: size, scales, colours, and the remarks below them."""

from __future__ import annotations

from typing import Any, List, Optional

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gpr20_analysis.dataset import MM_PER_M

# A perceptual map, even in lightness and readable by the colour-blind.
MAGNITUDE_MAP = "viridis"
SIGNED_MAP = "RdBu_r"
NOT_MEASURED = "lightgrey"
RANGE_DB = 40.0
WIDTH_IN, HEIGHT_IN = 5.6, 4.4


def new_figure(data: xr.Dataset, columns: int = 1, title: str = "") -> Figure:
    """Return an empty figure that says below what must be known of the data."""
    figure = Figure(figsize=(WIDTH_IN * columns, HEIGHT_IN), layout="constrained")
    figure.suptitle(title, fontsize=10)
    remarks = remarks_of(data)
    if remarks:
        figure.supxlabel("; ".join(remarks), fontsize=7, color="firebrick", wrap=True)
    return figure


def remarks_of(data: xr.Dataset) -> List[str]:
    """Return what no picture of the data may hide."""
    remarks = ["SIMULATED"] if data.attrs.get("simulated") else []
    for key, word in (("faults", "damaged"), ("missing", "missing")):
        count = len(data.attrs.get(key, []))
        if count:
            remarks.append(f"{count} samples {word}")
    remarks += [str(note) for note in data.attrs.get("notes", [])]
    if "display_only" in data.attrs:
        remarks.append(str(data.attrs["display_only"]))
    return remarks


def decibels(values: np.ndarray, reference: Optional[float] = None) -> np.ndarray:
    """Return magnitudes in dB below a reference, by default their largest; NaN stays NaN."""
    magnitude = np.abs(values)
    largest = float(np.nanmax(magnitude)) if reference is None else reference
    floor = largest * 1e-15 if largest > 0.0 else 1.0
    return 20.0 * np.log10(np.maximum(magnitude, floor) / (largest if largest > 0.0 else 1.0))


def rotation_name(turn_deg: float, data: xr.Dataset) -> str:
    """Return the words for a polarization."""
    if np.isnan(turn_deg):
        return str(data.attrs.get("polarizations", "combination"))
    return f"{turn_deg:g}°"


def draw(
    axes: Axes,
    values: np.ndarray,
    across: np.ndarray,
    down: np.ndarray,
    **options: Any,
) -> Any:
    """Draw values (down, across) as cells; what is NaN is grey."""
    axes.set_facecolor(NOT_MEASURED)
    # As a picture also in PDF and SVG: viewers draw thin lines between cells that are shapes.
    return axes.pcolormesh(
        across, down, np.ma.masked_invalid(values), shading="nearest", rasterized=True, **options
    )


def draw_decibels(axes: Axes, values_db: np.ndarray, across: np.ndarray, down: np.ndarray) -> None:
    """Draw dB values with their colour bar."""
    drawn = draw(axes, values_db, across, down, cmap=MAGNITUDE_MAP, vmin=-RANGE_DB, vmax=0.0)
    axes.figure.colorbar(drawn, ax=axes, label="magnitude [dB below maximum]", extend="min")


def plan_axes(axes: Axes) -> None:
    """Label axes that show the ground from above."""
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.set_aspect("equal")


def in_mm(values_m: Any) -> np.ndarray:
    """Return metres in millimetres."""
    return np.asarray(values_m, dtype=np.float64) * MM_PER_M

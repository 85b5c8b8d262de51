"""Colours of the viewer."""

from __future__ import annotations

import numpy as np
import pyqtgraph

INK = "#111111"
PAPER = "w"
SIMULATED = "background: #ffd400; color: #111111; font-weight: bold; padding: 3px;"
WRONG = "background: #ffe3e3; color: #8f0000; font-weight: bold; padding: 3px;"
QUIET = "color: #444444; font-size: 11px;"
SMALL = "font-size: 11px;"
CURSOR = "#d94801"
HYPERBOLA = "#ff2d00"
SURFACE = "#ffffff"
PICK = "#ff00c8"
CANDIDATE = "#ffffff"
NO_DATA = "#8f0000"
HIDDEN = (60, 60, 60, 170)
LEVELS = 255
# No colour of the level scale, which runs from violet over green to yellow.
NOT_MEASURED = (140, 140, 140)


def level_colours() -> np.ndarray:
    """Return the colours of 255 levels and, last, that of what was not measured (256 x 3)."""
    scale = pyqtgraph.colormap.get("viridis").getLookupTable(nPts=LEVELS)
    return np.vstack([scale, NOT_MEASURED]).astype(np.uint8)


def colour_numbers(levels_db: np.ndarray, range_db: float) -> np.ndarray:
    """Return the colour of each level from -range_db to 0; what is NaN gets the last one."""
    known = np.isfinite(levels_db)
    share = np.clip(1.0 + np.where(known, levels_db, 0.0) / range_db, 0.0, 1.0)
    numbers = np.round(share * (LEVELS - 1)).astype(np.uint8)
    numbers[~known] = LEVELS
    return numbers

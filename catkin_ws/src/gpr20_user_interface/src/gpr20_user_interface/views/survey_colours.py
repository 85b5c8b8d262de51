"""Colours of map and radar; the states differ in brightness too, for whoever sees no colours."""

from __future__ import annotations

from typing import Dict

import numpy as np
import pyqtgraph

from gpr20_user_interface.mid.map_coverage import StopState

STOP_COLOURS: Dict[StopState, str] = {
    StopState.MISSING: "#d9d9d9",
    StopState.PARTLY: "#8ab8e6",
    StopState.DONE: "#1f4e8c",
    StopState.FAILED: "#d94801",
}
CURRENT = "#ffd400"
CARRIAGE = "#000000"
SELECTED = "#c000c0"
CURVE = "#1f4e8c"
SURFACE_LINE = "#a80000"
# No colour of the level scale, which runs from violet over green to yellow.
NOT_MEASURED = (140, 140, 140)
LEVELS = 255


def level_colours() -> np.ndarray:
    """Return the colours of 255 levels and, last, that of what was not measured (256 x 3)."""
    scale = pyqtgraph.colormap.get("viridis").getLookupTable(nPts=LEVELS)
    return np.vstack([scale, NOT_MEASURED]).astype(np.uint8)

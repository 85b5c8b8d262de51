"""Cells of the ground on a plot, as patterns."""

from __future__ import annotations

from functools import lru_cache
from typing import Tuple

import numpy as np
from PyQt5.QtCore import QPointF
from PyQt5.QtGui import QColor, QImage

from gpr20_operator.ground.cells import MARKS, TILE_PX, TILES, Cell
from gpr20_operator.ground.geometry import Area
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.widgets.plot import Plot

# Smaller stops have no lines between them.
SMALLEST_WITH_LINES_PX = 7.0


class Lattice:
    """Where the cells of an area are on a plot: only what they are changes often.

    Args:
        plot: Where they are drawn.
        shape: Rows and columns.
        area: All cells together.
    """

    def __init__(self, plot: Plot, shape: Tuple[int, int], area: Area) -> None:
        width, height = plot.viewport().width(), plot.viewport().height()
        rows, columns = shape
        left, low = plot.to_data(QPointF(0.5, height - 0.5))
        right, high = plot.to_data(QPointF(width - 0.5, 0.5))
        column = _places(left, right, width, area.left_mm, area.width_mm, columns)
        row = _places(high, low, height, area.low_mm, area.height_mm, rows)
        self._column, self._row = column, row
        y, x = np.arange(height) % TILE_PX * TILE_PX, np.arange(width) % TILE_PX
        self._tile = (y[:, None] + x).astype(np.uint16)
        inside = (row[:, None] > 0) & (row[:, None] <= rows) & (column > 0) & (column <= columns)
        edges = np.zeros((height, width), bool)
        edges[:, 1:] |= np.diff(column) != 0
        edges[1:] |= (np.diff(row) != 0)[:, None]
        large = width / max(right - left, 1e-9) * area.width_mm / columns >= SMALLEST_WITH_LINES_PX
        self._lines = np.flatnonzero(edges & inside) if large else np.zeros(0, np.intp)

    def image(self, cells: np.ndarray, look: Look, lines: bool) -> QImage:
        """Return the patterns of cells, as large as the plot: they do not follow the zoom.

        Args:
            cells: Cell of each place, both axes ascending.
            look: The colours.
            lines: Whether there are lines between large cells.
        """
        # Around the cells nothing is painted.
        padded = np.pad(cells.astype(np.uint16), 1, constant_values=Cell.BLANK) * TILE_PX**2
        # Two steps of one axis each: much faster than both at once.
        codes = padded[:, self._column][self._row]
        codes += self._tile
        pixels = _inks_of_tiles(look).take(codes)
        if lines:
            pixels.ravel()[self._lines] = QColor(look.colour(Mark.GRID)).rgba()
        height, width = pixels.shape
        image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_ARGB32)
        return image.copy()  # its own memory


def pattern_image(cell: Cell, size_px: int, look: Look, framed: bool = True) -> QImage:
    """Return a square of a pattern, for a legend with a frame."""
    at = np.arange(size_px) % TILE_PX
    pixels = _inks(look)[TILES[cell][at][:, at]]
    if framed:
        pixels[[0, -1]] = pixels[:, [0, -1]] = QColor(look.colour(Mark.BORDER)).rgba()
    image = QImage(pixels.tobytes(), size_px, size_px, 4 * size_px, QImage.Format.Format_ARGB32)
    return image.copy()  # its own memory


def _places(
    first: float, last: float, size_px: int, begin: float, length: float, count: int
) -> np.ndarray:
    """Return the number of the cell of each pixel, from 1; 0 and count + 1 are outside."""
    at = np.linspace(first, last, size_px)
    found = np.floor((at - begin) / max(length, 1e-9) * count).astype(np.intp) + 1
    return np.clip(found, 0, count + 1)


@lru_cache(maxsize=2)
def _inks_of_tiles(look: Look) -> np.ndarray:
    return _inks(look)[TILES.ravel()]


def _inks(look: Look) -> np.ndarray:
    colours = [QColor(look.colour(mark)).rgba() for mark in MARKS]
    return np.array([0, *colours], np.uint32)

"""Patterns of cells of the ground: each kind is known without its colours."""

from __future__ import annotations

import enum
from functools import lru_cache
from typing import Tuple

import numpy as np
from PyQt5.QtCore import QPointF
from PyQt5.QtGui import QColor, QImage

from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.geometry import Area
from gpr20_survey.results.hiding_map import MM_PER_M, HidingMap
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.widgets.plot import Plot

# Smaller stops have no lines between them.
SMALLEST_WITH_LINES_PX = 7.0
# Of the depths that were tried: what is missed above that is hatched densely.
DENSE_SHARE = 0.5
# Width and height of a pattern, which is repeated [px].
TILE_PX = 16


class Cell(enum.IntEnum):
    """What a cell of the ground is: each has a pattern besides its colours."""

    MISSING = StopState.MISSING
    PARTLY = StopState.PARTLY
    DONE = StopState.DONE
    FAILED = StopState.FAILED
    LOADING = 4
    """Stored, but not here yet."""
    HIDING = 5
    """A mine could hide here."""
    HIDING_SHALLOW = 6
    """A mine could hide here even if it is not deep."""
    BLANK = 7
    """Nothing is painted."""


def _tiles() -> np.ndarray:
    """Return the Mark of each pixel of each pattern; 0: none (uint8, cells x TILE_PX x TILE_PX)."""
    y, x = np.mgrid[:TILE_PX, :TILE_PX]
    rising, falling = (x + y) % 8, (x - y) % 8
    tiles = np.zeros((len(Cell), TILE_PX, TILE_PX), np.uint8)
    # Missing: empty, with dots.
    tiles[Cell.MISSING] = np.where((x % 8 < 2) & (y % 8 < 2), _no(Mark.STOP_MISSING), _PAPER)
    # Partly: half of it is done. Failed: a lattice.
    tiles[Cell.PARTLY] = np.where(rising < 4, _no(Mark.STOP_DONE), _no(Mark.STOP_PARTLY))
    tiles[Cell.DONE] = _no(Mark.STOP_DONE)
    tiles[Cell.FAILED] = np.where(np.minimum(rising, falling) < 2, _PAPER, _no(Mark.STOP_FAILED))
    # Over whatever is below, so each line has a rim: dashes and diagonals.
    for cell, line in (
        (Cell.LOADING, np.where(x < 11, y % 8, TILE_PX)),
        (Cell.HIDING, (x + y) % 16),
        (Cell.HIDING_SHALLOW, rising),
    ):
        tiles[cell] = np.select([line < 2, line < 4], [_no(Mark.INK), _PAPER], 0)
    return tiles


def _no(mark: Mark) -> int:
    return MARKS.index(mark) + 1


MARKS = tuple(Mark)
_PAPER = _no(Mark.PAPER)
TILES = _tiles()


def hiding_cells(found: HidingMap) -> Tuple[np.ndarray, Area]:
    """Return the Cell of each place where a target could hide, and the area of the map."""
    missed_m = found.missed_m
    hidden = np.isfinite(missed_m)
    deeper = np.mean(found.depth_m[:, None, None] < np.where(hidden, missed_m, 0.0), axis=0)
    cells = np.where(deeper < DENSE_SHARE, Cell.HIDING_SHALLOW, Cell.HIDING)
    (width, height), x, y = found.cell_m, found.x_m, found.y_m
    ends = (x[0] - width / 2, x[-1] + width / 2, y[0] - height / 2, y[-1] + height / 2)
    area = Area(*(MM_PER_M * float(one) for one in ends))
    return np.where(hidden, cells, Cell.BLANK).astype(np.uint8), area


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

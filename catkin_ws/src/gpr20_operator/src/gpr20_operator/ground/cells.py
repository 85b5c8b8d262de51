"""Patterns of cells of the ground: each kind is known without its colours."""

from __future__ import annotations

import enum
from typing import Tuple

import numpy as np

from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.geometry import Area
from gpr20_operator.palette import Mark
from gpr20_survey.results.hiding_map import MM_PER_M, HidingMap

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

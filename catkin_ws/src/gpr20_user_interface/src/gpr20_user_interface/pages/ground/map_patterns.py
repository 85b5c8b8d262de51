"""The states of the stops as pixels: each state has a pattern besides its colours."""

from __future__ import annotations

import enum
from typing import Mapping, Tuple

import numpy as np

from gpr20_operator.ground.coverage import StopState

# Smaller stops have no lines between them, and no pattern of their own: fields of them have one.
SMALLEST_WITH_LINES_PX = 7.0
# Smallest stop in which a pattern can be recognized.
SMALLEST_WITH_PATTERN_PX = 4.0
HATCH_PX = 3
DOT = 0.14
SMALLEST_DOT_PX = 3.0
CROSS = 0.11


class Part(enum.IntEnum):
    """What a pixel of a stop belongs to, whatever the state of the stop."""

    FILL = 0
    HALF = 1
    """The lower left half."""
    CROSS = 2
    """A diagonal in the lower left half; in the upper right half it is CROSS_ABOVE."""
    CROSS_ABOVE = 3
    DOT = 4
    """In the middle of the upper right half; below it is DOT_BELOW."""
    DOT_BELOW = 5
    LINE = 6
    """Between two stops."""
    FIELD = 7
    """Of stops that are too small for a pattern: the gaps of a hatching over all of them."""


class Ink(enum.IntEnum):
    """What a pixel is painted with."""

    PAPER = 0
    GRID = 1
    MISSING = 2
    PARTLY = 3
    DONE = 4
    FAILED = 5


_EVERYWHERE = {
    StopState.MISSING: Ink.PAPER,
    StopState.PARTLY: Ink.PARTLY,
    StopState.DONE: Ink.DONE,
    StopState.FAILED: Ink.FAILED,
}
# Missing: empty, with a dot. Partly: half of it done. Done: full. Failed: full, with a cross.
_PATTERNS: Mapping[StopState, Mapping[Part, Ink]] = {
    StopState.MISSING: {Part.DOT: Ink.MISSING, Part.DOT_BELOW: Ink.MISSING},
    StopState.PARTLY: {
        Part.HALF: Ink.DONE,
        Part.CROSS: Ink.DONE,
        Part.DOT_BELOW: Ink.DONE,
        Part.FIELD: Ink.DONE,
    },
    StopState.DONE: {},
    StopState.FAILED: {
        Part.CROSS: Ink.PAPER,
        Part.CROSS_ABOVE: Ink.PAPER,
        Part.DOT: Ink.PAPER,
        Part.DOT_BELOW: Ink.PAPER,
    },
}


def _ink_table() -> np.ndarray:
    table = np.zeros((len(StopState), len(Part)), np.uint8)
    for state in StopState:
        table[state] = _EVERYWHERE[state]
        for part, ink in _PATTERNS[state].items():
            table[state, part] = ink
        table[state, Part.LINE] = Ink.GRID
    return table


INK_OF = _ink_table()
"""Ink of each Part in each StopState."""


class StopPattern:
    """The pixels of a drawing of rows and columns of stops; only their states change.

    Args:
        shape: Rows and columns of stops.
        size_px: Width and height of the drawing.
    """

    def __init__(self, shape: Tuple[int, int], size_px: Tuple[int, int]) -> None:
        rows, columns = shape
        width, height = size_px
        self._column, x = _cells(columns, width)
        self._row, y = _cells(rows, height)
        self._parts = _parts(x, y, (width / columns, height / rows))

    def inks(self, states: np.ndarray) -> np.ndarray:
        """Return the Ink of each pixel (height x width).

        Args:
            states: StopState of each stop, the uppermost row first.
        """
        # Two steps of one axis each: much faster than both at once.
        rows = states[:, self._column][self._row]
        flat: np.ndarray = INK_OF.ravel().take(rows * np.uint8(len(Part)) + self._parts)
        return flat


def _cells(count: int, size_px: int) -> Tuple[np.ndarray, np.ndarray]:
    """Return the cell of each pixel, and where in the cell the pixel is, 0 to 1."""
    place = (np.arange(size_px) + 0.5) * count / size_px
    cell = np.minimum(place.astype(np.intp), count - 1)
    return cell, place - cell


def _parts(x: np.ndarray, y: np.ndarray, cell_px: Tuple[float, float]) -> np.ndarray:
    """Return the Part of each pixel; y points down."""
    across, down = np.meshgrid(x, y)
    parts = np.zeros(across.shape, np.uint8)
    smallest_px = min(cell_px)
    if smallest_px < SMALLEST_WITH_PATTERN_PX:
        height, width = parts.shape
        stripe = (np.arange(width) + np.arange(height)[:, None]) // HATCH_PX % 2
        parts[stripe == 1] = Part.FIELD
        return parts
    lower_left = down > across
    cross = np.minimum(np.abs(across - down), np.abs(across + down - 1.0)) < CROSS
    parts[lower_left] = Part.HALF
    parts[cross] = Part.CROSS_ABOVE
    parts[cross & lower_left] = Part.CROSS
    dot = max(DOT, SMALLEST_DOT_PX / 2.0 / smallest_px)
    in_dot = (np.abs(across - 0.5) < dot) & (np.abs(down - 0.5) < dot)
    parts[in_dot] = Part.DOT
    parts[in_dot & lower_left] = Part.DOT_BELOW
    if smallest_px >= SMALLEST_WITH_LINES_PX:
        parts[:, np.flatnonzero(np.diff(x) < 0)] = Part.LINE
        parts[np.flatnonzero(np.diff(y) < 0)] = Part.LINE
    return parts

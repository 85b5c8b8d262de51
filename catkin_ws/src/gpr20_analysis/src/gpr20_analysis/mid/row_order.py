"""Rows of a large array put into the order of a grid."""

from __future__ import annotations

import math

import numpy as np

from gpr20_analysis.mid.trace_table import Allocate

EMPTY = complex(math.nan, math.nan)


def arrange(
    rows: np.ndarray, cells: np.ndarray, used: np.ndarray, count: int, allocate: Allocate
) -> np.ndarray:
    """Return an array whose row of each cell is the one that belongs there, NaN where none does.

    The rows are moved within the array if it is large enough, so that a survey is not held in
    memory twice; the array that is given is used up.

    Args:
        rows: Complex (rows, values); those behind `cells` are free.
        cells: Cell of each row that was filled.
        used: Which of those rows are wanted; their cells are different.
        count: How many cells there are.
        allocate: Makes a larger array, if one is needed.

    Returns:
        Complex (count, values).
    """
    source = np.full(count, -1, np.int64)
    source[cells[used]] = used
    if count > len(rows):
        found = allocate((count, rows.shape[1]))
        for cell in np.flatnonzero(source >= 0):
            found[cell] = rows[source[cell]]
        return found
    _permute(rows, _permutation(source, len(rows)))
    rows[:count][source < 0] = EMPTY
    return rows[:count]


def _permutation(source: np.ndarray, size: int) -> np.ndarray:
    """Return which row comes to each place, the unwanted ones where nothing is wanted."""
    free = np.setdiff1d(np.arange(size), source[source >= 0])
    whole = np.concatenate([source, np.full(size - len(source), -1, np.int64)])
    whole[whole < 0] = free
    return whole


def _permute(rows: np.ndarray, source: np.ndarray) -> None:
    done = source == np.arange(len(source))
    for start in np.flatnonzero(~done):
        if done[start]:
            continue
        kept = rows[start].copy()
        place = start
        while source[place] != start:
            rows[place] = rows[source[place]]
            done[place] = True
            place = source[place]
        rows[place] = kept
        done[place] = True

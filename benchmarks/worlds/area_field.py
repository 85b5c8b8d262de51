"""The field of a dipole over ground, in three dimensions, by finite differences in time.

Yee's scheme with six components. The layers at the edges absorb electric and magnetic fields alike,
which reflects nothing at right angles and little aslant; what is reflected is the same for every
position, because the edges move with the antennas.

The same scalar code runs on the processor (numba) and on a graphics card (numba.cuda).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, List, Tuple

import numpy as np
from line_field import Materials
from numba import njit, prange
from scipy.constants import speed_of_light

COURANT = 0.55
"""Light's path in one time step, in cells; at most the root of a third."""
ABSORBING_CELLS = 12
ONE, COURANT_32 = np.float32(1.0), np.float32(COURANT)


@dataclass(frozen=True)
class Boxes:
    """The part of the ground around each position of the antennas.

    Attributes:
        ground: Numbers of materials (depth, y, x) of the whole area, uint8.
        start: First row and column of each box (position, 2).
        shape: Cells of a box along depth, y and x.
        source: Depth, row and column of the transmitting dipole in each box; it lies along Y.
        receiver: Those of the receiver.
    """

    ground: np.ndarray
    start: np.ndarray
    shape: Tuple[int, int, int]
    source: Tuple[int, int, int]
    receiver: Tuple[int, int, int]

    def parts(self, most: int) -> List[Boxes]:
        """Return the same boxes in parts of so many at most."""
        firsts = range(0, len(self.start), most)
        return [replace(self, start=self.start[first : first + most]) for first in firsts]


def step_s(cell_m: float) -> float:
    """Return the time step [s] for a size of the cells."""
    return COURANT * cell_m / speed_of_light


def absorption(cells: int) -> np.ndarray:
    """Return half the decay in a time step along an axis, cubic in the absorbing layers."""
    place = np.arange(cells, dtype=np.float64)
    deep = np.maximum(ABSORBING_CELLS - place, place - (cells - 1 - ABSORBING_CELLS))
    share = np.clip(deep / ABSORBING_CELLS, 0.0, None)
    return (0.5 * COURANT * 10.0 * 4.0 / (2.0 * ABSORBING_CELLS) * share**3).astype(np.float32)


def magnetic_cell(
    ex: Any, ey: Any, ez: Any, hx: Any, hy: Any, hz: Any, b: int, k: int, j: int, i: int, decay: Any
) -> None:
    keep, gain = (ONE - decay) / (ONE + decay), COURANT_32 / (ONE + decay)
    x, y, z = ex[b, k, j, i], ey[b, k, j, i], ez[b, k, j, i]
    hx[b, k, j, i] = keep * hx[b, k, j, i] - gain * (
        ez[b, k, j + 1, i] - z - ey[b, k + 1, j, i] + y
    )
    hy[b, k, j, i] = keep * hy[b, k, j, i] - gain * (
        ex[b, k + 1, j, i] - x - ez[b, k, j, i + 1] + z
    )
    hz[b, k, j, i] = keep * hz[b, k, j, i] - gain * (
        ey[b, k, j, i + 1] - y - ex[b, k, j + 1, i] + x
    )


def electric_cell(
    ex: Any, ey: Any, ez: Any, hx: Any, hy: Any, hz: Any, b: int, k: int, j: int, i: int,
    decay: Any, inverse: Any,
) -> None:  # fmt: skip
    keep, gain = (ONE - decay) / (ONE + decay), COURANT_32 * inverse / (ONE + decay)
    x, y, z = hx[b, k, j, i], hy[b, k, j, i], hz[b, k, j, i]
    ex[b, k, j, i] = keep * ex[b, k, j, i] + gain * (
        z - hz[b, k, j - 1, i] - y + hy[b, k - 1, j, i]
    )
    ey[b, k, j, i] = keep * ey[b, k, j, i] + gain * (
        x - hx[b, k - 1, j, i] - z + hz[b, k, j, i - 1]
    )
    ez[b, k, j, i] = keep * ez[b, k, j, i] + gain * (
        y - hy[b, k, j, i - 1] - x + hx[b, k, j - 1, i]
    )


_magnetic, _electric = njit(inline="always")(magnetic_cell), njit(inline="always")(electric_cell)


@njit(parallel=True, fastmath=True, cache=True)
def _advance(ex, ey, ez, hx, hy, hz, ground, start, inverse, loss, az, ay, ax, sent, s, r, out):  # type: ignore[no-untyped-def]
    boxes, depths, rows, columns = ex.shape
    for b in range(boxes):
        for step in range(sent.size):
            for k in prange(depths - 1):
                for j in range(rows - 1):
                    for i in range(columns - 1):
                        decay = az[k] + ay[j] + ax[i]
                        _magnetic(ex, ey, ez, hx, hy, hz, b, k, j, i, decay)
            for k in prange(1, depths - 1):
                for j in range(1, rows - 1):
                    for i in range(1, columns - 1):
                        what = ground[k, start[b, 0] + j, start[b, 1] + i]
                        decay = az[k] + ay[j] + ax[i] + loss[what]
                        if inverse[what] > 0:
                            _electric(ex, ey, ez, hx, hy, hz, b, k, j, i, decay, inverse[what])
            ey[b, s[0], s[1], s[2]] -= COURANT_32 * sent[step]
            out[b, step] = ey[b, r[0], r[1], r[2]]


def received(
    boxes: Boxes, materials: Materials, cell_m: float, sent: np.ndarray, on_card: bool
) -> np.ndarray:
    """Return the field along Y at the receiver of each box (box, step)."""
    inverse, loss = materials.coefficients(step_s(cell_m))
    layers: List[np.ndarray] = [absorption(cells) for cells in boxes.shape]
    shape = (len(boxes.start), *boxes.shape)
    start = boxes.start.astype(np.int32)
    if on_card:
        from area_field_card import advance_on_card

        return advance_on_card(
            shape, boxes.ground, start, inverse, loss, layers, sent,
            (*boxes.source, *boxes.receiver),
        )  # fmt: skip
    fields = [np.zeros(shape, np.float32) for _ in range(6)]
    out = np.zeros((len(start), sent.size), np.float32)
    _advance(
        *fields, boxes.ground, start, inverse, loss, *layers, sent, boxes.source, boxes.receiver,
        out,
    )  # fmt: skip
    return out

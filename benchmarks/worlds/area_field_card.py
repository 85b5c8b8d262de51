"""The field of `area_field` on a graphics card of NVIDIA (numba.cuda)."""

from __future__ import annotations

from typing import Any, List, Sequence, Tuple

import area_field
import numpy as np
from numba import cuda

_magnetic = cuda.jit(device=True, inline="always")(area_field.magnetic_cell)
_electric = cuda.jit(device=True, inline="always")(area_field.electric_cell)
COURANT_32 = area_field.COURANT_32
THREADS = (64, 4, 1)


@cuda.jit(fastmath=True)
def _magnetic_step(ex, ey, ez, hx, hy, hz, az, ay, ax):  # type: ignore[no-untyped-def]
    i, j, deep = cuda.grid(3)
    b, k = deep // ex.shape[1], deep % ex.shape[1]
    if b < ex.shape[0] and k < ex.shape[1] - 1 and j < ex.shape[2] - 1 and i < ex.shape[3] - 1:
        _magnetic(ex, ey, ez, hx, hy, hz, b, k, j, i, az[k] + ay[j] + ax[i])


@cuda.jit(fastmath=True)
def _electric_step(
    ex, ey, ez, hx, hy, hz, ground, start, inverse, loss, az, ay, ax, sent, step, places, out
):  # type: ignore[no-untyped-def]
    i, j, deep = cuda.grid(3)
    b, k = deep // ex.shape[1], deep % ex.shape[1]
    if (
        b < ex.shape[0]
        and 0 < k < ex.shape[1] - 1
        and 0 < j < ex.shape[2] - 1
        and 0 < i < ex.shape[3] - 1
    ):
        what = ground[k, start[b, 0] + j, start[b, 1] + i]
        if inverse[what] > 0:
            decay = az[k] + ay[j] + ax[i] + loss[what]
            _electric(ex, ey, ez, hx, hy, hz, b, k, j, i, decay, inverse[what])
        if k == places[0] and j == places[1] and i == places[2]:
            ey[b, k, j, i] -= COURANT_32 * sent[step]
        if k == places[3] and j == places[4] and i == places[5]:
            out[b, step] = ey[b, k, j, i]


def advance_on_card(
    shape: Tuple[int, int, int, int],
    ground: np.ndarray,
    start: np.ndarray,
    inverse: np.ndarray,
    loss: np.ndarray,
    layers: Sequence[np.ndarray],
    sent: np.ndarray,
    places: Sequence[int],
) -> np.ndarray:
    """Return the received field (box, step); see `area_field.received`."""
    fields: List[Any] = [cuda.to_device(np.zeros(shape, np.float32)) for _ in range(6)]
    az, ay, ax = (cuda.to_device(one) for one in layers)
    ground, start, inverse, loss, sent_there = (
        cuda.to_device(one) for one in (ground, start, inverse, loss, sent)
    )
    where = cuda.to_device(np.array(places, np.int32))
    out = cuda.to_device(np.zeros((shape[0], sent.size), np.float32))
    cells = (shape[3], shape[2], shape[0] * shape[1])
    blocks = tuple(-(-count // threads) for count, threads in zip(cells, THREADS))
    magnetic, electric = _magnetic_step[blocks, THREADS], _electric_step[blocks, THREADS]
    for step in range(sent.size):
        magnetic(*fields, az, ay, ax)
        electric(*fields, ground, start, inverse, loss, az, ay, ax, sent_there, step, where, out)
    result: np.ndarray = out.copy_to_host()
    return result

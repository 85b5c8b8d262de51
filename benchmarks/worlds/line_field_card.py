"""The field of `line_field` on a graphics card of NVIDIA (numba.cuda)."""

from __future__ import annotations

from typing import Any, List, Sequence, Tuple

import line_field
import numpy as np
from numba import cuda

_magnetic = cuda.jit(device=True, inline="always")(line_field.magnetic_cell)
_electric = cuda.jit(device=True, inline="always")(line_field.electric_cell)
COURANT_32 = line_field.COURANT_32
THREADS = (64, 4, 1)


@cuda.jit(fastmath=True)
def _magnetic_step(ea, eb, hx, hz, ax, az):  # type: ignore[no-untyped-def]
    i, k, b = cuda.grid(3)
    if b < ea.shape[0] and k < ea.shape[1] - 1 and i < ea.shape[2] - 1:
        _magnetic(ea, eb, hx, hz, b, k, i, ax, az)


@cuda.jit(fastmath=True)
def _electric_step(ea, eb, hx, hz, ground, start, inverse, loss, ax, az, sent, step, places, out):  # type: ignore[no-untyped-def]
    i, k, b = cuda.grid(3)
    if b < ea.shape[0] and 0 < k < ea.shape[1] - 1 and 0 < i < ea.shape[2] - 1:
        what = ground[k, start[b] + i]
        _electric(ea, eb, hx, hz, b, k, i, ax, az, inverse[what], loss[what])
        if k == places[0] and i == places[1]:
            eb[b, k, i] -= COURANT_32 * sent[step]
        if k == places[2] and i == places[3]:
            out[b, step] = ea[b, k, i] + eb[b, k, i]


def advance_on_card(
    shape: Tuple[int, int, int],
    ground: np.ndarray,
    start: np.ndarray,
    inverse: np.ndarray,
    loss: np.ndarray,
    layers: Sequence[np.ndarray],
    sent: np.ndarray,
    places: Sequence[int],
) -> np.ndarray:
    """Return the received field (window, step); see `line_field.received`."""
    fields: List[Any] = [cuda.to_device(np.zeros(shape, np.float32)) for _ in range(4)]
    eax, eaz, hax, haz = (cuda.to_device(one) for one in layers)
    ground, start, inverse, loss, sent_there = (
        cuda.to_device(one) for one in (ground, start, inverse, loss, sent)
    )
    where = cuda.to_device(np.array(places, np.int32))
    out = cuda.to_device(np.zeros((shape[0], sent.size), np.float32))
    blocks = tuple(-(-cells // threads) for cells, threads in zip(shape[::-1], THREADS))
    magnetic, electric = _magnetic_step[blocks, THREADS], _electric_step[blocks, THREADS]
    for step in range(sent.size):
        magnetic(*fields, hax, haz)
        electric(*fields, ground, start, inverse, loss, eax, eaz, sent_there, step, where, out)
    result: np.ndarray = out.copy_to_host()
    return result

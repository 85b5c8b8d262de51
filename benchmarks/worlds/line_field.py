"""The field of a line source over ground, in two dimensions, by finite differences in time.

Yee's scheme for the electric field along Y and the magnetic field in the plane of X and depth, with
Berenger's split field in the layers that absorb at the edges. Bodies are cylinders of any cross
section, so a level disc is a level strip. Scattering, refraction, creeping waves and loss are all
in it; rays, delays and point targets are not. See Taflove and Hagness, Computational
Electrodynamics, 3rd edition, chapters 3 and 7.

The same scalar code runs on the processor (numba) and on a graphics card (numba.cuda).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Tuple

import numpy as np
from numba import njit, prange
from scipy.constants import speed_of_light

COURANT = 0.7
"""Light's path in one time step, in cells; at most the root of a half."""
ABSORBING_CELLS = 16
# In single precision, so that nothing is computed in double.
ZERO, ONE, COURANT_32 = np.float32(0.0), np.float32(1.0), np.float32(COURANT)


@dataclass(frozen=True)
class Materials:
    """What the numbers of a map of the ground mean.

    Attributes:
        permittivity: Relative permittivities.
        conductivity_s_per_m: Conductivities [S/m]; infinite for metal.
    """

    permittivity: np.ndarray
    conductivity_s_per_m: np.ndarray

    def coefficients(self, step_s: float) -> Tuple[np.ndarray, np.ndarray]:
        """Return 1 / permittivity and half the decay by conduction in a time step.

        Metal has 1 / permittivity 0: its field stays 0.
        """
        metal = np.isinf(self.conductivity_s_per_m)
        inverse = np.where(metal, 0.0, 1.0 / self.permittivity)
        loss = np.where(metal, 0.0, self.conductivity_s_per_m) * inverse
        half_decay = 0.5 * step_s * loss / 8.8541878128e-12
        return inverse.astype(np.float32), half_decay.astype(np.float32)


@dataclass(frozen=True)
class Windows:
    """The part of the ground around each position of the antennas.

    Attributes:
        ground: Numbers of materials (depth, x) of the whole line, uint8.
        start: First column of each window.
        columns: Columns of a window.
        source: Row and column of the transmitting line source in each window (2).
        receiver: Row and column of the receiver (2).
    """

    ground: np.ndarray
    start: np.ndarray
    columns: int
    source: Tuple[int, int]
    receiver: Tuple[int, int]


def absorption(cells: int, offset: float) -> np.ndarray:
    """Return half the decay in a time step along an axis, fourth power in the absorbing layers.

    Args:
        cells: Cells along the axis.
        offset: Place of the field in its cell, 0 or 0.5.
    """
    place = np.arange(cells) + offset
    deep = np.maximum(ABSORBING_CELLS - place, place - (cells - 1 - ABSORBING_CELLS))
    share = np.clip(deep / ABSORBING_CELLS, 0.0, None)
    # Reflection exp(-16) of a wave that crosses the layer twice at right angles.
    most = 16.0 * 5.0 / (2.0 * ABSORBING_CELLS)
    return (0.5 * COURANT * most * share**4).astype(np.float32)


def pulse(frequency_hz: float, step_s: float, steps: int) -> np.ndarray:
    """Return Ricker's pulse of a centre frequency at the middle of each time step."""
    delay_s = 1.4 / frequency_hz
    time_s = (np.arange(steps) + 0.5) * step_s - delay_s
    phase = (np.pi * frequency_hz * time_s) ** 2
    return ((1.0 - 2.0 * phase) * np.exp(-phase)).astype(np.float32)


def step_s(cell_m: float) -> float:
    """Return the time step [s] for a size of the cells."""
    return COURANT * cell_m / speed_of_light


def transfer(
    received: np.ndarray, sent: np.ndarray, step_s: float, frequency_hz: np.ndarray
) -> np.ndarray:
    """Return received over sent at frequencies (position, frequency), as exp(-2j pi f delay).

    Args:
        received: Fields at the end of each time step (position, step).
        sent: The pulse at the middle of each time step.
        step_s: The time step [s].
        frequency_hz: Frequencies [Hz].
    """
    late_s = (np.arange(received.shape[-1]) + 1.0) * step_s
    kernel = np.exp(-2j * np.pi * np.outer(late_s, frequency_hz))
    middle = np.exp(2j * np.pi * frequency_hz * 0.5 * step_s)
    spectrum = sent.astype(np.float64) @ (kernel * middle)
    found: np.ndarray = (received.astype(np.float64) @ kernel) / spectrum
    return found


def magnetic_cell(
    ea: Any, eb: Any, hx: Any, hz: Any, b: int, k: int, i: int, ax: Any, az: Any
) -> None:
    here = ea[b, k, i] + eb[b, k, i]
    below = ea[b, k + 1, i] + eb[b, k + 1, i]
    right = ea[b, k, i + 1] + eb[b, k, i + 1]
    hx[b, k, i] = ((ONE - az[k]) * hx[b, k, i] + COURANT_32 * (below - here)) / (ONE + az[k])
    hz[b, k, i] = ((ONE - ax[i]) * hz[b, k, i] - COURANT_32 * (right - here)) / (ONE + ax[i])


def electric_cell(
    ea: Any, eb: Any, hx: Any, hz: Any, b: int, k: int, i: int, ax: Any, az: Any,
    inverse: Any, loss: Any,
) -> None:  # fmt: skip
    down = az[k] + loss
    side = ax[i] + loss
    if inverse > ZERO:
        gain = COURANT_32 * inverse
        ea[b, k, i] = ((ONE - down) * ea[b, k, i] + gain * (hx[b, k, i] - hx[b, k - 1, i])) / (
            ONE + down
        )
        eb[b, k, i] = ((ONE - side) * eb[b, k, i] - gain * (hz[b, k, i] - hz[b, k, i - 1])) / (
            ONE + side
        )


_magnetic, _electric = njit(inline="always")(magnetic_cell), njit(inline="always")(electric_cell)


@njit(parallel=True, fastmath=True, cache=True)
def _advance(
    ea, eb, hx, hz, ground, start, inverse, loss, eax, eaz, hax, haz, sent, tz, tx, rz, rx, out
):  # type: ignore[no-untyped-def]
    windows, rows, columns = ea.shape
    for b in prange(windows):
        for step in range(sent.size):
            for k in range(rows - 1):
                for i in range(columns - 1):
                    _magnetic(ea, eb, hx, hz, b, k, i, hax, haz)
            for k in range(1, rows - 1):
                for i in range(1, columns - 1):
                    what = ground[k, start[b] + i]
                    _electric(ea, eb, hx, hz, b, k, i, eax, eaz, inverse[what], loss[what])
            eb[b, tz, tx] -= COURANT_32 * sent[step]
            out[b, step] = ea[b, rz, rx] + eb[b, rz, rx]


def received(
    windows: Windows, materials: Materials, cell_m: float, sent: np.ndarray, on_card: bool
) -> np.ndarray:
    """Return the field at the receiver of each window (window, step).

    Args:
        windows: The windows.
        materials: What the numbers of the ground mean.
        cell_m: Size of the cells [m].
        sent: The pulse.
        on_card: Whether a graphics card computes it.
    """
    rows, columns, count = windows.ground.shape[0], windows.columns, len(windows.start)
    inverse, loss = materials.coefficients(step_s(cell_m))
    layers = [absorption(cells, offset) for offset in (0.0, 0.5) for cells in (columns, rows)]
    shape = (count, rows, columns)
    places = (*windows.source, *windows.receiver)
    start = windows.start.astype(np.int32)
    if on_card:
        from line_field_card import advance_on_card

        return advance_on_card(shape, windows.ground, start, inverse, loss, layers, sent, places)
    fields = [np.zeros(shape, np.float32) for _ in range(4)]
    out = np.zeros((count, sent.size), np.float32)
    _advance(*fields, windows.ground, start, inverse, loss, *layers, sent, *places, out)
    return out

"""Sums of the cells around an echo, each at its own delay, and where such a sum is largest."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from gpr20_analysis.imaging.permittivity.echo_cells import Cells
from gpr20_analysis.imaging.permittivity.wavefront import Wavefront

# Of Newton's method.
STEPS = 5
LONGEST_STEP_M = 0.008
# Range and step of the delays around the reference.
LAG_S = 0.45e-9
LAG_STEP_S = 6e-12
# Parts of the aperture by the angle in air, and the least relative level of one.
RINGS = 8
FAINTEST_RING = 0.02


class Sums:
    """Sums of all cells, each at its own delay.

    Args:
        cells: The cells.
        shape: Spectrum of the body (cell, frequency), which is correlated with the cells.
    """

    def __init__(self, cells: Cells, shape: np.ndarray) -> None:
        lags_s = np.arange(-LAG_S, LAG_S + LAG_STEP_S, LAG_STEP_S)
        rate = 2j * np.pi * cells.frequency_hz[:, None]
        shifts = np.exp(rate * lags_s)
        spectra = cells.spectra * np.conj(shape)
        # The values at some lags, and the first and second derivative by the lag.
        self._tables = [spectra @ (rate**order * shifts) for order in range(3)]
        self._reference_s = cells.reference_s
        self._lags = len(lags_s)
        self._rows = np.arange(len(spectra))[None, :]

    def at(
        self, front: Wavefront, weights: np.ndarray, moved_m: np.ndarray
    ) -> Tuple[np.ndarray, np.ndarray]:
        """Return the weighted sum of each trial, and the values of all cells."""
        values = self._values(self._place(front, moved_m), 0)
        return values @ weights, values

    def best_move_m(self, front: Wavefront, weights: np.ndarray, moved_m: np.ndarray) -> np.ndarray:
        """Return the move (trial, 3) of x, y and optical depth that makes each sum largest."""
        for _ in range(STEPS):
            place = self._place(front, moved_m)
            values, first, second = (self._values(place, order) for order in range(3))
            total = values @ weights
            total = np.where(total == 0.0, 1e-300, total)
            slope = np.einsum("gc,jgc->gj", weights * first, front.slopes) / total[:, None]
            bend = np.einsum("gc,jgc,kgc->gjk", weights * second, front.slopes, front.slopes)
            bend = bend / total[:, None, None] - slope[:, :, None] * slope[:, None, :]
            # Of the logarithm of the sum's magnitude. Always uphill, along each principal axis.
            curvature, axes = np.linalg.eigh(-bend.real)
            largest = curvature.max(axis=1, keepdims=True)
            curvature = np.maximum(np.abs(curvature), 1e-4 * np.maximum(largest, 1e-9))
            along = np.einsum("gji,gj->gi", axes, slope.real) / curvature
            step_m = np.einsum("gij,gj->gi", axes, along)
            moved_m = moved_m + np.clip(step_m, -LONGEST_STEP_M, LONGEST_STEP_M)
        return moved_m

    def _place(self, front: Wavefront, moved_m: np.ndarray) -> np.ndarray:
        lag_s = front.delay_s - self._reference_s
        lag_s = lag_s + np.einsum("jgc,gj->gc", front.slopes, moved_m)
        return np.clip((lag_s + LAG_S) / LAG_STEP_S, 0.0, self._lags - 2.001)

    def _values(self, place: np.ndarray, order: int) -> np.ndarray:
        index = place.astype(np.int64)
        share = place - index
        table = self._tables[order]
        values: np.ndarray = table[self._rows, index] * (1.0 - share)
        values += table[self._rows, index + 1] * share
        return values


def measured_level(
    values: np.ndarray, cosine: np.ndarray, energy: np.ndarray, count: np.ndarray, noise: float
) -> Optional[np.ndarray]:
    """Return the level of each cell: spreading times what is measured over the angle in air.

    None if nothing is above noise near the vertical.
    """
    spreading = cosine**4
    rings = min(RINGS, max(2, len(values) // 3))
    edges = np.quantile(cosine, np.linspace(0.0, 1.0, rings + 1))
    ring = np.clip(np.searchsorted(edges, cosine, side="right") - 1, 0, rings - 1)

    def added(one: np.ndarray) -> np.ndarray:
        return np.bincount(ring, one * count, rings)

    traces = np.maximum(added(np.ones(len(values))), 1.0)
    mean = (added(values.real) + 1j * added(values.imag)) / traces
    expected = np.maximum(added(spreading * energy) / traces, 1e-3)
    level = np.sqrt(np.maximum(np.abs(mean) ** 2 - noise / traces, 0.0)) / expected
    # The last rings are nearest to the vertical.
    top = float(level[-2:].max())
    if not top > 0.0:
        return None
    level = np.clip(level / top, FAINTEST_RING, 1.5)
    middle = added(cosine) / traces
    return spreading * np.interp(cosine, middle, level)

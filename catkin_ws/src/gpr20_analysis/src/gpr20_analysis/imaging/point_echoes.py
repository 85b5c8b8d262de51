"""The spectra that points in the ground would leave in the traces of a survey.

Every point has the delays of the refracted paths, spreads with the square of the delay, and has
lost its mean over all positions, as a survey has with its background.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import numpy as np

from gpr20_analysis.imaging.a_scans import gated_sweep
from gpr20_analysis.imaging.one_height import unit_phasor
from gpr20_analysis.imaging.records import Focus, Traces, antenna_offset_m
from gpr20_survey.radar.refraction import one_way_delay_s

# Traces that amplitudes are fitted to, evenly taken from all.
MOST_FITTED = 3000


class PointEchoes:
    """Fits points to traces, and takes them away.

    Args:
        traces: The traces.
        focus: How the image is focused.
        longest_s: Longest delay that counts [s]; the spectra become as coarse as that allows.
    """

    def __init__(self, traces: Traces, focus: Focus, longest_s: float) -> None:
        sweep, gate = gated_sweep(traces.sweep, longest_s)
        flat = traces.s21.reshape(-1, traces.sweep.count)
        self._present = np.flatnonzero(np.any(flat != 0.0, axis=1))
        self._spectra = flat @ gate.astype(np.complex64)
        self._traces = replace(traces, sweep=sweep)
        self._weights = focus.window.weights(sweep.count).astype(np.float32)
        y_m, x_m = np.meshgrid(traces.y_m, traces.x_m, indexing="ij")
        self._y_m, self._x_m = y_m.ravel(), x_m.ravel()
        offset_m = antenna_offset_m(traces, focus)
        self._offsets_m = (offset_m, (-offset_m[0], -offset_m[1])) if any(offset_m) else (offset_m,)
        self._permittivity = focus.permittivity
        self._height_m = float(np.mean(traces.height_m))
        step = -(-len(self._present) // MOST_FITTED)
        self._fitted = self._present[::step]
        self._atoms = np.zeros((0, self._fitted.size * sweep.count), np.complex64)
        self._places_m = np.zeros((0, 3))

    def add(self, places_m: np.ndarray) -> None:
        """Add points (point, 3): depth, y, x [m]."""
        atoms = [self._spectrum(place_m, self._fitted) * self._weights for place_m in places_m]
        flat = np.stack(atoms).reshape(len(atoms), -1).astype(np.complex64)
        self._atoms = np.concatenate([self._atoms, flat])
        self._places_m = np.concatenate([self._places_m, places_m])

    def left(self) -> Traces:
        """Return the traces without all points, whose amplitudes fit them best."""
        measured = (self._spectra[self._fitted] * self._weights).ravel()
        products = self._atoms.conj() @ self._atoms.T
        amplitudes = np.linalg.lstsq(products, self._atoms.conj() @ measured, rcond=1e-6)[0]
        left = self._spectra.copy()
        for place_m, amplitude in zip(self._places_m, amplitudes):
            echo = self._spectrum(place_m, self._present) * np.complex64(amplitude)
            left[self._present] = left[self._present] - echo
        traces = self._traces
        shape = (*traces.height_m.shape, traces.sweep.count)
        return replace(traces, s21=left.reshape(shape).astype(np.complex64))

    def _spectrum(self, place_m: Sequence[float], which: np.ndarray) -> np.ndarray:
        """Return the spectra (trace, frequency) of a point at some traces."""
        depth_m, y_m, x_m = place_m
        one_way_s = [
            one_way_delay_s(
                self._traces.height_m.ravel()[which],
                depth_m,
                np.hypot(
                    self._x_m[which] + offset_m[0] - x_m, self._y_m[which] + offset_m[1] - y_m
                ),
                self._permittivity,
            )
            for offset_m in self._offsets_m
        ]
        delay_s = 2.0 * np.mean(one_way_s, axis=0)
        # The same for all traces and for those that are fitted.
        straight_s = 2.0 * one_way_delay_s(self._height_m, depth_m, 0.0, self._permittivity)
        level = ((straight_s / delay_s) ** 2).astype(np.float32)
        phase_rad = -2.0 * np.pi * delay_s[:, None] * self._traces.sweep.frequency_hz
        spectra = level[:, None] * unit_phasor(phase_rad)
        spectra -= spectra.mean(axis=0)
        return spectra

"""The traces around an echo, aligned by its expected delays and averaged over small cells.

What is left after the alignment varies slowly from position to position, so that averages over
cells hold what hundreds of traces held.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gpr20_analysis.imaging.a_scans import gated_sweep
from gpr20_analysis.imaging.permittivity.echo_search import TRIAL_PERMITTIVITY, Apex
from gpr20_analysis.imaging.permittivity.wavefront import Stops, antenna_offset_m, wavefront
from gpr20_analysis.imaging.records import Focus, Traces

WIDEST_ANGLE_DEG = 60.0
# Over the aperture; of one line more, since there are fewer of them.
CELLS_ACROSS = 15
CELLS_OF_A_LINE = 40
# Delays after the last aligned one that are kept.
AFTER_S = 0.6e-9


@dataclass(frozen=True)
class Cells:
    """Mean spectra of cells, each advanced by its reference delay.

    Attributes:
        spectra: Weighted spectra (cell, frequency); their sum is the trace at the reference delay.
        frequency_hz: Frequencies [Hz].
        weights: Weights over the band that the spectra have; their sum is 1.
        stops: Mean position of the antennas in each cell.
        reference_s: Reference delay of each cell [s].
        count: Number of traces in each cell.
        one_line: Whether all traces are on one line.
    """

    spectra: np.ndarray
    frequency_hz: np.ndarray
    weights: np.ndarray
    stops: Stops
    reference_s: np.ndarray
    count: np.ndarray
    one_line: bool


def cells_around(traces: Traces, focus: Focus, apex: Apex) -> Cells:
    """Return the cells around an echo, aligned as the echo of a point."""
    grid_y, grid_x = (axis.ravel() for axis in np.meshgrid(traces.y_m, traces.x_m, indexing="ij"))
    height_m = traces.height_m.ravel()
    spectra = traces.s21.reshape(-1, traces.sweep.count)
    below_m = float(np.mean(height_m)) + apex.optical_m / TRIAL_PERMITTIVITY
    aperture_m = below_m * np.tan(np.radians(WIDEST_ANGLE_DEG))
    near = np.flatnonzero(np.hypot(grid_x - apex.x_m, grid_y - apex.y_m) <= aperture_m)
    near = near[np.any(spectra[near] != 0.0, axis=1)]
    offset_m = antenna_offset_m(traces, focus)
    stops = Stops(grid_x[near], grid_y[near], height_m[near], offset_m)
    delay_s = _reference_s(stops, apex)
    sweep, gate = gated_sweep(traces.sweep, float(delay_s.max(initial=0.0)) * 1.05 + AFTER_S)
    weights = focus.window.weights(traces.sweep.count)
    scale = weights * (sweep.step_hz / traces.sweep.step_hz / weights.sum())
    aligned = spectra[near] @ (gate * scale[:, None])
    aligned = aligned * np.exp(2j * np.pi * sweep.frequency_hz * delay_s[:, None])
    one_line = min(len(traces.x_m), len(traces.y_m)) == 1
    size_m = 2.0 * aperture_m / (CELLS_OF_A_LINE if one_line else CELLS_ACROSS)
    row, column = (
        np.rint((axis - middle) / size_m).astype(int)
        for axis, middle in ((stops.y_m, apex.y_m), (stops.x_m, apex.x_m))
    )
    keys = np.stack([row, column], axis=1)
    _, cell, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    cell = cell.ravel()

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(cell, values, len(count)) / count

    means = np.zeros((len(count), sweep.count), dtype=np.complex128)
    np.add.at(means, cell, aligned)
    middle = Stops(mean(stops.x_m), mean(stops.y_m), mean(stops.height_m), offset_m)
    of_band = focus.window.weights(sweep.count)
    return Cells(
        means / count[:, None],
        sweep.frequency_hz,
        of_band / of_band.sum(),
        middle,
        _reference_s(middle, apex),
        count,
        one_line,
    )


def _reference_s(stops: Stops, apex: Apex) -> np.ndarray:
    place_m = (apex.x_m, apex.y_m)
    return wavefront(stops, place_m, apex.optical_m, TRIAL_PERMITTIVITY, 0.0).delay_s

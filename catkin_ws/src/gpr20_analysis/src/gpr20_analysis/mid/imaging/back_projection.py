"""Back-projection with the exact refracted delay of every pair of trace and voxel.

Each voxel is the sum of what every trace holds at the delay of the path to it. Positions and
heights may be any; the two antennas may stand apart. It needs numba.
"""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
import scipy.fft

from gpr20_analysis.errors import MissingLibraryError, WrongDatasetError
from gpr20_analysis.mid.imaging.delay_table import DelayTable, tabulate_delays
from gpr20_analysis.mid.imaging.gate import gated_sweep
from gpr20_analysis.mid.imaging.records import Focus, Traces
from gpr20_analysis.mid.imaging.refraction import SPEED_OF_LIGHT_M_S

# Linear interpolation between samples of the analytic signal loses (2 pi f dt)^2 / 8 of a
# component: 0.6 % at 3.3 GHz, 2 % at 6 GHz, and turns no phase.
SAMPLE_S = 10.6e-12


def back_projection_image(
    traces: Traces,
    focus: Focus,
    x_m: Optional[np.ndarray] = None,
    y_m: Optional[np.ndarray] = None,
) -> np.ndarray:
    """Return the complex image (depth, y, x).

    Args:
        traces: The traces; those that are zero throughout are skipped.
        focus: How to focus.
        x_m: Positions of the image along X [m]; default those of the traces.
        y_m: The same along Y.

    Raises:
        MissingLibraryError: numba is not installed.
        WrongDatasetError: No trace holds anything.
    """
    kernel = _kernel()
    x_m = traces.x_m if x_m is None else np.asarray(x_m, dtype=np.float64)
    y_m = traces.y_m if y_m is None else np.asarray(y_m, dtype=np.float64)
    place_m, spectra, height_m = _scattered(traces)
    apart_m = focus.separation_m / 2.0
    turn = np.radians(traces.rotation_deg)
    side_m = apart_m * np.array([np.cos(turn), np.sin(turn)])
    spread_m = [
        max(np.max(axis_m) - np.min(place), np.max(place) - np.min(axis_m))
        for axis_m, place in ((x_m, place_m[:, 0]), (y_m, place_m[:, 1]))
    ]
    table = tabulate_delays(
        height_m, focus.depth_m, float(np.hypot(*spread_m)) + apart_m, focus.permittivity
    )
    samples, sample_s = _a_scans(spectra, traces, focus, 2.0 * float(table.delay_s.max()))
    image = kernel(
        samples,
        place_m,
        side_m,
        *_levels(table, height_m, sample_s),
        (table.delay_s / sample_s).astype(np.float32),
        table.distance_step_m,
        x_m,
        y_m,
        _reaches_m(height_m, focus),
    )
    return np.moveaxis(image, 2, 0) / traces.height_m.size


def _kernel():  # type: ignore[no-untyped-def]
    try:
        from gpr20_analysis.mid.imaging.back_projection_kernel import project
    except ImportError as error:
        raise MissingLibraryError(
            "back-projection needs numba: pip install 'gpr20_analysis[compiled]'; the phase shift "
            "(--method phase-shift) does without"
        ) from error
    return project


def _scattered(traces: Traces) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return places (trace, 2), spectra (trace, frequency) and heights of what is not zero."""
    grid_y, grid_x = np.meshgrid(traces.y_m, traces.x_m, indexing="ij")
    spectra = traces.s21.reshape(-1, traces.sweep.count)
    held = np.any(spectra != 0.0, axis=1)
    if not np.any(held):
        raise WrongDatasetError("every trace is zero or was left out; there is nothing to image")
    place_m = np.stack([grid_x.ravel(), grid_y.ravel()], axis=1)
    return place_m[held], spectra[held], traces.height_m.ravel()[held]


def _a_scans(
    spectra: np.ndarray, traces: Traces, focus: Focus, longest_delay_s: float
) -> Tuple[np.ndarray, float]:
    """Return analytic A-scans (trace, delay) from delay 0 on, and their sample time [s]."""
    sweep, gate = gated_sweep(traces.sweep, longest_delay_s)
    weights = focus.window.weights(traces.sweep.count)
    scale = sweep.step_hz / (weights.sum() * traces.sweep.step_hz)
    matrix = (gate * (weights[:, None] * scale)).astype(np.complex64)
    gated = spectra.astype(np.complex64) @ matrix
    count = scipy.fft.next_fast_len(int(np.ceil(sweep.unambiguous_s / SAMPLE_S)))
    sample_s = sweep.unambiguous_s / count
    # ifft divides by the count; the true frequency of the first value is put back as a phase.
    samples = scipy.fft.ifft(gated, count, axis=1, workers=2)
    delay_s = sample_s * np.arange(count)
    samples *= (count * np.exp(2j * np.pi * sweep.start_hz * delay_s)).astype(np.complex64)
    kept = min(count, int(np.ceil(longest_delay_s / sample_s)) + 3)
    return np.ascontiguousarray(samples[:, :kept]), sample_s


def _levels(
    table: DelayTable, height_m: np.ndarray, sample_s: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Return the table's height nearest to each trace's, and what is more, in samples."""
    level = np.rint((height_m - table.lowest_m) / table.height_step_m).astype(np.int64)
    more_m = height_m - table.lowest_m - table.height_step_m * level
    return level, (more_m / SPEED_OF_LIGHT_M_S / sample_s).astype(np.float32)


def _reaches_m(height_m: np.ndarray, focus: Focus) -> np.ndarray:
    """Return how far across the widest ray gets [m], (trace, depth)."""
    sine = np.sin(np.radians(focus.widest_angle_deg))
    in_air = sine / np.sqrt(max(1.0 - sine**2, 1e-6))
    in_soil = sine / np.sqrt(max(focus.permittivity - sine**2, 1e-6))
    return height_m[:, None] * in_air + focus.depth_m[None, :] * in_soil

"""Kirchhoff migration as the GPR-20 group publishes it: a compatibility mode.

It repeats the group's program, for comparison with images made by it, with all its properties: the
three-dimensional image is the product of two families of two-dimensional ones (lines along X, lines
along Y), so its amplitudes are products and an echo must be bright in both; the mean height is used
for all traces, and the antennas are taken as one; the angles are the best of 256; the nearest
sample is used; the depth step is the sample time times the speed in the soil; an intended half
derivative acts as a gain over time. The group's own program was measured to place echoes about 5 mm
too shallow, for an unknown reason; this one does not. For everything else use the phase shift or
the back-projection.
"""

from __future__ import annotations

from typing import Any, List, Tuple

import numpy as np
import scipy.fft
from scipy.integrate import trapezoid

from gpr20_analysis import cluster
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_common.message import Message

# The rounded value of the group's program.
SPEED_M_S = 3e8
ANGLES = 256
LINES_AT_ONCE = 4


def kirchhoff_image(
    traces: Traces, focus: Focus, along: str = "xy"
) -> Tuple[np.ndarray, np.ndarray]:
    """Return the image (depth, y, x), real and not negative, and its depths [m].

    Args:
        traces: Traces on a regular grid.
        focus: Permittivity, and the first and last depth; the step follows from the sweep.
        along: "x": lines along X alone (2D); "y": along Y alone; "xy": the product (2.5D).

    Raises:
        WrongDatasetError: The depth range is smaller than the step of this method.
    """
    a_scans, sample_s = _real_a_scans(traces, focus)
    speed_m_s = SPEED_M_S / np.sqrt(focus.permittivity)
    step_m = sample_s * speed_m_s
    depth_m = np.arange(focus.depth_m[0], focus.depth_m[-1] + step_m / 2.0, step_m)
    if len(depth_m) < 2:
        raise WrongDatasetError(
            Message(
                "the depths {first_m:g} to {last_m:g} m are less than the depth step of this "
                "method, {step_m:.3g} m; choose a larger range",
                first_m=focus.depth_m[0],
                last_m=focus.depth_m[-1],
                step_m=step_m,
            )
        )
    height_m = float(np.mean(traces.height_m))
    image = np.ones((len(depth_m), *traces.height_m.shape))

    def lines(a_scans: np.ndarray, place_m: np.ndarray) -> np.ndarray:
        shared = (place_m, height_m, depth_m, sample_s, focus.permittivity)
        # Always split alike: the number of lines added up at once may change the last digit.
        return np.concatenate(cluster.distribute(_lines, shared, _bundles(a_scans)), axis=1)

    if "x" in along:
        image *= lines(a_scans, traces.x_m)
    if "y" in along:
        image *= np.swapaxes(lines(np.swapaxes(a_scans, 0, 1), traces.y_m), 1, 2)
    return image, depth_m


def _real_a_scans(traces: Traces, focus: Focus) -> Tuple[np.ndarray, float]:
    """Return real A-scans (y, x, delay) with the gain over time, and their sample time [s]."""
    sweep = traces.sweep
    first = round(sweep.start_hz / sweep.step_hz)
    count = 2 * (first + sweep.count - 1)
    spectra = np.zeros((*traces.height_m.shape, count // 2 + 1), dtype=np.complex128)
    spectra[..., first:] = traces.s21 * focus.window.weights(sweep.count)
    a_scans = scipy.fft.irfft(spectra, count, axis=-1, workers=2)
    sample_s = 1.0 / (count * sweep.step_hz)
    misplaced_hz = np.linspace(-0.5 / sample_s, 0.5 / sample_s, count)
    return a_scans * np.sqrt(np.pi * np.abs(misplaced_hz)), sample_s


def _bundles(a_scans: np.ndarray) -> List[np.ndarray]:
    return [
        np.ascontiguousarray(a_scans[first : first + LINES_AT_ONCE])
        for first in range(0, len(a_scans), LINES_AT_ONCE)
    ]


def _lines(shared: Tuple[Any, ...], a_scans: np.ndarray) -> np.ndarray:
    """Migrate each line (line, position, delay) separately; return (depth, line, position)."""
    place_m, height_m, depth_m, sample_s, permittivity = shared
    places = np.arange(len(place_m))
    offset_m = np.abs(place_m[:, None] - place_m[None, :])
    speed_m_s = SPEED_M_S / np.sqrt(permittivity)
    image = np.empty((len(depth_m), *a_scans.shape[:2]))
    for row, depth in enumerate(depth_m):
        angle_air, angle_soil = _angles(offset_m, height_m, depth, permittivity)
        air_m, soil_m = height_m / np.cos(angle_air), depth / np.cos(angle_soil)
        sample = np.rint(2.0 * (air_m / SPEED_M_S + soil_m / speed_m_s) / sample_s)
        sample = np.minimum(sample.astype(np.int64), a_scans.shape[2] - 1)
        weight = np.cos(angle_air) / np.sqrt(air_m + soil_m + 1e-9)
        kernel = weight * a_scans[:, places[None, :], sample]
        image[row] = np.abs(trapezoid(kernel, place_m, axis=2))
    return image


def _angles(
    offset_m: np.ndarray, height_m: float, depth_m: float, permittivity: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Return the angles to the vertical in air and soil, the best of a fixed set [rad]."""
    in_soil = np.linspace(0.0, np.pi / 2.0, ANGLES)
    in_air = np.arcsin(np.minimum(np.sqrt(permittivity) * np.sin(in_soil), 1.0))
    reached_m = depth_m * np.tan(in_soil) + height_m * np.tan(in_air)
    best = np.argmin(np.abs(offset_m[..., None] - reached_m), axis=-1)
    return in_air[best], in_soil[best]

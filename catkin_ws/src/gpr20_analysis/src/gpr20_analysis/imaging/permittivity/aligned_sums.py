"""Sums of the traces along the hyperbola of a point below a place.

The permittivity need not be known: with the delay of the apex given, the delays at the other
positions depend little on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np

from gpr20_analysis.imaging.a_scans import gated_a_scans
from gpr20_analysis.imaging.projection.delay_table import DISTANCE_STEP_M
from gpr20_analysis.imaging.records import Focus, Traces, antenna_offset_m
from gpr20_survey.radar.depth import two_way_delay_s
from gpr20_survey.radar.refraction import one_way_delay_s

TRIAL_PERMITTIVITY = 5.0
APERTURE_M = 0.22
APPARENT_DEPTH_M = 0.05


@dataclass(frozen=True)
class _Aligned:
    """What is shared by all places: the A-scans near them and a table of delays."""

    a_scans: np.ndarray
    sample_s: float
    x_m: np.ndarray
    y_m: np.ndarray
    higher_s: np.ndarray
    offset_m: Tuple[float, float]
    one_way_s: np.ndarray
    height_m: float


def levels_at(
    traces: Traces, focus: Focus, places: Sequence[Tuple[float, float]], optical_m: np.ndarray
) -> np.ndarray:
    """Return how well the traces add up (place, depth): the magnitude of their weighted sum.

    Args:
        traces: Traces of one polarization, without coupling and surface echo.
        focus: Window and antenna separation.
        places: X and Y of each place [m].
        optical_m: Depths times the refractive index [m].
    """
    shared = _aligned(traces, focus, np.array(places), optical_m)
    return np.stack([_level(shared, x_m, y_m) for x_m, y_m in places])


def _aligned(traces: Traces, focus: Focus, places: np.ndarray, optical_m: np.ndarray) -> _Aligned:
    x, y = (
        (axis_m >= of_places.min() - APERTURE_M) & (axis_m <= of_places.max() + APERTURE_M)
        for axis_m, of_places in zip((traces.x_m, traces.y_m), places.T)
    )
    grid_y, grid_x = np.meshgrid(traces.y_m[y], traces.x_m[x], indexing="ij")
    height_m = traces.height_m[np.ix_(y, x)].ravel()
    spectra = traces.s21[np.ix_(y, x)].reshape(-1, traces.sweep.count)
    mean_m = float(np.mean(height_m))
    distance_m = np.arange(0.0, APERTURE_M + focus.separation_m, DISTANCE_STEP_M)[:, None]
    depth_m = optical_m / np.sqrt(TRIAL_PERMITTIVITY)
    one_way_s = one_way_delay_s(mean_m, depth_m, distance_m, TRIAL_PERMITTIVITY)
    higher_s = two_way_delay_s(height_m - mean_m)
    longest_s = 2.0 * float(one_way_s.max()) + float(higher_s.max())
    a_scans, sample_s = gated_a_scans(spectra, traces.sweep, focus.window, longest_s)
    offset_m = antenna_offset_m(traces, focus)
    return _Aligned(
        a_scans, sample_s, grid_x.ravel(), grid_y.ravel(), higher_s, offset_m, one_way_s, mean_m
    )


def _level(shared: _Aligned, x_m: float, y_m: float) -> np.ndarray:
    """Return the level of each depth at a place."""
    away_m = np.hypot(shared.x_m - x_m, shared.y_m - y_m)
    near = np.flatnonzero(away_m <= APERTURE_M)
    delay_s = shared.higher_s[near][:, None]
    for side in (1.0, -1.0):
        leg_m = np.hypot(
            shared.x_m[near] + side * shared.offset_m[0] - x_m,
            shared.y_m[near] + side * shared.offset_m[1] - y_m,
        )
        row = np.minimum(np.rint(leg_m / DISTANCE_STEP_M).astype(int), len(shared.one_way_s) - 1)
        delay_s = delay_s + shared.one_way_s[row]
    place = np.maximum(delay_s / shared.sample_s, 0.0)
    index = np.minimum(place.astype(np.int64), shared.a_scans.shape[1] - 2)
    share = (place - index).astype(np.float32)
    rows = near[:, None]
    before = shared.a_scans[rows, index]
    values = before + share * (shared.a_scans[rows, index + 1] - before)
    # Spreading and an antenna pattern, each way; the source is a little below the surface.
    tangent = away_m[near] / (shared.height_m + APPARENT_DEPTH_M)
    weights = (1.0 / (1.0 + tangent**2) ** 2).astype(np.float32)
    total: np.ndarray = np.abs(weights @ values) / np.sqrt(np.sum(weights**2))
    return total

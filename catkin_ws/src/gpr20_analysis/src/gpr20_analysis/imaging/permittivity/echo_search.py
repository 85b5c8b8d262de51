"""Echoes of buried bodies: the places where the traces add up best along a hyperbola.

Positions may be irregular, and one line is enough. The permittivity need not be known: with the
delay of the apex given, the delays at the other positions depend little on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Tuple

import numpy as np

from gpr20_analysis.imaging.a_scans import gated_a_scans
from gpr20_analysis.imaging.permittivity.wavefront import antenna_offset_m
from gpr20_analysis.imaging.projection.delay_table import DISTANCE_STEP_M
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_survey.radar.depth import one_way_path_m, two_way_delay_s
from gpr20_survey.radar.frequency_to_delay import delay_kernel
from gpr20_survey.radar.refraction import one_way_delay_s

TRIAL_PERMITTIVITY = 5.0
# Two-way waves at 6 GHz need a position every 25 mm for angles of up to 30 deg; the strongest
# frequencies are lower.
TRACE_SPACING_M = 0.018
PLACE_SPACING_M = 0.028
OPTICAL_STEP_M = 0.012
APERTURE_M = 0.22
APPARENT_DEPTH_M = 0.05
# Resolution cells below the surface; nearer to it its residue hides an echo.
SHALLOWEST_CELLS = 1.7
MOST_ECHOES = 4
FAINTEST_DB = -14.0
NEAREST_M = 0.10
# Noise is measured at this many delays of at most this many traces.
NOISE_DELAYS = 64
NOISE_TRACES = 400


@dataclass(frozen=True)
class Apex:
    """Where an echo arrives first.

    Attributes:
        x_m: Place along X [m].
        y_m: Place along Y [m].
        optical_m: Depth of the body's top times the refractive index [m].
        level: Magnitude of the weighted sum of the traces over the root of the sum of the squared
            weights. With noise alone it is about the magnitude of one trace.
        clutter: Median of that over all places at this depth.
    """

    x_m: float
    y_m: float
    optical_m: float
    level: float
    clutter: float


@dataclass(frozen=True)
class _Aligned:
    """What is shared by all places: A-scans at thinned positions and a table of delays."""

    a_scans: np.ndarray
    sample_s: float
    x_m: np.ndarray
    y_m: np.ndarray
    higher_s: np.ndarray
    offset_m: Tuple[float, float]
    one_way_s: np.ndarray
    height_m: float


def noise_power(traces: Traces, focus: Focus, deepest_m: float) -> float:
    """Return the mean square of a trace at delays where no echo can arrive.

    They are later than those of all echoes, up to the end of the unambiguous range.

    Args:
        traces: Traces of one polarization.
        focus: Its window weights the band.
        deepest_m: Largest depth of a body times the refractive index [m].
    """
    spectra = traces.s21.reshape(-1, traces.sweep.count)
    spectra = spectra[np.any(spectra != 0.0, axis=1)]
    spectra = spectra[:: max(1, len(spectra) // NOISE_TRACES)]
    longest_s = 1.5 * two_way_delay_s(float(traces.height_m.max()) + deepest_m)
    end_s = traces.sweep.unambiguous_s
    delay_s = np.linspace(min(longest_s, 0.75 * end_s), 0.93 * end_s, NOISE_DELAYS)
    values = spectra @ delay_kernel(traces.sweep.frequency_hz, delay_s, focus.window)
    return float(np.mean(np.abs(values) ** 2))


def find_apexes(traces: Traces, focus: Focus, deepest_m: float) -> List[Apex]:
    """Return the strongest echoes, the strongest first.

    Args:
        traces: Traces of one polarization, without coupling and surface echo.
        focus: Window and antenna separation; its depths and permittivity do not matter.
        deepest_m: Largest depth of a body times the refractive index [m].
    """
    band_hz = traces.sweep.step_hz * traces.sweep.count
    shallowest_m = SHALLOWEST_CELLS * one_way_path_m(1.0 / band_hz)
    optical_m = np.arange(shallowest_m, deepest_m, OPTICAL_STEP_M)
    if len(optical_m) < 3:
        return []
    x_m, y_m = _thinned(traces.x_m, PLACE_SPACING_M), _thinned(traces.y_m, PLACE_SPACING_M)
    place_y, place_x = (
        axis.ravel() for axis in np.meshgrid(traces.y_m[y_m], traces.x_m[x_m], indexing="ij")
    )
    places = np.stack([place_x, place_y], axis=1)
    shared = _aligned(traces, focus, optical_m)
    level = np.stack([_level(shared, float(x_m), float(y_m)) for x_m, y_m in places])
    return _strongest(level, places, optical_m)


def _aligned(traces: Traces, focus: Focus, optical_m: np.ndarray) -> _Aligned:
    x, y = (_thinned(axis, TRACE_SPACING_M) for axis in (traces.x_m, traces.y_m))
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


def _strongest(level: np.ndarray, places: np.ndarray, optical_m: np.ndarray) -> List[Apex]:
    clutter = np.median(level, axis=0)
    left = level.copy()
    faintest = float(level.max()) * 10.0 ** (FAINTEST_DB / 20.0)
    found: List[Apex] = []
    while len(found) < MOST_ECHOES:
        place, depth = np.unravel_index(int(np.argmax(left)), left.shape)
        if not left[place, depth] > max(faintest, 0.0):
            break
        # A maximum at either end may be higher beyond it.
        if 0 < depth < len(optical_m) - 1:
            found.append(
                Apex(
                    float(places[place, 0]),
                    float(places[place, 1]),
                    float(optical_m[depth]),
                    float(level[place, depth]),
                    float(clutter[depth]),
                )
            )
        left[np.hypot(*(places - places[place]).T) < NEAREST_M] = 0.0
    return found


def _thinned(position_m: np.ndarray, spacing_m: float) -> np.ndarray:
    """Return the indices of positions that are at least so far apart."""
    kept = [0]
    for index in range(1, len(position_m)):
        if position_m[index] - position_m[kept[-1]] >= spacing_m * (1.0 - 1e-9):
            kept.append(index)
    return np.array(kept)

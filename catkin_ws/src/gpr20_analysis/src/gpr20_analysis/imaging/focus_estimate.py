"""The permittivity of the soil, estimated from how sharply echoes focus.

With a wrong permittivity the hyperbola of an echo has a wrong shape, and the traces do not add up
in phase. For each of the strongest echoes the sum of all traces along its hyperbola is computed
for a range of permittivities. Every trace has the same weight, so for a small target in level soil
the largest sum is at the true value (an image by phase shift weights the angles differently with
each permittivity, and its sharpness is biased upwards). Large bodies are not points and bias the
estimate, a sphere downwards. Where antennas are high and targets shallow, refraction has little
effect, and the range of the estimate is wide.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import List, Sequence, Tuple

import numpy as np

from gpr20_analysis import cluster
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.a_scans import gated_a_scans
from gpr20_analysis.imaging.echoes import maxima, peak_place
from gpr20_analysis.imaging.phase_shift import phase_shift_image
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.imaging.refraction import one_way_delay_s
from gpr20_common.message import Message

# Typical soils, from dry sand to wet clay.
LOWEST, HIGHEST = 2.0, 16.0
TRIALS = 29
# Permittivities whose sums are nearly as large are possible too.
NEARLY_AS_LARGE = 0.99
# Iterations after the first, and the relative change at which they end.
MOST_ROUNDS = 6
SETTLED = 0.01
STRONGEST_ECHOES = 4
FAINTEST_DB = -12.0
NEAREST_M = 0.05
# The best optical depth moves a little with the permittivity.
SHIFTS_M = np.linspace(-0.03, 0.03, 13)


@dataclass(frozen=True)
class PermittivityEstimate:
    """A permittivity and how well it is known.

    Attributes:
        permittivity: Where the echoes focus best.
        lowest: Lowest value at which they focus nearly as well (99 %).
        highest: Highest such value.
        echoes: Number of echoes that were used.
    """

    permittivity: float
    lowest: float
    highest: float
    echoes: int

    @property
    def depth_uncertainty(self) -> float:
        """Relative uncertainty of depths, which scale with 1 / sqrt(permittivity)."""
        return max(
            np.sqrt(self.permittivity / self.lowest) - 1.0,
            1.0 - np.sqrt(self.permittivity / self.highest),
        )


def estimate_permittivity(traces: Sequence[Traces], focus: Focus) -> PermittivityEstimate:
    """Search the permittivity at which the echoes focus best.

    Echoes are searched with the permittivity of the focus first, then with each estimate until
    it no longer changes.

    Args:
        traces: One item per polarization, without coupling and surface echo.
        focus: How to focus; its permittivity is only the first guess.

    Raises:
        WrongDatasetError: There is no echo, or the echoes focus best at the end of the range, so
            the data do not determine the permittivity.
    """
    optical_m = focus.depth_m * np.sqrt(focus.permittivity)
    found = _estimate_once(traces, focus)
    for _ in range(MOST_ROUNDS):
        before = found.permittivity
        depth_m = optical_m / np.sqrt(before)
        again = replace(focus, permittivity=before, depth_m=depth_m)
        found = _estimate_once(traces, again)
        if abs(found.permittivity / before - 1.0) < SETTLED:
            break
    return found


def _estimate_once(traces: Sequence[Traces], focus: Focus) -> PermittivityEstimate:
    permittivities = np.geomspace(LOWEST, HIGHEST, TRIALS)
    sums = np.zeros(TRIALS)
    count = 0
    for one in traces:
        echoes = _strongest(one, focus)
        count += len(echoes)
        if echoes:
            sums += _coherent_sums(one, focus, echoes, permittivities)
    if count == 0:
        raise WrongDatasetError(
            Message(
                "no echo was found, so the permittivity cannot be estimated; "
                "give it with --permittivity"
            )
        )
    best = int(np.argmax(sums))
    if best in (0, TRIALS - 1):
        raise WrongDatasetError(
            Message(
                "the echoes focus best at the end of the range, permittivity {permittivity:.3g}, "
                "so the permittivity cannot be estimated; give it with --permittivity",
                permittivity=permittivities[best],
            )
        )
    logarithms = np.log(permittivities)
    top, height = _parabola(logarithms[best - 1 : best + 2], sums[best - 1 : best + 2])
    near = np.flatnonzero(sums >= NEARLY_AS_LARGE * height)
    return PermittivityEstimate(
        float(np.exp(top)),
        float(permittivities[max(min(near[0], best) - 1, 0)]),
        float(permittivities[min(max(near[-1], best) + 1, TRIALS - 1)]),
        count,
    )


def _strongest(traces: Traces, focus: Focus) -> List[Tuple[float, float, float]]:
    """Return (x, y, optical depth) of the strongest echoes at the permittivity of the focus [m]."""
    magnitude = np.abs(phase_shift_image(traces, focus))
    axes = [focus.depth_m, traces.y_m, traces.x_m]
    threshold = float(magnitude.max()) * 10.0 ** (FAINTEST_DB / 20.0)
    if not threshold > 0.0:
        return []
    places = maxima(magnitude, axes, threshold, NEAREST_M)
    places.sort(key=lambda place: -magnitude[place])
    index = np.sqrt(focus.permittivity)
    found = [peak_place(magnitude, axes, place) for place in places[:STRONGEST_ECHOES]]
    return [(x_m, y_m, depth_m * index) for depth_m, y_m, x_m in found]


def _coherent_sums(
    traces: Traces,
    focus: Focus,
    echoes: Sequence[Tuple[float, float, float]],
    permittivities: np.ndarray,
) -> np.ndarray:
    """Return the sums of all traces along the hyperbolas, added up over the echoes."""
    deepest_m = float(focus.depth_m[-1]) * np.sqrt(focus.permittivity) + SHIFTS_M[-1]
    grid_y, grid_x = np.meshgrid(traces.y_m, traces.x_m, indexing="ij")
    spread_m = float(np.hypot(np.ptp(grid_x), np.ptp(grid_y)))
    # At the lowest permittivity the same optical depth is deepest, so its rays are longest.
    longest_s = 2.0 * one_way_delay_s(
        float(traces.height_m.max()), deepest_m / np.sqrt(LOWEST), spread_m, LOWEST
    )
    spectra = traces.s21.reshape(-1, traces.sweep.count)
    a_scans, sample_s = gated_a_scans(spectra, traces.sweep, focus.window, float(longest_s))
    trials = []
    for x_m, y_m, optical_m in echoes:
        distance_m = np.hypot(grid_x - x_m, grid_y - y_m).ravel()
        optical = np.maximum(optical_m + SHIFTS_M, 0.001)
        trials += [(distance_m, optical, float(trial)) for trial in permittivities]
    shared = (a_scans, sample_s, traces.height_m.ravel())
    largest = cluster.distribute(_largest_sum, shared, trials)
    return np.sum(np.reshape(largest, (len(echoes), -1)), axis=0)


def _largest_sum(
    shared: Tuple[np.ndarray, float, np.ndarray], echo: Tuple[np.ndarray, np.ndarray, float]
) -> float:
    """Return the largest sum along an echo's hyperbola, over some optical depths [m]."""
    a_scans, sample_s, height_m = shared
    distance_m, optical_m, permittivity = echo
    depth_m = optical_m[None, :] / np.sqrt(permittivity)
    delay_s = one_way_delay_s(height_m[:, None], depth_m, distance_m[:, None], permittivity)
    return float(np.abs(_at_delay(a_scans, 2.0 * delay_s / sample_s)).max())


def _at_delay(a_scans: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the sum over traces at delays (trace, depth), given in samples."""
    index = np.minimum(place.astype(np.int64), a_scans.shape[1] - 2)
    share = (place - index).astype(np.float32)
    rows = np.arange(len(a_scans))[:, None]
    before, after = a_scans[rows, index], a_scans[rows, index + 1]
    total: np.ndarray = np.sum(before + share * (after - before), axis=0)
    return total


def _parabola(x: np.ndarray, y: np.ndarray) -> Tuple[float, float]:
    """Return where the parabola through three evenly spaced points is highest, and how high."""
    bend = y[0] - 2.0 * y[1] + y[2]
    shift = 0.0 if bend == 0.0 else 0.5 * (y[0] - y[2]) / bend
    return float(x[1] + shift * (x[1] - x[0])), float(y[1] - 0.25 * (y[0] - y[2]) * shift)

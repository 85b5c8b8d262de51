"""How well one echo agrees with each permittivity, whatever the size of the body.

Cells are aligned by the delays that a body causes in soil of a permittivity, and added up. The
energy of that sum is what the body explains of the data: where it is largest, the traces agree
best. For each permittivity the place, the depth and the size of the body are those that explain
most. Bodies are spheres (with radius 0: points) and level discs.

The amplitude over the angle is measured, since the pattern of the antennas is not known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
from scipy.interpolate import CubicSpline

from gpr20_analysis.imaging.echo_cells import Cells
from gpr20_analysis.imaging.echo_search import Apex
from gpr20_analysis.imaging.wavefront import Wavefront, wavefront

PERMITTIVITIES = np.geomspace(1.5, 36.0, 25)
SPHERE_RADII_M = np.linspace(0.0, 0.06, 7)
RADII_BETWEEN = 61
DISC_RADII_M = (0.015, 0.025, 0.035, 0.045, 0.055)
# A body beside a single line cannot be told from a deeper one below it.
BESIDE_LINE_M = (0.0, 0.03, 0.06)
FEWEST_CELLS = 8
# Unknown of each fit: place, depth, amplitude and phase.
UNKNOWNS = 5
# Place and depth are found by Newton's method, repeated with delays of the place found.
MOST_ROUNDS = 3
STEPS = 5
LONGEST_STEP_M = 0.008
SETTLED_M = 0.0005
LAG_S = 0.45e-9
LAG_STEP_S = 6e-12
RINGS = 8
FAINTEST_RING = 0.02
DISC_SPACING_M = 0.014
# Energy that is missing for other reasons than noise: the squared phase left after the fit counts
# this many times, since it is alike in neighbouring cells, and each part of the aperture may be
# off by a phase.
LEFT_OVER_FACTOR = 4.0
PARTS_OF_APERTURE = 8
PHASE_ERROR_RAD = np.radians(3.0)


@dataclass(frozen=True)
class EchoFit:
    """An echo compared with bodies in soil of each of PERMITTIVITIES.

    Attributes:
        x_m: Place of the body along X [m].
        y_m: Place along Y [m].
        explained: Energy that the best body explains, for each permittivity.
        uncertainty: Difference of that energy which noise and errors of the model cause.
        left_over: Energy of the phase that the best body leaves, in excess of noise, as a share
            of what it explains.
    """

    x_m: float
    y_m: float
    explained: np.ndarray
    uncertainty: float
    left_over: float

    @property
    def worse(self) -> np.ndarray:
        """How much worse than the best each permittivity is, as difference of log likelihoods."""
        worse: np.ndarray = (self.explained.max() - self.explained) / self.uncertainty
        return worse


@dataclass(frozen=True)
class _Body:
    """The best bodies of one kind."""

    by_radius: np.ndarray
    place_m: np.ndarray
    permittivity: float
    left_over: float


def fit_echo(cells: Cells, apex: Apex, noise: float) -> Optional[EchoFit]:
    """Compare an echo with bodies of all sizes.

    Args:
        cells: The cells around it.
        apex: Where it was found.
        noise: Mean square of the noise of one trace.

    Returns:
        The comparison; None if there are too few cells, or no sum differs from noise.
    """
    if len(cells.count) < FEWEST_CELLS:
        return None
    place_m = np.array([apex.x_m, apex.y_m, apex.optical_m])
    point = np.ones_like(cells.spectra)
    sphere = _best_body(cells, point, SPHERE_RADII_M, place_m, noise, MOST_ROUNDS)
    if sphere is None:
        return None
    spheres = [sphere]
    if cells.one_line:
        beside = [
            _best_body(cells, point, SPHERE_RADII_M, beside_m, noise, 1)
            for beside_m in _beside(cells, sphere.place_m)
        ]
        spheres += [body for body in beside if body is not None]
    radii_m, discs = [0.0], []
    for radius_m in DISC_RADII_M:
        shape = _disc(cells, sphere, radius_m)
        disc = _best_body(cells, shape, np.zeros(1), sphere.place_m, noise, 2)
        if disc is not None:
            radii_m.append(radius_m)
            discs.append(disc)
    best = max([*spheres, *discs], key=lambda body: float(body.by_radius.max()))
    of_discs = np.hstack([sphere.by_radius[:, :1], *(disc.by_radius for disc in discs)])
    explained = np.max(
        [
            *(_best_of_all(SPHERE_RADII_M, body.by_radius) for body in spheres),
            _best_of_all(np.array(radii_m), of_discs),
        ],
        axis=0,
    )
    free = max(len(cells.count) - UNKNOWNS, 1)
    # The fewer cells, the less is known of what is left over.
    scatter = LEFT_OVER_FACTOR * (best.left_over / free) * (free + 4.0) / free
    error = PHASE_ERROR_RAD**2 * float(explained.max()) / PARTS_OF_APERTURE
    return EchoFit(
        float(best.place_m[0]),
        float(best.place_m[1]),
        explained,
        max(noise, scatter) + error,
        max(best.left_over - noise * free, 0.0) / float(explained.max()),
    )


def _best_body(
    cells: Cells,
    shape: np.ndarray,
    radii_m: np.ndarray,
    place_m: np.ndarray,
    noise: float,
    rounds: int,
) -> Optional[_Body]:
    """Return the best bodies of one kind.

    Args:
        cells: The cells.
        shape: Spectrum of the body (cell, frequency).
        radii_m: Radii of spheres [m].
        place_m: First guess of x, y and optical depth [m].
        noise: Mean square of the noise of one trace.
        rounds: How often the place is improved at most.
    """
    sums = _Sums(cells, shape)
    energy = (np.abs(shape) ** 2) @ cells.weights
    permittivity, radius_m = (
        axis.ravel() for axis in np.meshgrid(PERMITTIVITIES, radii_m, indexing="ij")
    )
    weights = None
    for _ in range(rounds):
        front = wavefront(
            cells.stops, (place_m[0], place_m[1]), place_m[2],
            permittivity[:, None], radius_m[:, None],
        )  # fmt: skip
        if weights is None:
            weights = cells.count * front.cosine[0] ** 4
        moved_m = sums.best_move_m(front, weights, np.zeros((len(permittivity), 3)))
        total, values = sums.at(front, weights, moved_m)
        best = int(np.argmax(np.abs(total)))
        level = _measured_level(values[best], front.cosine[best], energy, cells.count, noise)
        if level is None:
            return None
        weights = cells.count * level
        place_m = place_m + moved_m[best]
        if np.all(np.abs(moved_m[best]) < SETTLED_M):
            break
    moved_m = sums.best_move_m(front, weights, moved_m)
    total, values = sums.at(front, weights, moved_m)
    whole = float(np.sum(weights**2 / cells.count * energy))
    explained = np.abs(total) ** 2 / whole
    best = int(np.argmax(explained))
    amplitude = total[best] / whole
    ideal = amplitude * weights / cells.count * energy
    across = (values[best] - ideal) * np.conj(amplitude) / abs(amplitude)
    left_over = 2.0 * float(np.sum(cells.count * across.imag**2 / np.maximum(energy, 1e-6)))
    return _Body(
        explained.reshape(len(PERMITTIVITIES), -1),
        place_m,
        float(permittivity[best]),
        left_over,
    )


def _best_of_all(radii_m: np.ndarray, by_radius: np.ndarray) -> np.ndarray:
    """Return the largest value of each row, also between the radii that were tried."""
    if len(radii_m) < 3:
        return by_radius.max(axis=1)
    between_m = np.linspace(radii_m[0], radii_m[-1], RADII_BETWEEN)
    smooth: np.ndarray = CubicSpline(radii_m, by_radius, axis=1)(between_m).max(axis=1)
    return np.maximum(smooth, by_radius.max(axis=1))


class _Sums:
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


def _measured_level(
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


def _beside(cells: Cells, place_m: np.ndarray) -> List[np.ndarray]:
    """Return places beside a line."""
    along_x = np.ptp(cells.stops.x_m) > np.ptp(cells.stops.y_m)
    aside = np.array([0.0, 1.0, 0.0] if along_x else [1.0, 0.0, 0.0])
    return [place_m + away_m * aside for away_m in BESIDE_LINE_M[1:]]


def _disc(cells: Cells, sphere: _Body, radius_m: float) -> np.ndarray:
    """Return the spectrum of a level disc: the mean of points on it, aligned to its centre."""
    points = [(0.0, 0.0)]
    rings = int(np.ceil(radius_m / DISC_SPACING_M))
    for ring in range(1, rings + 1):
        angle_rad = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring)
        # Each ring stands for an area on both sides of it; the last has its area inside.
        ring_m = radius_m * (ring - 0.25 * (ring == rings)) / rings
        points += list(zip(ring_m * np.cos(angle_rad), ring_m * np.sin(angle_rad)))

    def delay_s(x_m: float, y_m: float) -> np.ndarray:
        place_m = (sphere.place_m[0] + x_m, sphere.place_m[1] + y_m)
        return wavefront(cells.stops, place_m, sphere.place_m[2], sphere.permittivity, 0.0).delay_s

    centre_s = delay_s(0.0, 0.0)
    spectrum = np.zeros(cells.spectra.shape, dtype=np.complex128)
    for x_m, y_m in points:
        turns = np.outer(delay_s(x_m, y_m) - centre_s, cells.frequency_hz)
        spectrum += np.exp(-2j * np.pi * turns)
    spectrum /= len(points)
    return spectrum

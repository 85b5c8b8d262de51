"""How well one echo agrees with each permittivity, whatever the size of the body.

Cells are aligned by the delays that a body causes in soil of a permittivity, and added up. The
energy of that sum is what the body explains of the data: where it is largest, the traces agree
best. For each permittivity the place, the depth and the size of the body are those that explain
most. Bodies are spheres (with radius 0: points) and level discs.

The amplitude over the angle is measured, since the pattern of the antennas is not known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import List, Optional

import numpy as np

from gpr20_analysis.imaging.permittivity.echo_cells import Cells
from gpr20_analysis.imaging.permittivity.echo_search import Apex
from gpr20_analysis.imaging.permittivity.echo_sums import Sums, measured_level
from gpr20_analysis.imaging.permittivity.wavefront import wavefront

PERMITTIVITIES = np.geomspace(1.5, 36.0, 41)
SPHERE_RADII_M = np.linspace(0.0, 0.06, 7)
# Between 0, which is a point, and these the best is found in finer steps.
DISC_RADII_M = (0.012, 0.024, 0.036, 0.048, 0.060)
FINER_M = 0.004 * np.arange(-2, 3)
# A body beside a single line cannot be distinguished from a deeper one below it.
BESIDE_LINE_M = (0.03, 0.06)
FEWEST_CELLS = 8
# Unknown of each fit: place, depth, amplitude and phase.
UNKNOWNS = 5
# Place and depth are improved with the delays of the place found before.
MOST_ROUNDS = 3
SETTLED_M = 0.0005
DISC_SPACING_M = 0.014
# Energy that is missing for other reasons than noise: the squared phase left after the fit counts
# this many times, since it is alike in neighbouring cells, and each part of the aperture may be
# off by a phase.
LEFT_OVER_FACTOR = 4.0
PARTS_OF_APERTURE = 8
PARTS_OF_A_LINE = 3
PHASE_ERROR_RAD = np.radians(4.0)


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
    discs = _best_discs(cells, sphere, noise)
    best = max([*spheres, *discs], key=lambda body: float(body.by_radius.max()))
    explained = np.max(
        [
            *(_best_of_all(body.by_radius) for body in spheres),
            *(_best_of_all(body.by_radius) for body in discs),
        ],
        axis=0,
    )
    free = max(len(cells.count) - UNKNOWNS, 1)
    # The fewer cells, the less is known of what is left over.
    scatter = LEFT_OVER_FACTOR * (best.left_over / free) * (free + 4.0) / free
    parts = PARTS_OF_A_LINE if cells.one_line else PARTS_OF_APERTURE
    error = PHASE_ERROR_RAD**2 * float(explained.max()) / parts
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
    sums = Sums(cells, shape)
    energy = (np.abs(shape) ** 2) @ cells.weights
    permittivity, radius_m = (
        axis.ravel() for axis in np.meshgrid(PERMITTIVITIES, radii_m, indexing="ij")
    )
    weights = np.zeros(0)
    for _ in range(rounds):
        front = wavefront(
            cells.stops, (place_m[0], place_m[1]), place_m[2],
            permittivity[:, None], radius_m[:, None],
        )  # fmt: skip
        if cells.one_line:
            # How far the body is from the line is given: the data hardly depend on it.
            front.slopes[_across(cells)] = 0.0
        if not weights.size:
            weights = cells.count * front.cosine[0] ** 4
        moved_m = sums.best_move_m(front, weights, np.zeros((len(permittivity), 3)))
        total, values = sums.at(front, weights, moved_m)
        best = int(np.argmax(np.abs(total)))
        level = measured_level(values[best], front.cosine[best], energy, cells.count, noise)
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


def _best_discs(cells: Cells, sphere: _Body, noise: float) -> List[_Body]:
    """Return discs of a few radii, and one item with all radii near the best of them."""

    def disc(radius_m: float) -> Optional[_Body]:
        shape = _disc(cells, sphere, radius_m)
        return _best_body(cells, shape, np.zeros(1), sphere.place_m, noise, 2)

    tried = {radius_m: disc(radius_m) for radius_m in DISC_RADII_M}
    found = {radius_m: body for radius_m, body in tried.items() if body is not None}
    point_level = float(sphere.by_radius[:, 0].max())
    best_m = max(found, key=lambda one: float(found[one].by_radius.max()), default=0.0)
    if not found or float(found[best_m].by_radius.max()) < point_level:
        best_m = 0.0
    near = [disc(best_m + step_m) for step_m in FINER_M if best_m + step_m > 0.0]
    columns = [sphere.by_radius[:, :1]] if best_m == 0.0 else []
    columns += [body.by_radius for body in near if body is not None]
    best = max(
        [body for body in near if body is not None] or [sphere],
        key=lambda body: float(body.by_radius.max()),
    )
    return [*found.values(), replace(best, by_radius=np.hstack(columns))] if columns else []


def _best_of_all(by_radius: np.ndarray) -> np.ndarray:
    """Return the largest value of each row, also between the radii, which have equal steps."""
    best = np.argmax(by_radius, axis=1)
    rows, last = np.arange(len(by_radius)), by_radius.shape[1] - 1
    before, top, after = (by_radius[rows, np.clip(best + step, 0, last)] for step in (-1, 0, 1))
    bend = 2.0 * top - before - after
    inside = (best > 0) & (best < last) & (bend > 0.0)
    # The highest point of a parabola through three points.
    rise = (after - before) ** 2 / (8.0 * np.where(inside, bend, 1.0))
    result: np.ndarray = top + np.where(inside, rise, 0.0)
    return result


def _beside(cells: Cells, place_m: np.ndarray) -> List[np.ndarray]:
    """Return places beside a line."""
    aside = np.eye(3)[_across(cells)]
    return [place_m + away_m * aside for away_m in BESIDE_LINE_M]


def _across(cells: Cells) -> int:
    """Return the axis across a line: 0 for X, 1 for Y."""
    return 1 if np.ptp(cells.stops.x_m) > np.ptp(cells.stops.y_m) else 0


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

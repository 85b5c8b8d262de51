"""What a body in a half space scatters, by Born's integral.

By reciprocity it is the sum over voxels of the transmitter's field times the receiver's field times
the contrast; see Chew, Waves and Fields in Inhomogeneous Media (1995), section 8.10. Echoes within
a body and between bodies are not in it, and in a body waves are as fast as in the soil.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np
from born_field import transmitted
from numba import njit
from scipy.constants import epsilon_0, speed_of_light

# Of the table of fields; between its distances they are linear.
DISTANCE_STEP_M = 0.001
VOXELS_PER_WAVELENGTH = 8
# Along a voxel, for the share of it that is in the body.
SAMPLES = 5


@dataclass(frozen=True)
class Antennas:
    """Positions of two dipoles along Y that are apart along X, on a square grid.

    Attributes:
        height_m: Their height [m].
        apart_m: Their distance [m].
        positions: Positions along X, and along Y.
        step_m: Distance of the positions [m].
    """

    height_m: float
    apart_m: float
    positions: int
    step_m: float


@dataclass(frozen=True)
class Layers:
    """A body as level discs on each other.

    Attributes:
        x_m: The middle along X [m], a multiple of the voxels' pitch.
        y_m: The middle along Y [m], another.
        depth_m: Depths of the layers' middles [m].
        radius_m: Their radii [m].
        thickness_m: Their thickness [m].
    """

    x_m: float
    y_m: float
    depth_m: np.ndarray
    radius_m: np.ndarray
    thickness_m: float

    @classmethod
    def of(
        cls, at_m: Tuple[float, float, float], wide_m: float, high_m: float, is_sphere: bool,
        pitch: float,
    ) -> Layers:  # fmt: skip
        """Return a level disc or a sphere in layers of a voxel's thickness at most.

        Args:
            at_m: Its middle along X and Y, and the depth of its top [m].
            wide_m: Its diameter [m].
            high_m: Its height [m].
            is_sphere: Whether it is a sphere.
            pitch: The pitch of the voxels [m].
        """
        count = int(np.ceil(high_m / pitch))
        down_m = (np.arange(count) + 0.5) * high_m / count
        round_m = np.sqrt(down_m * (high_m - down_m))
        radius_m = round_m if is_sphere else np.full(count, wide_m / 2.0)
        return cls(at_m[0], at_m[1], at_m[2] + down_m, radius_m, high_m / count)


def pitch_m(last_hz: float, permittivity: float, step_m: float) -> float:
    """Return the pitch of voxels, a part of the step, at most an eighth of the wavelength [m]."""
    most_m = speed_of_light / (last_hz * np.sqrt(permittivity) * VOXELS_PER_WAVELENGTH)
    return float(step_m / np.ceil(step_m / most_m))


def scattered(
    frequency_hz: float, soil: complex, antennas: Antennas, body: Layers, pitch: float
) -> np.ndarray:
    """Return what a body of contrast 1 adds at each position (y, x) [V/m].

    Multiply by the difference of the permittivities, and by the ratio of the field in the body to
    that without it.
    """
    own = round(antennas.step_m / pitch) * np.arange(antennas.positions)
    rows, columns = own - round(body.y_m / pitch), own - round(body.x_m / pitch)
    away = max(int(np.abs(rows).max()), int(np.abs(columns).max()))
    cells = away + int(np.ceil(body.radius_m.max() / pitch + 0.5)) + 1
    farthest_m = np.sqrt(2.0) * cells * pitch + antennas.apart_m
    distance_m = np.arange(0.0, farthest_m, DISTANCE_STEP_M)
    parts = transmitted(frequency_hz, soil, antennas.height_m, body.depth_m, distance_m)
    found = np.zeros((antennas.positions, antennas.positions), complex)
    for depth, radius_m in enumerate(body.radius_m):
        product = _products(parts[:, depth].copy(), pitch, antennas.apart_m / 2.0, cells)
        _gather(product, _shares(float(radius_m) / pitch), rows, columns, found)
    volume_m3 = pitch**2 * body.thickness_m
    return 2j * np.pi * frequency_hz * epsilon_0 * volume_m3 * found


def _shares(radius: float) -> np.ndarray:
    """Return the share of each voxel that is in a circle around the middle one; in voxels."""
    half = int(np.ceil(radius + 0.5))
    sample = (np.arange((2 * half + 1) * SAMPLES) + 0.5) / SAMPLES - half - 0.5
    inside = np.hypot(sample[:, None], sample) < radius
    shares: np.ndarray = inside.reshape(2 * half + 1, SAMPLES, -1, SAMPLES).mean(axis=(1, 3))
    return shares


@njit(cache=True)
def _field(parts, along, aside):  # type: ignore[no-untyped-def]
    distance = max(np.hypot(along, aside), 1e-9)
    cosine, sine = along / distance, aside / distance
    low = int(distance / DISTANCE_STEP_M)
    share = distance / DISTANCE_STEP_M - low
    zeroth = parts[0, low] * (1.0 - share) + parts[0, low + 1] * share
    first = parts[1, low] * (1.0 - share) + parts[1, low + 1] * share
    second = parts[2, low] * (1.0 - share) + parts[2, low + 1] * share
    double = cosine * cosine - sine * sine
    return zeroth + second * double, 2.0 * second * cosine * sine, first * cosine


@njit(cache=True)
def _products(parts, pitch, half_m, cells):  # type: ignore[no-untyped-def]
    """Return the scalar products of both fields at voxels of one quarter (y, x)."""
    found = np.empty((cells, cells), np.complex128)
    for row in range(cells):
        for column in range(cells):
            x_m = column * pitch
            sent = _field(parts, row * pitch, x_m + half_m)
            heard = _field(parts, row * pitch, x_m - half_m)
            found[row, column] = sent[0] * heard[0] + sent[1] * heard[1] + sent[2] * heard[2]
    return found


@njit(cache=True)
def _gather(product, shares, rows, columns, found):  # type: ignore[no-untyped-def]
    half = shares.shape[0] // 2
    for j in range(rows.size):
        for i in range(columns.size):
            total = 0.0j
            for b in range(-half, half + 1):
                for a in range(-half, half + 1):
                    if shares[b + half, a + half] > 0.0:
                        value = product[abs(rows[j] - b), abs(columns[i] - a)]
                        total += shares[b + half, a + half] * value
            found[j, i] += total

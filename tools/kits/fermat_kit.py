"""Echoes of buried bodies by a ray model that shares no formula with the imaging.

The delay of a path is the least over all places where it can cross the surface (Fermat's
principle), found numerically. A sphere or cylinder reflects where both rays meet its surface at
equal angles; a disc is many small reflectors.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis.dataset import ATTRIBUTES, S21_DIMS, SAMPLE_DIMS

# Each step of the search leaves 0.618 of the interval: 1e-9 of the distance at the end, and the
# delay differs from the least by the square of that.
SEARCH_STEPS = 44
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
REFLECTION_STEPS = 12
SPACING_M = 0.012


class Body(enum.Enum):
    """What is buried."""

    POINT = "point"
    SPHERE = "sphere"
    CYLINDER = "cylinder"
    DISC = "disc"


@dataclass(frozen=True)
class Buried:
    """A body in the soil.

    Attributes:
        body: Its shape; the axis of a cylinder is horizontal, a disc is level.
        x_m: Centre along X [m].
        y_m: Centre along Y [m].
        top_m: Depth of its highest point [m].
        radius_m: Radius [m].
        length_m: Length of a cylinder [m].
        direction_rad: Direction of a cylinder's axis, from X towards Y [rad].
        strength: Its echo.
    """

    body: Body
    x_m: float
    y_m: float
    top_m: float
    radius_m: float = 0.0
    length_m: float = 0.0
    direction_rad: float = 0.0
    strength: float = 1.0


@dataclass(frozen=True)
class Setup:
    """How a scene is surveyed.

    Attributes:
        x_m: Positions along X [m].
        y_m: Positions along Y [m].
        height_m: Height of the antennas (y, x) [m].
        frequency_hz: Sweep [Hz].
        separation_m: Distance between the antennas, along their rotation [m].
        rotations_deg: Polarizations [deg].
        pattern: Each antenna's pattern is the cosine of the angle to the vertical to this power.
    """

    x_m: np.ndarray
    y_m: np.ndarray
    height_m: np.ndarray
    frequency_hz: np.ndarray
    separation_m: float = 0.0
    rotations_deg: Tuple[float, ...] = (0.0, 90.0)
    pattern: float = 1.0


def crossing(
    height_m: np.ndarray, depth_m: np.ndarray, distance_m: np.ndarray, permittivity: float
) -> Tuple[np.ndarray, np.ndarray]:
    """Return the optical length of the shortest path, and the horizontal part of it in air [m]."""

    def optical_m(across_m: np.ndarray) -> np.ndarray:
        soil_m = np.hypot(depth_m, distance_m - across_m)
        return np.hypot(height_m, across_m) + np.sqrt(permittivity) * soil_m

    low_m = np.zeros(np.shape(distance_m + height_m + depth_m))
    high_m = low_m + distance_m
    for _ in range(SEARCH_STEPS):
        width_m = GOLDEN * (high_m - low_m)
        left = optical_m(high_m - width_m) < optical_m(low_m + width_m)
        low_m, high_m = (
            np.where(left, low_m, high_m - width_m),
            np.where(left, low_m + width_m, high_m),
        )
    across_m = (low_m + high_m) / 2.0
    return optical_m(across_m), across_m


def reflection_m(
    antennas_m: Sequence[np.ndarray], buried: Buried, permittivity: float
) -> np.ndarray:
    """Return the optical length of the path from one antenna to the body and to the other [m].

    Args:
        antennas_m: Places (..., 3) of the two antennas, z upwards from the surface.
        buried: Sphere or cylinder, reflecting where the angles to its surface are equal.
        permittivity: Of the soil.
    """
    along = np.array([np.cos(buried.direction_rad), np.sin(buried.direction_rad), 0.0])
    centre_m = np.array([buried.x_m, buried.y_m, -buried.top_m - buried.radius_m])
    shape = np.broadcast(*antennas_m).shape
    axis_m = np.broadcast_to(centre_m, shape)
    place_m = axis_m + np.array([0.0, 0.0, buried.radius_m])
    for _ in range(REFLECTION_STEPS):
        total = np.zeros(shape)
        across_m = []
        for antenna_m in antennas_m:
            away_m = antenna_m - place_m
            distance_m = np.hypot(away_m[..., 0], away_m[..., 1])
            _, air_m = crossing(antenna_m[..., 2], -place_m[..., 2], distance_m, permittivity)
            part = 1.0 - air_m / np.maximum(distance_m, 1e-9)
            entry_m = np.stack(
                [place_m[..., 0] + part * away_m[..., 0], place_m[..., 1] + part * away_m[..., 1],
                 np.zeros(shape[:-1])], axis=-1)  # fmt: skip
            across_m.append(entry_m)
            ray_m = entry_m - place_m
            total = total + ray_m / np.linalg.norm(ray_m, axis=-1, keepdims=True)
        if buried.length_m > 0.0:
            middle_m = 0.5 * (across_m[0] + across_m[1]) - centre_m
            shift_m = np.clip(middle_m @ along, -buried.length_m / 2.0, buried.length_m / 2.0)
            axis_m = centre_m + shift_m[..., None] * along
            ends = np.abs(shift_m) < buried.length_m / 2.0
            total = np.where(ends[..., None], total - (total @ along)[..., None] * along, total)
        normal = total / np.linalg.norm(total, axis=-1, keepdims=True)
        place_m = axis_m + buried.radius_m * normal
    return _via_m(antennas_m, place_m, permittivity)


def _via_m(
    antennas_m: Sequence[np.ndarray], place_m: np.ndarray, permittivity: float
) -> np.ndarray:
    total_m = np.zeros(place_m.shape[:-1])
    for antenna_m in antennas_m:
        away_m = antenna_m - place_m
        distance_m = np.hypot(away_m[..., 0], away_m[..., 1])
        total_m = (
            total_m + crossing(antenna_m[..., 2], -place_m[..., 2], distance_m, permittivity)[0]
        )
    return total_m


def _paths_m(antennas_m: Sequence[np.ndarray], buried: Buried, permittivity: float) -> np.ndarray:
    """Return the optical lengths of all paths (path, ...) [m]; a disc is many small reflectors."""
    if buried.body in (Body.SPHERE, Body.CYLINDER):
        return reflection_m(antennas_m, buried, permittivity)[None]
    places_m = [(0.0, 0.0)]
    rings = int(np.ceil(buried.radius_m / SPACING_M)) if buried.body is Body.DISC else 0
    for ring in range(1, rings + 1):
        angle_rad = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring)
        ring_m = buried.radius_m * ring / rings
        places_m += list(zip(ring_m * np.cos(angle_rad), ring_m * np.sin(angle_rad)))
    shape = antennas_m[0].shape
    paths_m = [
        _via_m(
            antennas_m,
            np.broadcast_to([buried.x_m + x_m, buried.y_m + y_m, -buried.top_m], shape),
            permittivity,
        )
        for x_m, y_m in places_m
    ]
    return np.stack(paths_m)


def s21_of(bodies: Sequence[Buried], permittivity: float, setup: Setup) -> np.ndarray:
    """Return the echoes of all bodies (polarization, y, x, frequency), without noise."""
    grid_y, grid_x = np.meshgrid(setup.y_m, setup.x_m, indexing="ij")
    shape = (len(setup.rotations_deg), *grid_x.shape)
    s21 = np.zeros((*shape, len(setup.frequency_hz)), dtype=np.complex128)
    for turn, rotation_deg in enumerate(setup.rotations_deg):
        half_m = setup.separation_m / 2.0 * np.exp(1j * np.radians(rotation_deg))
        antennas_m = [
            np.stack([grid_x + side * half_m.real, grid_y + side * half_m.imag, setup.height_m], -1)
            for side in (1.0, -1.0)
        ]
        for buried in bodies:
            paths_m = _paths_m(antennas_m, buried, permittivity)
            # Spreading each way, and an antenna pattern.
            slant_m = np.hypot(
                np.hypot(grid_x - buried.x_m, grid_y - buried.y_m), setup.height_m + buried.top_m
            )
            cosine = (setup.height_m + buried.top_m) / slant_m
            one_way = 0.1 / slant_m * cosine**setup.pattern
            level = buried.strength * one_way**2 / len(paths_m)
            for path_m in paths_m:
                turns = path_m[..., None] / speed_of_light * setup.frequency_hz
                s21[turn] += level[..., None] * np.exp(-2j * np.pi * turns)
    return s21


def survey_of(s21: np.ndarray, setup: Setup) -> xr.Dataset:
    """Return the Dataset of a survey."""
    shape = s21.shape[:-1]
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21),
            "height": (SAMPLE_DIMS, np.broadcast_to(setup.height_m, shape)),
            "quality": (SAMPLE_DIMS, np.zeros(shape, dtype=np.uint8)),
        },
        {
            "polarization": ("polarization", list(setup.rotations_deg), ATTRIBUTES["polarization"]),
            "y": ("y", setup.y_m, ATTRIBUTES["y"]),
            "x": ("x", setup.x_m, ATTRIBUTES["x"]),
            "frequency": ("frequency", setup.frequency_hz, ATTRIBUTES["frequency"]),
        },
        {"simulated": True, "missing": [], "faults": [], "notes": []},
    )


def noise(random: np.random.Generator, shape: Tuple[int, ...]) -> np.ndarray:
    """Return complex white noise of mean square 1."""
    parts = random.standard_normal((*shape, 2)) / np.sqrt(2.0)
    return parts[..., 0] + 1j * parts[..., 1]

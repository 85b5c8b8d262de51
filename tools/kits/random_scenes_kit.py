"""Random surveys over buried bodies, and over nothing, to judge estimates by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Tuple

import numpy as np
import xarray as xr
from fermat_kit import Body, Buried, Setup, noise, s21_of, survey_of
from scipy.constants import speed_of_light

START_HZ, STOP_HZ = 600e6, 6e9
EDGE_M = 0.08


@dataclass(frozen=True)
class RandomScene:
    """A survey and the truth about it.

    Attributes:
        survey: Its Dataset, without coupling and surface echo.
        permittivity: Relative permittivity of the soil.
        separation_m: Distance of the antennas [m].
    """

    survey: xr.Dataset
    permittivity: float
    separation_m: float


def random_scene(seed: int) -> RandomScene:
    """Return a scene with one to three bodies.

    Permittivity 3 to 12, antennas 0 to 0.15 m apart and 0.08 to 0.25 m high, tops at 0.04 to
    0.2 m, radii 0.01 to 0.05 m, noise 0 to 30 dB below the strongest echo, antenna patterns from
    nearly isotropic to narrow. Most surveys are grids; some are one line or have uneven spacing.
    Under one line there are no cylinders: one that the line crosses obliquely looks like another
    permittivity.

    Args:
        seed: Start of the random numbers.
    """
    random = np.random.default_rng(seed)
    permittivity = float(random.uniform(3.0, 12.0))
    separation_m = float(random.choice([0.0, random.uniform(0.02, 0.15)]))
    grid = str(random.choice(["grid", "line", "uneven"], p=[0.6, 0.2, 0.2]))
    bodies = tuple(body for body in Body if grid != "line" or body is not Body.CYLINDER)
    x_m, y_m = _positions(random, grid)
    height_m = np.full((len(y_m), len(x_m)), random.uniform(0.08, 0.25))
    if random.random() < 0.3:
        height_m += random.normal(0.0, 0.003, height_m.shape)
    snr_db = float(random.uniform(0.0, 30.0))
    count = int(random.integers(1, 4))
    buried = tuple(_buried(random, bodies, x_m, y_m) for _ in range(count))
    frequency_hz = np.linspace(START_HZ, STOP_HZ, int(random.choice([101, 201, 301])))
    setup = Setup(
        x_m, y_m, height_m, frequency_hz, separation_m, pattern=float(random.uniform(0.3, 2.5))
    )
    s21 = s21_of(buried, permittivity, setup)
    level = float(np.abs(s21).max()) * 10.0 ** (-snr_db / 20.0)
    s21 += level * noise(random, s21.shape)
    survey = survey_of(s21, setup)
    return RandomScene(survey, permittivity, separation_m)


def _positions(random: np.random.Generator, grid: str) -> Tuple[np.ndarray, np.ndarray]:
    width_m, depth_m = random.uniform(0.35, 0.6), random.uniform(0.3, 0.5)
    step_m = float(random.choice([0.01, 0.015, 0.02]))
    if grid == "line":
        return np.arange(0.0, 1.3 * width_m, step_m), np.array([0.2])
    if grid == "uneven":
        x_m, y_m = (
            np.sort(random.uniform(0.0, size_m, int(size_m / 0.015)))
            for size_m in (width_m, depth_m)
        )
        return x_m, y_m
    return np.arange(0.0, width_m, step_m), np.arange(0.0, depth_m, step_m)


def _buried(
    random: np.random.Generator, bodies: Tuple[Body, ...], x_m: np.ndarray, y_m: np.ndarray
) -> Buried:
    body = bodies[int(random.integers(len(bodies)))]
    aside_m = float(random.uniform(-0.04, 0.04))
    return Buried(
        body,
        float(random.uniform(x_m[0] + EDGE_M, x_m[-1] - EDGE_M)),
        y_m[0] + aside_m
        if len(y_m) == 1
        else float(random.uniform(y_m[0] + EDGE_M, y_m[-1] - EDGE_M)),
        float(random.uniform(0.04, 0.2)),
        0.0 if body is Body.POINT else float(random.uniform(0.01, 0.05)),
        float(random.uniform(0.05, 0.2)) if body is Body.CYLINDER else 0.0,
        float(random.uniform(0.0, np.pi)),
        float(random.uniform(0.4, 1.0)),
    )


class Clutter:
    """Kinds of surveys in which nothing is buried."""

    WHITE = "white"
    OVER_FREQUENCY = "correlated over the frequency"
    OVER_PLACE = "correlated over the place"
    ROWS = "common to rows and columns"
    SURFACE = "residue of the surface"
    ALL = (WHITE, OVER_FREQUENCY, OVER_PLACE, ROWS, SURFACE)


def random_noise(seed: int, kind: str) -> xr.Dataset:
    """Return a survey of noise alone, of random size, band and height.

    Args:
        seed: Start of the random numbers.
        kind: One of Clutter.ALL.
    """
    random = np.random.default_rng(seed)
    columns, rows = int(random.integers(8, 50)), int(random.choice([1, random.integers(8, 40)]))
    step_m = float(random.choice([0.01, 0.015, 0.02]))
    frequency_hz = np.linspace(
        float(random.choice([0.6e9, 1e9])),
        float(random.choice([3e9, 6e9])),
        int(random.choice([51, 101, 201])),
    )
    height_m = np.full((rows, columns), random.uniform(0.05, 0.3))
    setup = Setup(step_m * np.arange(columns), step_m * np.arange(rows), height_m, frequency_hz)
    parts: List[np.ndarray] = []
    for _ in setup.rotations_deg:
        one = noise(random, (rows, columns, len(frequency_hz)))
        if kind == Clutter.OVER_FREQUENCY:
            one = _over_frequency(random, one, frequency_hz)
        if kind == Clutter.OVER_PLACE:
            one = _over_place(random, one)
        if kind == Clutter.ROWS:
            one += random.uniform(0.0, 3.0) * noise(random, (rows, 1, len(frequency_hz)))
            one += random.uniform(0.0, 3.0) * noise(random, (1, columns, len(frequency_hz)))
        if kind == Clutter.SURFACE:
            one += _surface(random, setup)
        parts.append(one)
    return survey_of(np.stack(parts), setup)


def _over_frequency(
    random: np.random.Generator, one: np.ndarray, frequency_hz: np.ndarray
) -> np.ndarray:
    """Return noise whose energy lies around one delay."""
    turn = np.exp(-2j * np.pi * (frequency_hz[1] - frequency_hz[0]) * random.uniform(0.0, 5e-9))
    keep = random.uniform(0.3, 0.98) * turn
    for index in range(1, one.shape[-1]):
        one[..., index] += keep * one[..., index - 1]
    return one


def _over_place(random: np.random.Generator, one: np.ndarray) -> np.ndarray:
    """Return noise that is alike at neighbouring places."""
    width = random.uniform(0.3, 4.0)
    for axis in (0, 1):
        place = np.arange(one.shape[axis])
        weights = np.exp(-((place[:, None] - place[None, :]) ** 2) / (2.0 * width**2))
        one = np.moveaxis(np.tensordot(weights, one, axes=(1, axis)), 0, axis)
    return one


def _surface(random: np.random.Generator, setup: Setup) -> np.ndarray:
    """Return the echo of a surface that rises and falls more than the recorded heights say."""
    grid_y, grid_x = np.meshgrid(setup.y_m, setup.x_m, indexing="ij")
    turns = grid_x / random.uniform(0.1, 0.6), grid_y / random.uniform(0.1, 0.6)
    wave_m = (
        random.uniform(0.0, 0.005) * np.sin(2.0 * np.pi * turns[0]) * np.cos(2.0 * np.pi * turns[1])
    )
    rough_m = random.normal(0.0, 0.0005, grid_x.shape)
    path_m = 2.0 * (setup.height_m + wave_m + rough_m)
    level = random.uniform(3.0, 100.0) * (1.0 + 0.05 * random.standard_normal(grid_x.shape))
    echo: np.ndarray = level[..., None] * np.exp(
        -2j * np.pi * path_m[..., None] * setup.frequency_hz / speed_of_light
    )
    return echo

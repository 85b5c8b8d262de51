"""Random surveys of ground in which nothing is buried."""

from __future__ import annotations

import enum
from typing import Tuple

import numpy as np
import xarray as xr
from recorded_worlds import dataset
from scipy.constants import speed_of_light


class Clutter(enum.Enum):
    """What such a survey has."""

    WHITE = "white noise"
    SURFACE = "residue of the surface"


def random_noise(seed: int, kind: Clutter) -> xr.Dataset:
    """Return a survey of random size, band and height.

    Args:
        seed: Start of the random numbers.
        kind: What it has.
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
    x_m, y_m = step_m * np.arange(columns), step_m * np.arange(rows)
    parts = random.standard_normal((rows, columns, len(frequency_hz), 2)) / np.sqrt(2.0)
    s21 = parts @ np.array([1.0, 1j])
    if kind is Clutter.SURFACE:
        path_m, level = _surface(random, x_m, y_m)
        turns = (2.0 * height_m + path_m)[..., None] * frequency_hz / speed_of_light
        s21 = s21 + level[..., None] * np.exp(-2j * np.pi * turns)
    return dataset(s21, height_m, x_m, y_m, frequency_hz)


def _surface(
    random: np.random.Generator, x_m: np.ndarray, y_m: np.ndarray
) -> Tuple[np.ndarray, np.ndarray]:
    """Return paths and levels of a surface that rises and falls more than the heights say."""
    grid_y, grid_x = np.meshgrid(y_m, x_m, indexing="ij")
    turns = grid_x / random.uniform(0.1, 0.6), grid_y / random.uniform(0.1, 0.6)
    wave_m = (
        random.uniform(0.0, 0.005) * np.sin(2.0 * np.pi * turns[0]) * np.cos(2.0 * np.pi * turns[1])
    )
    rough_m = random.normal(0.0, 0.0005, grid_x.shape)
    level = random.uniform(3.0, 100.0) * (1.0 + 0.05 * random.standard_normal(grid_x.shape))
    return 2.0 * (wave_m + rough_m), level

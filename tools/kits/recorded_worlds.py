"""Radar data that the project's imaging did not make, as Datasets, with what is in the ground.

Lines and areas were computed from Maxwell's equations, those named born and the discs by an
integral over the body in place of a grid over the ground, those named gprmax by the program of that
name; the real line was measured (benchmarks/worlds/data/README.md).
"""

from __future__ import annotations

import hashlib
import json
import os
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis.dataset import S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.sample import REAL_LINE_FILE

DATA = Path(__file__).resolve().parents[2] / "benchmarks/worlds/data"
LINES, AREAS, UNIANDES, REAL_LINE = "lines", "areas", "uniandes", "real_line_charisma"
BORN, DISCS, GPRMAX = "born", "discs", "gprmax"
# Of the largest value, which is the coupling of the antennas: a usual analyzer's.
NOISE_DB = -65.0
LARGEST_PART = 32767.0


def dataset(
    s21: np.ndarray, height_m: Any, x_m: np.ndarray, y_m: np.ndarray, frequency_hz: np.ndarray
) -> xr.Dataset:
    """Return spectra (y, x, frequency) of one polarization as a survey."""
    shape = (1, *s21.shape[:2])
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21[None]),
            "height": (SAMPLE_DIMS, np.broadcast_to(height_m, shape).astype(np.float64)),
            "quality": (SAMPLE_DIMS, np.zeros(shape, dtype=np.uint8)),
        },
        {"polarization": [0.0], "y": y_m, "x": x_m, "frequency": frequency_hz},
        {"missing": [], "faults": [], "notes": []},
    )


@lru_cache(maxsize=None)
def _arrays(name: str) -> Dict[str, Any]:
    path = REAL_LINE_FILE if name == REAL_LINE else DATA / f"{name}.npz"
    lines = (DATA / "SHA256SUMS").read_text(encoding="ascii").splitlines()
    if (
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {os.path.relpath(path, DATA)}"
        not in lines
    ):
        raise ValueError(f"{path} is not the file that SHA256SUMS names; take it from git again")
    with np.load(path) as file:
        return {key: file[key] for key in file}


def truths(name: str) -> List[Dict[str, Any]]:
    """Return what is in the ground of each scene of a file."""
    found: List[Dict[str, Any]] = json.loads(str(_arrays(name)["truth"]))
    return found


def line(number: int, name: str = LINES) -> Tuple[xr.Dataset, Dict[str, Any]]:
    """Return a computed line, and its truth; those of gprMax have one height."""
    arrays, truth = _arrays(name), truths(name)[number]
    s21 = _noisy(arrays, number)[None]
    x_m, frequency_hz = arrays["x_m"][number], arrays["frequency_hz"][number]
    height_m = arrays["height_m"][number] if name == LINES else truth["height_m"]
    return dataset(s21, height_m, x_m, np.zeros(1), frequency_hz), truth


def area(name: str, number: int) -> Tuple[xr.Dataset, Dict[str, Any]]:
    """Return a computed area, and its truth."""
    arrays, truth = _arrays(name), truths(name)[number]
    x_m = arrays["x_m"][number]
    s21 = _noisy(arrays, number)
    return dataset(s21, truth["height_m"], x_m, x_m, arrays["frequency_hz"][number]), truth


def disc(target: str, top_m: float) -> Tuple[np.ndarray, np.ndarray]:
    """Return the echo of a disc below the middle of 41 x 41 positions (y, x, frequency), alone.

    And coupling and surface echo at each position (frequency). The quarter that is stored is
    mirrored: the two antennas change places.

    Args:
        target: Its size and permittivity, as `target_of` reads them.
        top_m: Depth of its top [m].
    """
    arrays = _arrays(DISCS)
    (number,) = (
        place
        for place, one in enumerate(truths(DISCS))
        if (one["target"], one["top_m"]) == (target, top_m)
    )
    quarter = arrays["s21"][number] @ np.array([1.0, 1j]) * arrays["largest"][number] / LARGEST_PART
    half = np.concatenate([quarter[:0:-1], quarter])
    return np.concatenate([half[:, :0:-1], half], axis=1), arrays["level"] @ np.array([1.0, 1j])


def _noisy(arrays: Dict[str, Any], number: int) -> np.ndarray:
    parts = arrays["s21"][number] / LARGEST_PART
    if "level" in arrays:
        parts += arrays["level"][number] / LARGEST_PART
    random = np.random.default_rng([31, number])
    noise = random.standard_normal(parts.shape) / np.sqrt(2.0) * 10.0 ** (NOISE_DB / 20.0)
    found: np.ndarray = (parts + noise) @ np.array([1.0, 1j])
    return found


def real_line() -> Tuple[xr.Dataset, np.ndarray]:
    """Return the real line as spectra from 0.5 to 3 GHz, and where its bars are [m].

    Not recorded, and assumed: time zero at the first positive peak, antennas at 10 mm.
    """
    arrays = _arrays(REAL_LINE)
    samples = arrays["a_scans"].astype(np.float64)
    time_s = arrays["time_s"].astype(np.float64)
    samples -= samples[:, 5:75].mean(axis=1, keepdims=True)
    samples[:, -64:] *= 0.5 * (1.0 + np.cos(np.pi * np.arange(64) / 64))
    start_s = time_s[int(np.median(np.argmax(samples[:, :200], axis=1)))]
    zero_s = start_s - 2.0 * 0.01 / speed_of_light
    # As fine as a record of 8 ns is.
    frequency_hz = np.arange(0.5e9, 3.0001e9, 125e6)
    s21 = samples @ np.exp(-2j * np.pi * np.outer(time_s - zero_s, frequency_hz))
    x_m = np.linspace(arrays["x_m"][0], arrays["x_m"][-1], len(samples)).astype(np.float64)
    return dataset(s21[None], 0.01, x_m, np.zeros(1), frequency_hz), arrays["rebar_x_m"]

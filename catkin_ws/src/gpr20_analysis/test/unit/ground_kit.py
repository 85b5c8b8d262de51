"""Surveys computed from a scene by the simulator's ground, without a robot.

The simulator finds its refracted paths by itself, so agreement with the imaging is no tautology.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Callable, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import ATTRIBUTES, S21_DIMS, SAMPLE_DIMS
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Antennas, Noise, Scene, Shape, Soil, Target, read_scene

SCENES = Path(__file__).resolve().parents[3] / "gpr20_simulator" / "scenes"
IMAGING_SCENE = read_scene(str(SCENES / "imaging_targets.yaml"))
GRID_MM = np.linspace(60.0, 420.0, 25)
FREQUENCY_HZ = np.linspace(600e6, 6e9, 101)


def dataset_of(
    s21: np.ndarray, height_m: np.ndarray, rotations_deg: Sequence[float], *axes: np.ndarray
) -> xr.Dataset:
    """Return spectra as a survey; the other axes are y and x [m] and the frequency [Hz]."""
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21),
            "height": (SAMPLE_DIMS, height_m),
            "quality": (SAMPLE_DIMS, np.zeros(height_m.shape, dtype=np.uint8)),
        },
        {
            name: (name, np.asarray(values, dtype=float), ATTRIBUTES[name])
            for name, values in zip(S21_DIMS, (rotations_deg, *axes))
        },
        {"missing": [], "faults": [], "notes": []},
    )


def point(x_mm: float, y_mm: float, depth_m: float, strength: float = 0.05) -> Target:
    """Return a target that is as small as one can be."""
    return Target("point", Shape.SPHERE, x_mm, y_mm, depth_m, 0.001, 0.0, strength, strength)


def scene(
    targets: Sequence[Target],
    permittivity: float = 4.0,
    noise_db: float = -110.0,
    **antennas: float,
) -> Scene:
    """Return a level scene without loss."""
    return Scene(
        soil=Soil(permittivity, 0.0),
        antennas=Antennas(**antennas),
        targets=tuple(targets),
        noise=Noise(noise_db),
    )


def survey_of(
    ground: Scene,
    x_mm: np.ndarray = GRID_MM,
    y_mm: np.ndarray = GRID_MM,
    frequency_hz: np.ndarray = FREQUENCY_HZ,
    rotations_deg: Sequence[float] = (0.0, 90.0),
    height_m: Optional[Callable[[float, float], float]] = None,
) -> xr.Dataset:
    """Return the Dataset of a survey over a scene, with the true heights.

    Args:
        ground: The scene.
        x_mm: Positions along X [mm].
        y_mm: Positions along Y [mm].
        frequency_hz: Sweep [Hz].
        rotations_deg: Polarizations [deg].
        height_m: Height of the antennas at (x, y) [mm]; default the scene's.
    """
    medium = Ground(ground)
    shape = (len(rotations_deg), len(y_mm), len(x_mm))
    s21 = np.empty((*shape, len(frequency_hz)), dtype=np.complex128)
    heights_m = np.empty(shape)
    for number, index in enumerate(np.ndindex(*shape)):
        place = AntennaPosition(x_mm[index[2]], y_mm[index[1]], rotations_deg[index[0]])
        if height_m is not None:
            lifted = replace(ground.antennas, height_m=height_m(place.x_mm, place.y_mm))
            # Each Ground starts its noise from the seed.
            noise = replace(ground.noise, seed=ground.noise.seed + number)
            medium = Ground(replace(ground, antennas=lifted, noise=noise))
        s21[index] = medium.s21(frequency_hz, place, 0)
        heights_m[index] = medium.antenna_height_m(place.x_mm, place.y_mm)
    y_m, x_m = (np.asarray(one) / 1000.0 for one in (y_mm, x_mm))
    found = dataset_of(s21, heights_m, rotations_deg, y_m, x_m, frequency_hz)
    return found.assign_attrs(simulated=True)

"""How well the delay of cables and antennas is fitted on random scenes, by `gpr20 delay`.

Usage: scripts/bench.sh antenna_delay [--scenes 1000]

Each scene has its own soil, delay, heights, antenna separation, coupling, noise and targets, and is
computed by the simulator's ground. The recorded heights have the noise of a sensor.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import List, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.surface_echo import SurfaceFit, fit_delay
from gpr20_simulator.mid.ground import Ground
from gpr20_simulator.mid.medium import AntennaPosition
from gpr20_simulator.mid.scene import Antennas, Noise, Scene, Shape, Soil, Target

FREQUENCY_HZ = np.linspace(600e6, 6e9, 201)
ALONG_MM = (100.0, 300.0)
PS, GROSS_S = 1e12, 100e-12
HEAD = """\
| heights vary by at most | scenes | refused | within uncertainty | median error | over 100 ps off |
| --- | --- | --- | --- | --- | --- |"""


def random_scene(random: np.random.Generator) -> Scene:
    targets = []
    for number in range(random.integers(0, 4)):
        x_mm, y_mm = random.uniform(*ALONG_MM, 2)
        strength = random.uniform(0.02, 0.1)
        depth_m = random.uniform(0.03, 0.2)
        targets.append(
            Target(str(number), Shape.SPHERE, x_mm, y_mm, depth_m, 0.001, 0.0, strength, strength)
        )
    antennas = Antennas(
        height_m=random.uniform(0.1, 0.3),
        separation_m=float(random.choice([0.0, 0.06, 0.12])),
        coupling_level_db=random.uniform(-60.0, -15.0),
        delay_s=float(random.choice([0.0, 0.3e-9, random.uniform(0.0, 2e-9)])),
    )
    noise = Noise(float(random.choice([-110, -80, -60, -50])), int(random.integers(2**31 - 1)))
    return Scene(
        soil=Soil(random.uniform(2.0, 16.0), 0.0),
        antennas=antennas,
        targets=tuple(targets),
        noise=noise,
    )


def survey(scene: Scene, rise_m: float, random: np.random.Generator) -> xr.Dataset:
    rows = int(random.choice([1, 5, 9]))
    x_mm = np.linspace(*ALONG_MM, 25 if rows == 1 else 9)
    y_mm = np.linspace(*ALONG_MM, rows) if rows > 1 else np.array([200.0])
    shares = rise_m * random.uniform(-1.0, 1.0, 3)
    sensor_m = float(random.choice([0.0, 0.002, 0.004]))
    s21 = np.empty((1, rows, len(x_mm), len(FREQUENCY_HZ)), dtype=np.complex128)
    height_m = np.empty(s21.shape[:3])
    for place in np.ndindex(*height_m.shape):
        x, y = x_mm[place[2]], y_mm[place[1]]
        rise = shares @ (np.sin(x / 40.0), np.cos(y / 35.0), (x - 200.0) / 100.0)
        height_m[place] = scene.antennas.height_m + rise
        lifted = replace(scene.antennas, height_m=height_m[place])
        noise = replace(scene.noise, seed=int(random.integers(2**31 - 1)))
        ground = Ground(replace(scene, antennas=lifted, noise=noise))
        s21[place] = ground.s21(FREQUENCY_HZ, AntennaPosition(x, y, 0.0), 0)
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21),
            "height": (SAMPLE_DIMS, height_m + sensor_m * random.standard_normal(height_m.shape)),
            "quality": (SAMPLE_DIMS, np.zeros(height_m.shape, dtype=np.uint8)),
        },
        {
            "polarization": [0.0],
            "y": y_mm / 1000.0,
            "x": x_mm / 1000.0,
            "frequency": FREQUENCY_HZ,
        },
    )


def fitted(scene: Scene, data: xr.Dataset) -> Optional[SurfaceFit]:
    try:
        return fit_delay(data, scene.antennas.separation_m)
    except WrongDatasetError:
        return None


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=1000)
    chosen = parser.parse_args()
    print(HEAD)
    for rise_m in (0.0, 0.005, 0.02):
        results: List[Tuple[float, float]] = []
        count = chosen.scenes // 3
        for seed in range(count):
            random = np.random.default_rng([seed, int(1000 * rise_m)])
            scene = random_scene(random)
            fit = fitted(scene, survey(scene, rise_m, random))
            if fit is not None:
                results.append((abs(fit.delay_s - scene.antennas.delay_s), fit.uncertainty_s))
        errors_s, allowed_s = np.array(results).T
        print(
            f"| ±{3e3 * rise_m:.0f} mm | {count} | {count - len(results)} "
            f"| {np.mean(errors_s <= allowed_s):.1%} | {PS * np.median(errors_s):.1f} ps "
            f"| {np.count_nonzero(errors_s > GROSS_S)} |"
        )


if __name__ == "__main__":
    main()

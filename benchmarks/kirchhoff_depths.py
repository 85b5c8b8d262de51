"""Where the Kirchhoff method of the GPR-20 group puts targets in depth, by the points of the sweep.

Usage: scripts/bench.sh kirchhoff_depths [--targets 20] [--points 501 401 201 301]

Each target lies alone, at a random place off the grid, below 31 x 31 positions of 10 mm step, at
permittivity 4. For some numbers of points the group's program drops the first time sample. The
depth is that of the brightest voxel within 40 mm of the target, refined by a parabola.
"""

from __future__ import annotations

import argparse

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.kirchhoff import GroupTime
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_survey.radar.refraction import one_way_delay_s

PLACE_M = 0.010 * np.arange(31)
HEIGHT_M, PERMITTIVITY, NEAR_M = 0.20, 4.0, 0.04


def survey(target_m: np.ndarray, frequency_hz: np.ndarray) -> xr.Dataset:
    across_m = np.hypot(PLACE_M[None, :] - target_m[0], PLACE_M[:, None] - target_m[1])
    delay_s = 2.0 * one_way_delay_s(HEIGHT_M, target_m[2], across_m, PERMITTIVITY)[None, ..., None]
    s21 = (delay_s.min() / delay_s) ** 2 * np.exp(-2j * np.pi * frequency_hz * delay_s)
    shape = s21.shape[:-1]
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21),
            "height": (SAMPLE_DIMS, np.full(shape, HEIGHT_M)),
            "quality": (SAMPLE_DIMS, np.zeros(shape, dtype=np.uint8)),
        },
        {"polarization": [0.0], "y": PLACE_M, "x": PLACE_M, "frequency": frequency_hz},
    )


def depth_of(image: xr.Dataset, target_m: np.ndarray) -> float:
    level = image.image.values[0]
    near = (
        (abs(image.x.values[None, None, :] - target_m[0]) < NEAR_M)
        & (abs(image.y.values[None, :, None] - target_m[1]) < NEAR_M)
        & (abs(image.depth.values[:, None, None] - target_m[2]) < NEAR_M)
    )
    row, y, x = np.unravel_index(np.argmax(np.where(near, level, -1.0)), level.shape)
    above, here, below = level[np.clip([row - 1, row, row + 1], 0, len(level) - 1), y, x]
    bend = 2.0 * here - above - below
    more = 0.5 * (below - above) / bend if bend > 0.0 else 0.0
    return float(image.depth[row] + more * (image.depth[1] - image.depth[0]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--targets", type=int, default=20)
    parser.add_argument("--points", type=int, nargs="+", default=[501, 201, 401, 301])
    chosen = parser.parse_args()
    print("points  samples dropped  mean depth error mm  standard error mm")
    for points in chosen.points:
        frequency_hz = np.linspace(600e6, 6e9, points)
        random = np.random.default_rng(4)
        errors_mm = []
        for _ in range(chosen.targets):
            target_m = random.uniform((0.1, 0.1, 0.05), (0.2, 0.2, 0.18))
            options = ImageOptions(Method.KIRCHHOFF, PERMITTIVITY, (0.0, 0.26))
            image = image_survey(survey(target_m, frequency_hz), options)
            errors_mm.append(1e3 * (depth_of(image, target_m) - target_m[2]))
        step_hz = float(frequency_hz[1] - frequency_hz[0])
        dropped = GroupTime.of(FrequencyGrid(600e6, step_hz, points)).dropped
        spread = np.std(errors_mm) / np.sqrt(len(errors_mm))
        print(f"{points:6} {dropped:16} {np.mean(errors_mm):+20.1f} {spread:18.1f}")


if __name__ == "__main__":
    main()

"""Images of surveys whose heights differ: clutter of the surface and echoes of targets.

Usage: scripts/bench.sh imaging_heights [--seeds 5] [--noise-mm 1]

Two point targets, 25 dB below the surface echo, under 25 x 25 positions of 15 mm step, permittivity
4, 101 frequencies, receiver noise at -90 dB, noise in the recorded heights. Antennas at random
heights above level ground, on a tilted scanner, or in a plane above uneven ground. Levels are
relative to the weaker target of the survey with equal heights.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Callable, Dict, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_simulator.mid.ground import Ground as SimulatedGround
from gpr20_simulator.mid.scene import Scene, Surface

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "catkin_ws/src/gpr20_analysis/test/unit"))

from ground_kit import point, scene, survey_of  # noqa: E402

TARGETS = (point(173.3, 181.7, 0.1134, 0.01), point(318.9, 307.4, 0.0711, 0.01))
SCENE = scene(TARGETS, noise_db=-90.0)
GRID_STEP_M = 0.005
SHALLOW_M = 0.03


def surveys(random: np.random.Generator) -> Dict[str, Tuple[xr.Dataset, Scene]]:
    """Return surveys by name, and what is below them."""

    def lifted(height_m: Callable[[float, float], float]) -> Tuple[xr.Dataset, Scene]:
        return survey_of(SCENE, rotations_deg=(0.0,), height_m=height_m), SCENE

    def above(surface: Surface) -> Tuple[xr.Dataset, Scene]:
        uneven = replace(SCENE, surface=surface)
        return survey_of(uneven, rotations_deg=(0.0,)), uneven

    return {
        "equal": lifted(lambda x, y: 0.2),
        "antennas +-2 mm": lifted(lambda x, y: 0.2 + random.uniform(-0.002, 0.002)),
        "antennas +-10 mm": lifted(lambda x, y: 0.2 + random.uniform(-0.01, 0.01)),
        "antennas +-20 mm": lifted(lambda x, y: 0.2 + random.uniform(-0.02, 0.02)),
        "scanner tilted, 40 mm": lifted(lambda x, y: 0.2 + 0.04 * (x - 240.0) / 360.0),
        "ground, wave +-5 mm": above(Surface(0.0, 0.0, 0.005, 0.4)),
        "ground, wave +-10 mm": above(Surface(0.0, 0.0, 0.01, 0.4)),
        "ground, wave +-20 mm": above(Surface(0.0, 0.0, 0.02, 0.4)),
    }


def figures(image: xr.Dataset, ground: Scene) -> Tuple[float, float, float, float]:
    """Return the weaker target's level [dB], its error [mm], shallow and deep clutter [dB]."""
    level = 20.0 * np.log10(abs(image.image[0]))
    elsewhere, levels, errors_mm = level, [], []
    for target in TARGETS:
        across_m = np.hypot(image.x - target.x_mm / 1e3, image.y - target.y_mm / 1e3)
        depth_m = target.depth_m
        depth_m += SimulatedGround(ground).surface_height_m(target.x_mm, target.y_mm)
        down_m = abs(image.depth - depth_m)
        near = level.where((across_m < 0.03) & (down_m < 0.02))
        found = near.where(near == near.max(), drop=True)
        levels.append(float(near.max()))
        away_m = np.sqrt(across_m**2 + down_m**2).sel(
            x=found.x[0], y=found.y[0], depth=found.depth[0]
        )
        errors_mm.append(1e3 * float(away_m))
        elsewhere = elsewhere.where((across_m > 0.08) | (down_m > 0.06))
    shallow = float(elsewhere.where(image.depth < SHALLOW_M).max())
    return min(levels), max(errors_mm), shallow, float(elsewhere.where(image.depth > 0.03).max())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--noise-mm", type=float, default=1.0)
    chosen = parser.parse_args()
    kinds = {
        "mean, phase shift": (Background.MEAN, Method.PHASE_SHIFT, Ground.LEVEL),
        "surface, phase shift": (Background.SURFACE, Method.PHASE_SHIFT, Ground.LEVEL),
        "surface, back-projection": (Background.SURFACE, Method.BACK_PROJECTION, Ground.LEVEL),
        "surface, uneven": (Background.SURFACE, Method.BACK_PROJECTION, Ground.UNEVEN),
    }
    found: Dict[Tuple[str, str], list] = {}
    for seed in range(chosen.seeds):
        random = np.random.default_rng(seed)
        for name, (survey, ground) in surveys(random).items():
            noise_m = random.normal(0.0, chosen.noise_mm / 1e3, survey.height.shape)
            recorded = survey.assign(height=survey.height + noise_m)
            for kind, (background, method, form) in kinds.items():
                options = ImageOptions(
                    method, 4.0, ground=form, grid_step_m=GRID_STEP_M,
                    depth_m=tuple(np.arange(0.0, 0.2, 0.004)),
                )  # fmt: skip
                image = image_survey(remove_background(recorded, background), options)
                found.setdefault((name, kind), []).append(figures(image, ground))
    print("medians over the seeds: target dB, error mm, shallow clutter dB, deep clutter dB")
    for (name, kind), values in found.items():
        level, error_mm, shallow, deep = np.median(values, axis=0)
        # The two methods have scales of their own.
        zero = np.median(found["equal", kind], axis=0)[0]
        print(f"{name:24} {kind:26} {level - zero:+6.1f} {error_mm:6.1f} "
              f"{shallow - zero:+7.1f} {deep - zero:+7.1f}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()

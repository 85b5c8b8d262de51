"""How often the estimated range of the permittivity holds the truth, on random scenes.

    scripts/bench.sh permittivity [--scenes 100] [--seed 0] [--noise 50]
                                  [--grid grid|line|uneven] [--details]

The scenes are made by a ray model of their own (scripts/fermat_kit.py), not by the imaging. Every
survey is processed as `gpr20 image SURVEY` does without options: the mean of all traces is
subtracted first. `--noise` is the number of surveys without any body, of each kind; all of them
have to be refused.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from typing import Dict, List, Optional, Tuple

import numpy as np
import xarray as xr
from random_scenes_kit import Clutter, RandomScene, random_noise, random_scene

from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.image_traces import traces_of
from gpr20_analysis.imaging.permittivity_estimate import PermittivityEstimate, estimate_permittivity
from gpr20_analysis.imaging.records import Focus
from gpr20_analysis.processing.background import remove_background

Result = Tuple[RandomScene, Optional[PermittivityEstimate]]


def estimate(survey: xr.Dataset, separation_m: float) -> PermittivityEstimate:
    options = ImageOptions(separation_m=separation_m)
    traces, _ = traces_of(remove_background(survey), options)
    focus = Focus(4.0, np.asarray(options.depth_m), separation_m=separation_m)
    return estimate_permittivity(traces, focus)


def attempt(scene: RandomScene) -> Optional[PermittivityEstimate]:
    try:
        return estimate(scene.survey, scene.separation_m)
    except WrongDatasetError:
        return None


def table(results: List[Result]) -> None:
    groups: Dict[str, List[Result]] = {"all": results}
    for grid in ("grid", "uneven", "line"):
        groups[grid] = [one for one in results if one[0].grid == grid]
    for low_db in (0, 10, 20):
        groups[f"{low_db} to {low_db + 10} dB"] = [
            one for one in results if low_db <= one[0].snr_db < low_db + 10
        ]
    groups["antennas apart"] = [one for one in results if one[0].separation_m > 0.0]
    print("| scenes | number | refused | truth in the range | highest / lowest, median "
          "| error of depth, median | largest |")  # fmt: skip
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name, ones in groups.items():
        _row(name, ones)


def _row(name: str, ones: List[Result]) -> None:
    told = [(scene.permittivity, found) for scene, found in ones if found is not None]
    if not told:
        print(f"| {name} | {len(ones)} | {len(ones)} | | | | |")
        return
    held = sum(found.lowest <= truth <= found.highest for truth, found in told)
    width = np.median([found.highest / found.lowest for _, found in told])
    depth = [100.0 * abs(np.sqrt(truth / found.permittivity) - 1.0) for truth, found in told]
    print(
        f"| {name} | {len(ones)} | {len(ones) - len(told)} | {held} of {len(told)} | "
        f"{width:.2f} | {np.median(depth):.0f} % | {max(depth):.0f} % |"
    )


def _details(seed: int, scene: RandomScene, found: Optional[PermittivityEstimate]) -> None:
    told = "refused"
    if found is not None:
        held = found.lowest <= scene.permittivity <= found.highest
        told = f"{found.lowest:.2f} to {found.highest:.2f}" + ("" if held else " WRONG")
    bodies = ", ".join(
        f"{one.body.value} top {one.top_m:.3f} radius {one.radius_m:.3f} m" for one in scene.bodies
    )
    print(
        f"{seed}: {scene.permittivity:.2f}, {told}; {scene.grid}, {scene.snr_db:.0f} dB, "
        f"{scene.separation_m:.2f} m apart; {bodies}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", type=int, default=50)
    parser.add_argument("--grid", choices=("grid", "line", "uneven"), default="")
    parser.add_argument("--details", action="store_true")
    chosen = parser.parse_args()
    results: List[Result] = []
    spent_s = 0.0
    for seed in range(chosen.seed, chosen.seed + chosen.scenes):
        scene = random_scene(seed, chosen.grid)
        before_s = time.process_time()
        results.append((scene, attempt(scene)))
        spent_s += time.process_time() - before_s
        if chosen.details:
            _details(seed, *results[-1])
    table(results)
    print(f"processor time of one estimate: {spent_s / max(chosen.scenes, 1):.2f} s")
    invented: Counter[str] = Counter()
    for kind in Clutter.ALL:
        for seed in range(chosen.seed, chosen.seed + chosen.noise):
            try:
                estimate(random_noise(seed, kind), 0.0)
                invented[kind] += 1
            except WrongDatasetError:
                continue
    for kind in Clutter.ALL:
        print(f"noise, {kind}: {invented[kind]} of {chosen.noise} accepted")


if __name__ == "__main__":
    main()

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
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from typing import Dict, List, Optional

import numpy as np
import xarray as xr
from random_scenes_kit import Clutter, random_noise, random_scene

from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.image_traces import traces_of
from gpr20_analysis.imaging.permittivity_estimate import PermittivityEstimate, estimate_permittivity
from gpr20_analysis.imaging.records import Focus
from gpr20_analysis.processing.background import remove_background


@dataclass(frozen=True)
class Result:
    """A scene and what was estimated of it."""

    permittivity: float
    grid: str
    snr_db: float
    separation_m: float
    bodies: str
    found: Optional[PermittivityEstimate]
    spent_s: float

    @property
    def held(self) -> bool:
        """Whether the range holds the truth."""
        found = self.found
        return found is not None and found.lowest <= self.permittivity <= found.highest


def estimate(survey: xr.Dataset, separation_m: float) -> Optional[PermittivityEstimate]:
    options = ImageOptions(separation_m=separation_m)
    traces, _ = traces_of(remove_background(survey), options)
    focus = Focus(4.0, np.asarray(options.depth_m), separation_m=separation_m)
    try:
        return estimate_permittivity(traces, focus)
    except WrongDatasetError:
        return None


def attempt(seed: int, grid: str) -> Result:
    scene = random_scene(seed, grid)
    before_s = time.process_time()
    found = estimate(scene.survey, scene.separation_m)
    spent_s = time.process_time() - before_s
    bodies = ", ".join(
        f"{one.body.value} top {one.top_m:.3f} radius {one.radius_m:.3f} m" for one in scene.bodies
    )
    return Result(
        scene.permittivity, scene.grid, scene.snr_db, scene.separation_m, bodies, found, spent_s
    )


def invents(seed: int, kind: str) -> bool:
    return estimate(random_noise(seed, kind), 0.0) is not None


def table(results: List[Result]) -> None:
    groups: Dict[str, List[Result]] = {"all": results}
    for grid in ("grid", "uneven", "line"):
        groups[grid] = [one for one in results if one.grid == grid]
    for low_db in (0, 10, 20):
        groups[f"{low_db} to {low_db + 10} dB"] = [
            one for one in results if low_db <= one.snr_db < low_db + 10
        ]
    groups["antennas apart"] = [one for one in results if one.separation_m > 0.0]
    print("| scenes | number | refused | truth in the range | highest / lowest, median "
          "| error of depth, median | largest |")  # fmt: skip
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for name, ones in groups.items():
        _row(name, ones)


def _row(name: str, ones: List[Result]) -> None:
    accepted = [(one.permittivity, one.found) for one in ones if one.found is not None]
    if not accepted:
        print(f"| {name} | {len(ones)} | {len(ones)} | | | | |")
        return
    held = sum(one.held for one in ones)
    width = np.median([found.highest / found.lowest for _, found in accepted])
    depth = [100.0 * abs(np.sqrt(truth / found.permittivity) - 1.0) for truth, found in accepted]
    print(
        f"| {name} | {len(ones)} | {len(ones) - len(accepted)} | {held} of {len(accepted)} | "
        f"{width:.2f} | {np.median(depth):.0f} % | {max(depth):.0f} % |"
    )


def _details(seed: int, one: Result) -> None:
    answer = "refused"
    if one.found is not None:
        answer = f"{one.found.lowest:.2f} to {one.found.highest:.2f}"
        answer += "" if one.held else " WRONG"
    print(
        f"{seed}: {one.permittivity:.2f}, {answer}; {one.grid}, {one.snr_db:.0f} dB, "
        f"{one.separation_m:.2f} m apart; {one.bodies}",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", type=int, default=50)
    parser.add_argument("--grid", choices=("grid", "line", "uneven"), default="")
    parser.add_argument("--details", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    seeds = range(chosen.seed, chosen.seed + chosen.scenes)
    results: List[Result] = []
    with ProcessPoolExecutor(chosen.jobs) as pool:
        for seed, one in zip(seeds, pool.map(attempt, seeds, repeat(chosen.grid))):
            results.append(one)
            if chosen.details:
                _details(seed, one)
        if results:
            table(results)
            spent_s = np.mean([one.spent_s for one in results])
            print(f"processor time of one estimate: {spent_s:.2f} s")
        for kind in Clutter.ALL if chosen.noise else ():
            seeds = range(chosen.seed, chosen.seed + chosen.noise)
            accepted = sum(pool.map(invents, seeds, repeat(kind)))
            print(f"noise, {kind}: {accepted} of {chosen.noise} accepted", flush=True)


if __name__ == "__main__":
    main()

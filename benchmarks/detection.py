"""How many targets are found, against false candidates, and whether noise alone is kept out.

Usage: scripts/bench.sh detection [--scenes 100] [--noise-surveys 300] [--figure detection.svg]

Scenes: 25 x 25 positions of 15 mm step, two polarizations, 201 frequencies, permittivity 3 to 9,
one to three point targets at 30 to 200 mm depth, at random places at least 60 mm apart. Noise is
that much below the strongest echo of each target at each frequency of one trace; the image adds up
thousands of such samples. Half of the scenes also have the echo of a surface, 30 dB above those of
the targets, whose height varies by 1 mm (standard deviation) from trace to trace; the recorded
heights do not know it. The mean of all traces is subtracted. A candidate within 30 mm across and 20
mm in depth of a target is that target; all others are false. Those that are said to be clutter or
sidelobes are counted apart.

Noise surveys: the same without targets; the share of images with any candidate should be the
false-alarm rate.
"""

from __future__ import annotations

import argparse
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis.candidates.search import CandidateOptions, find_candidates
from gpr20_analysis.dataset import S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import METHODS, Method, imaging_method
from gpr20_analysis.processing.background import Background, remove_background
from gpr20_simulator.mid.world.refraction import refracted_path
from gpr20_survey.results.candidates import CandidateList

PLACE_M = 0.015 * np.arange(25)
HEIGHT_M = 0.20
FREQUENCY_HZ = np.linspace(600e6, 6e9, 201)
DEPTH_M = tuple(np.arange(0.0, 0.2501, 0.005))
AREA_M2 = float(np.ptp(PLACE_M) ** 2)
LEVELS_DB = (20.0, 10.0, 0.0, -20.0, -30.0, -35.0)
RATES = (0.1, 0.01, 0.001)
SURFACE, ROUGHNESS_M = 10.0 ** (30.0 / 20.0), 0.001
ACROSS_M, DEEPER_M, APART_M = 0.03, 0.02, 0.06
HEADING = (
    *("ground", "echo above noise dB", "false-alarm rate %", "found %", "found without flag %"),
    *("false per m2", "doubtful per m2"),
)
Place = Tuple[float, float, float]


def survey(s21: np.ndarray) -> xr.Dataset:
    shape = s21.shape[:3]
    return xr.Dataset(
        {
            "s21": (S21_DIMS, s21),
            "height": (SAMPLE_DIMS, np.full(shape, HEIGHT_M)),
            "quality": (SAMPLE_DIMS, np.zeros(shape, dtype=np.uint8)),
        },
        {
            "polarization": [0.0, 90.0][: shape[0]],
            "y": PLACE_M,
            "x": PLACE_M,
            "frequency": FREQUENCY_HZ,
        },
    )


def noise(random: np.random.Generator, shape: Sequence[int]) -> np.ndarray:
    parts = random.standard_normal((*shape, 2))
    return (parts[..., 0] + 1j * parts[..., 1]) / np.sqrt(2.0)


def echo(delay_s: np.ndarray) -> np.ndarray:
    level = (delay_s.min() / delay_s) ** 2
    return level[..., None] * np.exp(-2j * np.pi * FREQUENCY_HZ * delay_s[..., None])


def two_way_delay_s(depth_m: float, across_m: np.ndarray, permittivity: float) -> np.ndarray:
    path = refracted_path(HEIGHT_M, np.full(across_m.size, depth_m), across_m.ravel(), permittivity)
    path_m = path.air_m + np.sqrt(permittivity) * path.soil_m
    return 2.0 * path_m.reshape(across_m.shape) / speed_of_light


def targets(random: np.random.Generator) -> List[Place]:
    found: List[Place] = []
    while len(found) < random.integers(1, 4):
        x_m, y_m = random.uniform(0.03, PLACE_M[-1] - 0.03, 2)
        if all(np.hypot(x_m - one[0], y_m - one[1]) >= APART_M for one in found):
            found.append((float(x_m), float(y_m), float(random.uniform(0.03, 0.2))))
    return found


def scene(
    random: np.random.Generator, there: Sequence[Place], permittivity: float, rough: bool
) -> np.ndarray:
    s21 = np.zeros((2, PLACE_M.size, PLACE_M.size, FREQUENCY_HZ.size), dtype=np.complex128)
    for x_m, y_m, depth_m in there:
        across_m = np.hypot(PLACE_M[None, :] - x_m, PLACE_M[:, None] - y_m)
        s21 += echo(two_way_delay_s(depth_m, across_m, permittivity))
    if rough:
        height_m = HEIGHT_M + ROUGHNESS_M * random.standard_normal(across_m.shape)
        delay_s = 2.0 * height_m / speed_of_light
        s21 -= SURFACE * np.exp(-2j * np.pi * FREQUENCY_HZ * delay_s[..., None])
    return s21


def scored(found: CandidateList, there: Sequence[Place]) -> Tuple[int, int, int, int]:
    """Return the numbers of found targets, and false candidates, each without and with flags.

    Found with flags counts all that are found; false with flags counts those that are doubtful.
    """
    plain, hit, false, doubtful = set(), set(), 0, 0
    for one in found.candidates:
        near = [
            number
            for number, (x_m, y_m, depth_m) in enumerate(there)
            if np.hypot(one.x_m - x_m, one.y_m - y_m) < ACROSS_M
            and abs(one.depth_m - depth_m) < DEEPER_M
        ]
        hit.update(near)
        if one.is_doubtful:
            doubtful += not near
        else:
            plain.update(near)
            false += not near
    return len(plain), len(hit), false, doubtful


def detections(scenes: int, method: Method) -> Dict[Tuple[bool, float, float], np.ndarray]:
    """Return targets, the counts of `scored`, and scenes, of each ground, level and rate."""
    counts: Dict[Tuple[bool, float, float], np.ndarray] = {}
    for number in range(scenes):
        random = np.random.default_rng(number)
        rough = number % 2 == 1
        permittivity = float(random.uniform(3.0, 9.0))
        there = targets(random)
        clean = scene(random, there, permittivity, rough)
        for level_db in LEVELS_DB:
            noisy = clean + 10.0 ** (-level_db / 20.0) * noise(random, clean.shape)
            image = image_survey(
                remove_background(survey(noisy), Background.MEAN),
                ImageOptions(method, permittivity, DEPTH_M),
            )
            for rate in RATES:
                found = find_candidates(image, CandidateOptions(rate, 100_000))
                add = np.array([len(there), *scored(found, there), 1.0])
                key = (rough, level_db, rate)
                counts[key] = counts.get(key, np.zeros(6)) + add
    return counts


def false_alarms(surveys: int, method: Method) -> Dict[float, float]:
    """Return the share of images of noise with any candidate, by false-alarm rate."""
    any_found = dict.fromkeys(RATES, 0)
    for number in range(surveys):
        random = np.random.default_rng(10_000 + number)
        data = survey(noise(random, (2, PLACE_M.size, PLACE_M.size, FREQUENCY_HZ.size)))
        image = image_survey(
            remove_background(data, Background.MEAN), ImageOptions(method, 4.0, DEPTH_M)
        )
        for rate in RATES:
            any_found[rate] += bool(find_candidates(image, CandidateOptions(rate)).candidates)
    return {rate: count / surveys for rate, count in any_found.items()}


def draw(counts: Dict[Tuple[bool, float, float], np.ndarray], path: str) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    for rate in RATES:
        for rough, style in ((False, "-"), (True, "--")):
            ones = [counts[rough, level, rate] for level in LEVELS_DB]
            ground = "rough" if rough else "level"
            axes.plot(
                LEVELS_DB, [one[2] / one[0] for one in ones], style, marker="o",
                label=f"{ground}, false alarms {100.0 * rate:g} %",
            )  # fmt: skip
    axes.set_xlabel("echo above noise, one frequency of one trace [dB]")
    axes.set_ylabel("share of targets found")
    axes.grid(True)
    axes.legend()
    figure.savefig(path)


def main(arguments: Optional[Sequence[str]] = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--noise-surveys", type=int, default=300)
    parser.add_argument("--method", choices=METHODS.names(), default="phase-shift")
    parser.add_argument("--figure")
    chosen = parser.parse_args(arguments)
    method = imaging_method(chosen.method)
    if chosen.noise_surveys:
        print(f"images of {chosen.noise_surveys} noise surveys with any candidate, {method.name}")
        for rate, share in false_alarms(chosen.noise_surveys, method).items():
            print(f"  false-alarm rate {100.0 * rate:g} %: {100.0 * share:.1f} %")
    if not chosen.scenes:
        return
    counts = detections(chosen.scenes, method)
    print(f"| {' | '.join(HEADING)} |\n| --- {'| ---: ' * (len(HEADING) - 1)}|")
    for (rough, level_db, rate), one in sorted(counts.items()):
        there, plain, hit, false, doubtful, scenes = one
        area_m2 = scenes * AREA_M2
        shares = [f"{100.0 * count / there:.0f}" for count in (hit, plain)]
        densities = [f"{count / area_m2:.1f}" for count in (false, doubtful)]
        ground = "rough" if rough else "level"
        cells = [ground, f"{level_db:g}", f"{100.0 * rate:g}", *shares, *densities]
        print(f"| {' | '.join(cells)} |")
    if chosen.figure:
        draw(counts, chosen.figure)


if __name__ == "__main__":
    main()

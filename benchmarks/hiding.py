"""Whether the map of where a target could hide agrees with direct simulation.

Usage: scripts/bench.sh hiding [--places 100] [--trials 12] [--seed 1]
       scripts/bench.sh hiding --size 67

The surveys are the five computed laboratory scenes of Uniandes (finite differences, with all their
bodies). For random places and depths in them the map's share is compared with that of targets that
are simulated directly: the scattered field of two dipoles over a half space by an exact integral
over the disc (discs.npz), in the units of the scene by its coupling, which the map does not use.
Each is put alone into the scene's spectra, at places within the map's radius, and searched with the
same detector. The discs differ little from the soil, where that integral is exact. Two shares agree
if their 95 % intervals (Clopper-Pearson) overlap.

--size times the map of a survey of so many positions along each side, 10 mm apart, two
polarizations and 501 frequencies: a surface, 60 stones of random strength, and noise.
"""

from __future__ import annotations

import argparse
import resource
import time
from functools import lru_cache
from typing import Tuple

import numpy as np
import xarray as xr
from recorded_worlds import DISCS, UNIANDES, area, dataset, disc, truths
from scipy.constants import epsilon_0, speed_of_light

from gpr20_analysis.hiding import search as hiding
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.records import Ground
from gpr20_survey.radar import one_way_delay_s
from gpr20_survey.results.candidates import CandidateList
from gpr20_survey.results.hiding_map import HidingMap, target_of

SEPARATION_M = 0.06
TARGETS = tuple(dict.fromkeys(one["target"] for one in truths(DISCS)))
DEPTHS_M = tuple(dict.fromkeys(one["top_m"] for one in truths(DISCS)))


@lru_cache(maxsize=None)
def scene(number: int) -> xr.Dataset:
    """Return a scene."""
    return area(UNIANDES, number)[0]


def with_disc(survey: xr.Dataset, name: str, top_m: float, row: int, column: int) -> xr.Dataset:
    """Return a scene with a disc below one of its positions, by the exact integral."""
    echo, level = disc(name, top_m)
    scale = survey["s21"].values.mean(axis=(0, 1, 2)) / level
    count = survey.sizes["x"]
    rows = slice(count - 1 - row, 2 * count - 1 - row)
    columns = slice(count - 1 - column, 2 * count - 1 - column)
    return survey.assign(s21=survey["s21"] + scale * echo[rows, columns])


def detector(permittivity: float) -> hiding.Detector:
    """Return the detector of the default command."""
    options = ImageOptions(
        permittivity=permittivity, permittivity_uncertainty=0.01, ground=Ground.LEVEL
    )
    return hiding.Detector(options)


@lru_cache(maxsize=None)
def listed_of(number: int) -> CandidateList:
    """Return the candidates of a scene."""
    return detector(truths(UNIANDES)[number]["permittivity"]).search(scene(number))


@lru_cache(maxsize=None)
def map_of(number: int, name: str) -> HidingMap:
    """Return the map of a target in a scene."""
    truth = truths(UNIANDES)[number]
    survey, permittivity = scene(number), truth["permittivity"]
    middle_hz = float(survey["frequency"].mean())
    loss = truth["conductivity_s_per_m"] / (2.0 * np.pi * middle_hz * epsilon_0 * permittivity)
    options = hiding.HidingOptions(DEPTHS_M, loss_tangent=loss, separation_m=SEPARATION_M)
    return hiding.map_hidden(survey, detector(permittivity), target_of(name), options)


def compared(seed: int, trials: int) -> Tuple[int, int, int, int]:
    """Return found and tried of the map, then of direct simulation, at one random place."""
    random = np.random.default_rng([29, seed])
    number, name = int(random.integers(len(truths(UNIANDES)))), str(random.choice(TARGETS))
    layer, target = int(random.integers(len(DEPTHS_M))), target_of(name)
    found = map_of(number, name)
    row, column = int(random.integers(len(found.y_m))), int(random.integers(len(found.x_m)))
    survey, permittivity = scene(number), truths(UNIANDES)[number]["permittivity"]
    x_m, y_m = (survey[one].values for one in ("x", "y"))
    away_m = np.hypot(y_m[:, None] - found.y_m[row], x_m - found.x_m[column])
    near = away_m <= found.within_m[layer]
    places = np.argwhere(near)
    chosen = places[random.choice(len(places), min(trials, len(places)), replace=False)]
    hits = sum(
        hiding.is_found(
            detector(permittivity).search(with_disc(survey, name, DEPTHS_M[layer], *one)),
            listed_of(number),
            (float(x_m[one[1]]), float(y_m[one[0]])),
            DEPTHS_M[layer],
            target,
        )
        for one in chosen
    )
    place = (layer, row, column)
    return int(found.found[place]), int(found.tried[place]), hits, len(chosen)


def stones(size: int) -> xr.Dataset:
    """Return a survey over stones of random places and strengths."""
    random, count, height_m, permittivity = np.random.default_rng(3), 60, 0.2, 4.0
    place_m, frequency_hz = 0.01 * np.arange(size), np.linspace(0.6e9, 6e9, 501)
    s21 = np.exp(-2j * np.pi * frequency_hz * 2.0 * height_m / speed_of_light) / height_m
    s21 = np.tile(s21, (size, size, 1))
    for _ in range(count):
        x_m, y_m = random.uniform(0.0, place_m[-1], 2)
        away_m = np.hypot(place_m - x_m, (place_m - y_m)[:, None])
        delay_s = 2.0 * one_way_delay_s(height_m, random.uniform(0.02, 0.3), away_m, permittivity)
        strength = 0.02 * np.exp(random.normal(0.0, 0.7))
        s21 += strength * np.exp(-2j * np.pi * delay_s[..., None] * frequency_hz)
    surveys = []
    for _ in range(2):
        noise = random.standard_normal((*s21.shape, 2)) @ np.array([0.05, 0.05j])
        surveys.append(dataset(s21 + noise, height_m, place_m, place_m, frequency_hz))
    turned = surveys[1].assign_coords(polarization=[90.0])
    return xr.concat([surveys[0], turned], "polarization", combine_attrs="override")


def time_map(size: int) -> str:
    """Return how long the map of a Type 72 takes."""
    survey = stones(size)
    begin, busy = time.monotonic(), time.process_time()
    found = hiding.map_hidden(survey, detector(4.0), target_of("type-72"), hiding.HidingOptions())
    took_s, busy_s = time.monotonic() - begin, time.process_time() - busy
    peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    lines = [str(one) for one in found.details]
    return "\n".join([*lines, f"{took_s:.0f} s, {busy_s:.0f} s of processor, {peak_mib:.0f} MiB"])


def main() -> None:
    """Print how the shares compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--places", type=int, default=100)
    parser.add_argument("--trials", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", type=int, help="time a map of so many positions a side")
    chosen = parser.parse_args()
    if chosen.size:
        print(time_map(chosen.size))
        return
    begin = time.monotonic()
    rows = [compared(1000 * chosen.seed + one, chosen.trials) for one in range(chosen.places)]
    counts = np.array(rows)
    overlap = []
    for hits, tried, direct, trials in rows:
        own, other = (
            hiding.detection_interval(hits, tried),
            hiding.detection_interval(direct, trials),
        )
        overlap.append(own[0] <= other[1] and other[0] <= own[1])
    shares = counts[:, 0] / np.maximum(counts[:, 1], 1)
    print(f"intervals overlap at {sum(overlap)} of {len(rows)} places")
    print("| share of the map | places | map found % | direct found % |")
    print("| --- | ---: | ---: | ---: |")
    for low, high in ((0.0, 0.2), (0.2, 0.5), (0.5, 0.8), (0.8, 1.01), (0.0, 1.01)):
        part = counts[(shares >= low) & (shares < high)]
        if len(part):
            sums = part.sum(axis=0)
            direct_low, direct_high = hiding.detection_interval(int(sums[2]), int(sums[3]))
            print(
                f"| {low:.1f} to {min(high, 1.0):.1f} | {len(part)} | "
                f"{100 * sums[0] / max(sums[1], 1):.0f} | {100 * sums[2] / sums[3]:.0f} "
                f"({100 * direct_low:.0f} to {100 * direct_high:.0f}) |"
            )
    print(f"{time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()

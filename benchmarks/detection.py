"""How many bodies are found, against false candidates, in ground that the imaging did not make.

Usage: scripts/bench.sh detection [--permittivity] [--half 1]

Lines: cuts of 0.96 m computed from Maxwell's equations in two dimensions (benchmarks/worlds), over
clean, cluttered (stones, roots), rough (3 to 10 mm), lossy ground, and all of it at once. None to
three bodies at 20 to 200 mm: plastic and metal discs of 30 to 60 mm radius, cylinders, fragments.
Areas: the five laboratory scenes of Uniandes and three random ones, in three dimensions. Born: 40
areas by an integral over the body, without any grid. gprMax: 14 lines by that program. The real
line is a GSSI record over 14 bars (tools/kits/recorded_worlds.py).

Each is imaged with the default command's steps and method and its true permittivity. A candidate
within 30 mm of a body's width and between 30 mm above its top and 60 mm below its bottom is that
body; all other places to check are false. "Listed" is a place to check. The settings of the list
were chosen on the scenes with even numbers; --half 1 scores the others only. Intervals are 95 %:
Clopper-Pearson for shares, Poisson's for densities. Per m2 of a line is per 0.3 m of its width.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import xarray as xr
from recorded_worlds import (
    AREAS,
    BORN,
    GPRMAX,
    LINES,
    UNIANDES,
    area,
    dataset,
    line,
    real_line,
    truths,
)
from scipy.stats import chi2

from gpr20_analysis.candidates.answer import answer
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.hiding.search import ABOVE_M, BELOW_M, NEAR_M, detection_interval
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import DEFAULT_STEPS, ImageOptions
from gpr20_analysis.imaging.permittivity import BuriedReference, permittivity_range
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey
from gpr20_survey.results.candidates import Candidate, CandidateList

BAR_M = 0.015
SEPARATION_M = 0.06
SHALLOWEST_M = 0.02
MINES = {"plastic disc", "metal disc", "mine", "bottle", "plastic disc beside a fragment"}
Body = Dict[str, Any]


@dataclass
class Score:
    """Counts of one kind of ground or body.

    Attributes:
        bodies: Bodies.
        found: Those that are places to check.
        leading: Those among the first three of their list.
        false: Other places to check.
        area_m2: Ground that they are on.
        errors: Error across and in depth of each that was found, in standard deviations.
    """

    bodies: int = 0
    found: int = 0
    leading: int = 0
    false: int = 0
    area_m2: float = 0.0
    errors: List[Tuple[float, float]] = field(default_factory=list)


class Scene(NamedTuple):
    """A kind of ground, the bodies in it, and what the default command lists."""

    ground: str
    bodies: List[Body]
    found: CandidateList


def candidates(survey: xr.Dataset, permittivity: Optional[float]) -> CandidateList:
    """Return what the default command lists; None: the permittivity is not known."""
    # It is the true one, so depths must not be said to be less certain.
    options = ImageOptions(
        permittivity=permittivity, permittivity_uncertainty=0.01, ground=Ground.LEVEL
    )
    return answer(survey, options).found


def is_at(one: Candidate, body: Body) -> bool:
    """Return whether a candidate is a body."""
    half_m = np.array(body["half_m"])
    away_m = np.abs([one.x_m - body["x_m"], one.y_m - body["y_m"]]) - half_m
    deeper_m = one.depth_m - body["top_m"]
    near = float(np.hypot(*np.maximum(away_m, 0.0))) < NEAR_M
    return near and -ABOVE_M < deeper_m < body["thickness_m"] + BELOW_M


def scores(scenes: Sequence[Scene]) -> Dict[str, Score]:
    """Return the scores of each kind of ground and body."""
    found: Dict[str, Score] = defaultdict(Score)
    for scene in scenes:
        listed = scene.found.candidates
        false = [not one.is_doubtful for one in listed]
        for body in scene.bodies:
            near = [place for place, one in enumerate(listed) if is_at(one, body)]
            for name in (scene.ground, body["kind"], "all"):
                found[name].bodies += 1
                found[name].leading += bool(near) and near[0] < 3
                if near and not listed[near[0]].is_doubtful:
                    first = listed[near[0]]
                    found[name].found += 1
                    of_place = (first.x_m - body["x_m"]) / first.x_uncertainty_m
                    of_depth = (first.depth_m - body["top_m"]) / first.depth_uncertainty_m
                    found[name].errors.append((of_place, of_depth))
            false = [is_false and at not in near for at, is_false in enumerate(false)]
        for name in (scene.ground, "all"):
            found[name].false += sum(false)
            found[name].area_m2 += scene.found.area_m2
    return found


def survey_of(name: str, number: int) -> Tuple[xr.Dataset, Dict[str, Any], List[Body]]:
    """Return a survey, its truth, and its bodies."""
    is_line = name in (LINES, GPRMAX)
    survey, truth = line(number, name) if is_line else area(name, number)
    bodies = []
    for body in truth["bodies"]:
        about = {"y_m": 0.0, "half_m": (body["half_width_m"], 0.0)} if is_line else {
            "kind": body["name"],
            "half_m": (body["size_m"][0] / 2.0, body["size_m"][1] / 2.0),
            "thickness_m": body["height_m"],
        }  # fmt: skip
        bodies.append({**body, **about})
    return survey, truth, bodies


def searched(name: str, numbers: Sequence[int], is_known: bool = True) -> List[Scene]:
    """Return scenes of a file with their candidates, with their permittivity or without it."""
    scenes = []
    for number in numbers:
        survey, truth, bodies = survey_of(name, number)
        found = candidates(survey, truth["permittivity"] if is_known else None)
        scenes.append(Scene(truth.get("ground", name), bodies, found))
    return scenes


def white_noise(half: int) -> List[Scene]:
    """Return lists of surveys of nothing but noise."""
    scenes = []
    for seed in range(15):
        random = np.random.default_rng([99, seed, half])
        for shape in ((1, 81), (21, 21), (41, 3)):
            noise = random.standard_normal((*shape, 81, 2)) @ np.array([1e-3, 1e-3j])
            axes_m = [0.012 * np.arange(one) for one in shape]
            survey = dataset(noise, 0.1, axes_m[1], axes_m[0], np.linspace(0.6e9, 6e9, 81))
            scenes.append(Scene("white noise", [], candidates(survey, 4.0)))
    return scenes


def of_mines(every: Dict[str, List[Scene]]) -> List[str]:
    """Return how the lists serve who looks for mines, as a table."""
    lines = [
        "| scenes | with a mine | listed | among the first five | first is one | bodies | places "
        "per m2 | false per m2 |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    parts: Dict[str, List[Scene]] = defaultdict(list)
    for name, scenes in every.items():
        for scene in scenes:
            is_empty = name != "white noise" and not scene.bodies
            parts["ground without bodies" if is_empty else name].append(scene)
    for name, own in parts.items():
        area_m2, ranks = sum(scene.found.area_m2 for scene in own), []
        counts = np.zeros(6, int)
        for scene in own:
            places = scene.found.shown()
            hits = [{at for at, one in enumerate(places) if is_at(one, body)}
                    for body in scene.bodies]  # fmt: skip
            mines = [at for at, body in zip(hits, scene.bodies) if body["kind"] in MINES]
            ranks += [min(at, default=np.inf) for at in mines]
            false = len(places) - len(set().union(*hits))
            counts += (bool(mines), any(0 in at for at in mines), len(hits),
                       sum(map(bool, hits)), len(places), false)  # fmt: skip
        lines.append(
            f"| {name} | {counts[0]} of {len(own)} | {np.isfinite(ranks).sum()} of {len(ranks)} | "
            f"{sum(one < 5 for one in ranks)} | {counts[1]} | {counts[3]} of {counts[2]} | "
            f"{counts[4] / area_m2:.1f} | {counts[5] / area_m2:.1f} |"
        )
    return lines


def rows(scores: Dict[str, Score]) -> List[str]:
    """Return a table in Markdown."""
    lines = [
        "| ground or body | bodies | found % | in first three % | false per m2 | "
        "x, depth within 2 sigma % |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for name, one in scores.items():
        if not one.bodies:
            continue
        low, high = detection_interval(one.found, one.bodies)
        found = f"{100 * one.found / one.bodies:.0f} ({100 * low:.0f} to {100 * high:.0f})"
        false = "-"
        if one.area_m2:
            counts = chi2.ppf((0.025, 0.975), (2 * one.false, 2 * one.false + 2)) / 2.0
            few, many = np.nan_to_num(counts) / one.area_m2
            false = f"{one.false / one.area_m2:.1f} ({few:.1f} to {many:.1f})"
        within = 100.0 * np.mean(np.abs(one.errors) < 2.0, axis=0) if one.errors else (np.nan,) * 2
        lines.append(
            f"| {name} | {one.bodies} | {found} | {100 * one.leading / one.bodies:.0f} | {false} | "
            f"{within[0]:.0f}, {within[1]:.0f} |"
        )
    return lines


def of_real_line() -> str:
    """Return what is found on the real line."""
    survey, bars_m = real_line()
    listed = candidates(survey, 6.0).shown()
    near = [float(np.abs(bars_m - one.x_m).min()) < BAR_M for one in listed]
    found = sum(min(abs(one.x_m - bar_m) for one in listed) < BAR_M for bar_m in bars_m)
    return (
        f"real line: {found} of {len(bars_m)} bars among {len(listed)} candidates, "
        f"{sum(near[: len(bars_m)])} of the first {len(bars_m)} candidates are bars"
    )


def of_buried_metal() -> str:
    """Return how often a buried metal body gives the permittivity, and its range holds."""
    files = (LINES, UNIANDES, AREAS)
    bodies, accepted, wrong = 0, 0, []
    for name, number in ((one, at) for one in files for at in range(len(truths(one)))):
        survey, truth, there = survey_of(name, number)
        for body in there:
            is_metal = {"metal", "plate"} & {*body["kind"].split()}
            if not is_metal or body["top_m"] < SHALLOWEST_M:
                continue
            bodies += 1
            reference = BuriedReference(body["x_m"], body["y_m"], body["top_m"])
            options = ImageOptions(buried=reference, ground=Ground.LEVEL, separation_m=SEPARATION_M)
            try:
                cleaned = process_survey(survey, *DEFAULT_STEPS)
                image = image_survey(cleaned, options, with_echoes=False)
            except WrongDatasetError:
                continue
            accepted += 1
            lowest, highest = permittivity_range(image)
            if not lowest <= truth["permittivity"] <= highest:
                wrong.append(f"{name} {number}: {lowest:.2f} to {highest:.2f}")
    return (
        f"permittivity by a buried metal body: found in {accepted} of {bodies}, refused in the "
        f"others; wrong in {len(wrong)} ({', '.join(wrong) or '-'})"
    )


def main() -> None:
    """Print the scores."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--permittivity", action="store_true", help="score it by buried metal, and unknown, too"
    )
    parser.add_argument("--half", type=int, choices=(0, 1), help="score every second scene")
    chosen = parser.parse_args()
    part = slice(None) if chosen.half is None else slice(chosen.half, None, 2)
    every = {
        name: searched(name, range(len(truths(name)))[part])
        for name in (LINES, UNIANDES, AREAS, BORN, GPRMAX)
    }
    for name, scenes in every.items():
        print(f"\n{name}\n", *rows(scores(scenes)), sep="\n")
    every["white noise"] = white_noise(1 if chosen.half is None else chosen.half)
    print("", *of_mines(every), "", of_real_line(), sep="\n")
    if chosen.permittivity:
        print(of_buried_metal())
        unknown = searched(LINES, range(len(truths(LINES)))[part], is_known=False)
        print("\nlines, permittivity unknown\n", *rows(scores(unknown)), sep="\n")


if __name__ == "__main__":
    main()

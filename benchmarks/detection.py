"""How many bodies are found, against false candidates, in ground that the imaging did not make.

Usage: scripts/bench.sh detection [--lines 200] [--permittivity] [--half 1]

Lines: cuts of 0.96 m computed from Maxwell's equations in two dimensions (benchmarks/worlds), over
clean, cluttered (stones, roots), rough (3 to 10 mm), lossy ground, and all of it at once. None to
three bodies at 20 to 200 mm: plastic and metal discs of 30 to 60 mm radius, cylinders, fragments.
Areas: the five laboratory scenes of Uniandes and three random ones, in three dimensions. Born: 40
areas by an integral over the body, without any grid. gprMax: 14 lines by that program. The real
line is a GSSI record over 14 bars (tools/kits/recorded_worlds.py).

Each is imaged with the default command's steps and method and its true permittivity. A candidate
within 30 mm of a body's width and between 30 mm above its top and 60 mm below its bottom is that
body; all other places to check are false. "Listed" is a place to check. The settings of the list
were chosen on the scenes with even numbers; --half reports the others. Intervals are 95 %:
Clopper-Pearson for shares, Poisson's for densities. Per m2 of a line is per 0.3 m of its width.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence, Tuple

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

from gpr20_analysis.candidates.answer import answer
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.imaging.permittivity import permittivity_range
from gpr20_analysis.imaging.permittivity_source import BuriedReference
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.trial.statistics import alarm_interval, detection_interval
from gpr20_survey.results.candidates import Candidate, CandidateList

NEAR_M, ABOVE_M, BELOW_M = 0.03, 0.03, 0.06
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


def add(
    scores: Dict[str, Score], found: CandidateList, bodies: Sequence[Body], ground: str
) -> None:
    """Add what was found in one scene."""
    used = set()
    for body in bodies:
        near = [place for place, one in enumerate(found.candidates) if is_at(one, body)]
        used.update(near)
        first = found.candidates[near[0]] if near else None
        for name in (ground, body["kind"], "all"):
            scores[name].bodies += 1
            scores[name].leading += bool(near) and near[0] < 3
            if first is not None and not first.is_doubtful:
                scores[name].found += 1
                scores[name].errors.append(
                    (
                        (first.x_m - body["x_m"]) / first.x_uncertainty_m,
                        (first.depth_m - body["top_m"]) / first.depth_uncertainty_m,
                    )
                )
    others = [one for place, one in enumerate(found.candidates) if place not in used]
    for name in (ground, "all"):
        scores[name].false += sum(not one.is_doubtful for one in others)
        scores[name].area_m2 += found.area_m2


def scene(name: str, number: int) -> Tuple[xr.Dataset, Dict[str, Any], List[Body]]:
    """Return a scene, its truth, and its bodies."""
    if name in (LINES, GPRMAX):
        survey, truth = line(number, name)
        return (
            survey,
            truth,
            [
                {**body, "y_m": 0.0, "half_m": (body["half_width_m"], 0.0)}
                for body in truth["bodies"]
            ],
        )
    survey, truth = area(name, number)
    return (
        survey,
        truth,
        [
            {
                **body,
                "kind": body["name"],
                "half_m": (body["size_m"][0] / 2.0, body["size_m"][1] / 2.0),
                "thickness_m": body["height_m"],
            }
            for body in truth["bodies"]
        ],
    )


def of_scenes(name: str, count: int, is_known: bool = True) -> Dict[str, Score]:
    """Return the scores of a file of scenes, with their permittivity or without it."""
    scores: Dict[str, Score] = defaultdict(Score)
    for number in range(min(count, len(truths(name)))):
        survey, truth, bodies = scene(name, number)
        permittivity = truth["permittivity"] if is_known else None
        add(scores, candidates(survey, permittivity), bodies, truth.get("ground", name))
    return scores


def of_mines(half: int) -> List[str]:
    """Return how the list serves who looks for mines, on every second scene, as a table."""
    lines = [
        "| scenes | with a mine | listed | among the first five | first is one | bodies | places "
        "per m2 | false per m2 |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    parts: Dict[str, List[Tuple[CandidateList, List[Body]]]] = defaultdict(list)
    for name in (LINES, UNIANDES, AREAS, BORN, GPRMAX):
        for number in range(half, len(truths(name)), 2):
            survey, truth, bodies = scene(name, number)
            found = candidates(survey, truth["permittivity"])
            parts[name if bodies else "ground without bodies"].append((found, bodies))
    for seed in range(15):
        random = np.random.default_rng([99, seed, half])
        for shape in ((1, 81), (21, 21), (41, 3)):
            noise = random.standard_normal((*shape, 81, 2)) @ np.array([1e-3, 1e-3j])
            axes_m = [0.012 * np.arange(one) for one in shape]
            survey = dataset(noise, 0.1, axes_m[1], axes_m[0], np.linspace(0.6e9, 6e9, 81))
            parts["white noise"].append((candidates(survey, 4.0), []))
    for name, own in parts.items():
        ranks, area_m2 = [], sum(found.area_m2 for found, _ in own)
        counts = np.zeros(4, int)  # scenes with a mine, first is one, bodies listed, false
        for found, bodies in own:
            places = found.shown()
            mines = [one for one in bodies if one["kind"] in MINES]
            ranks += [next((at for at, one in enumerate(places) if is_at(one, body)), None)
                      for body in mines]  # fmt: skip
            hits = [any(is_at(one, body) for one in places) for body in bodies]
            counts += (
                bool(mines),
                bool(places) and any(is_at(places[0], one) for one in mines),
                sum(hits),
                sum(not any(is_at(one, body) for body in bodies) for one in places),
            )
        listed = [one for one in ranks if one is not None]
        bodies_there = sum(len(bodies) for _, bodies in own)
        lines.append(
            f"| {name} | {counts[0]} of {len(own)} | {len(listed)} of {len(ranks)} | "
            f"{sum(one < 5 for one in listed)} | {counts[1]} | {counts[2]} of {bodies_there} | "
            f"{sum(found.primary for found, _ in own) / area_m2:.1f} | {counts[3] / area_m2:.1f} |"
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
            few, many = alarm_interval(one.false, one.area_m2)
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


def of_buried_metal(count: int) -> str:
    """Return how often a buried metal body gives the permittivity, and its range holds."""
    scenes = [(LINES, number, *line(number)) for number in range(count)]
    for name in (UNIANDES, AREAS):
        scenes += [(name, one, *area(name, one)) for one in range(len(truths(name)))]
    bodies, accepted, wrong = 0, 0, []
    for name, number, survey, truth in scenes:
        for body in truth["bodies"]:
            kind = body.get("kind", body.get("name"))
            if not ("metal" in kind or kind == "plate") or body["top_m"] < SHALLOWEST_M:
                continue
            bodies += 1
            reference = BuriedReference(body["x_m"], body.get("y_m", 0.0), body["top_m"])
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
    parser.add_argument("--lines", type=int, default=200)
    parser.add_argument(
        "--permittivity", action="store_true", help="score it by buried metal, and unknown, too"
    )
    parser.add_argument("--half", type=int, choices=(0, 1), help="score the list of every second")
    chosen = parser.parse_args()
    if chosen.half is not None:
        print(*of_mines(chosen.half), sep="\n")
        return
    every = {name: of_scenes(name, chosen.lines) for name in (LINES, UNIANDES, AREAS, BORN, GPRMAX)}
    for name, scores in every.items():
        print(f"\n{name}\n", *rows(scores), sep="\n")
    print("\n" + of_real_line())
    if chosen.permittivity:
        print(of_buried_metal(chosen.lines))
        unknown = of_scenes(LINES, chosen.lines, is_known=False)
        print("\nlines, permittivity unknown\n", *rows(unknown), sep="\n")


if __name__ == "__main__":
    main()

"""gpr20 trial: score lists of candidates against the truth that the plan of a trial seals."""

from __future__ import annotations

import argparse
import itertools
import json
from dataclasses import asdict
from pathlib import Path
from typing import List, Optional

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import outputs
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.trial.plan import Plan, read_list, read_plan, read_truth
from gpr20_analysis.trial.score import GroupScore, LaneScore, Score, counts, score_trial
from gpr20_common.catalogue import Catalogue
from gpr20_common.terminal_text import say
from gpr20_survey.results.candidates import SIMULATED

JSON, FORMAT = ".json", "gpr20-trial-score/1"
NOTICE = "A trial counts targets that were buried for it. It says nothing about any other ground."
HEADING = (
    "stratum | method | found | PD | interval | PD shown | false alarms | m2 | per m2 | interval"
)
LEAST_PART = 0.95  # of the area of a lane; where it is less, false alarms per m2 are too few


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("plan", type=Path, metavar="PLAN.yaml", help="halo, lanes, strata, SHA-256 of the truth")
    add("--truth", type=Path, required=True, metavar="TARGETS.csv", help="the table of targets")
    add("--list", nargs=3, action="append", required=True, metavar=("METHOD", "LANE", "LIST"),
        help="list of gpr20 candidates (.json), or any (.csv); once per method and "
        "lane")  # fmt: skip
    outputs.add_output(parser, [JSON], "every number, also the FROC curves: .json")


def _score(chosen: argparse.Namespace, _catalogue: Catalogue) -> int:
    output, paths = chosen.output, [Path(one) for _method, _lane, one in chosen.list]
    read = [chosen.plan, chosen.truth, *paths]
    outputs.check([output] if output else [], read, chosen.overwrite)
    plan = read_plan(chosen.plan)
    targets = read_truth(chosen.truth, plan)
    lists = [read_list(method, lane, Path(one), plan) for method, lane, one in chosen.list]
    score = score_trial(plan, targets, lists)
    simulated = any(one.listed.simulated for one in score.lanes)
    notices = [*([str(SIMULATED)] if simulated else []), NOTICE, *_warnings(plan, score)]
    say(
        *notices,
        f"The truth is the one whose SHA-256 is in the plan: {plan.truth_sha256[:16]}. Halo radius "
        f"{plan.halo_m:g} m. Intervals: 95 %, Clopper-Pearson, Poisson. PD shown: one-sided, 95 %. "
        "A stratum of targets has the false alarms of all lanes.",
        *map(_said_of_lane, score.lanes),
        HEADING,
        *map(_row, score.groups),
    )
    if output is not None:
        values = {"format": FORMAT, "warnings": notices, **asdict(score)}
        with atomic_output(output) as place:
            place.write_text(json.dumps(values, indent=2, allow_nan=False), encoding="utf-8")
    return DONE


def _warnings(plan: Plan, score: Score) -> List[str]:
    """Return which lanes a method did not survey whole, and lists of another place."""
    areas_m2 = {(one.listed.method, one.listed.lane): one.listed.area_m2 for one in score.lanes}
    pairs = itertools.product(dict.fromkeys(method for method, _ in areas_m2), plan.lanes)
    partly = [
        f"{method} surveyed only {areas_m2.get((method, lane), 0.0):.3g} m2 of lane {lane}: do not "
        "compare its totals with those of others (Simpson's paradox)."
        for method, lane in pairs
        if areas_m2.get((method, lane), 0.0) < LEAST_PART * plan.lanes[lane].area_m2
    ]
    return partly + [
        f"no place of {one.listed.method} is in lane {one.listed.lane} or near a target: places of "
        "a list are metres in the coordinates of the lane"
        for one in score.lanes
        if one.outside and len(one.outside) == len(one.listed.marks)
    ]


def _row(one: GroupScore) -> str:
    cells = [one.stratum or "all targets", one.method, f"{one.found}/{one.targets}"]
    cells += [_numbers(one.detection), _numbers(*one.detection_range)]
    cells += [_numbers(one.detection_shown), str(one.alarms), f"{one.area_m2:.2f}"]
    cells += [_numbers(one.alarms_per_m2), _numbers(*one.alarms_range)]
    return " | ".join(cells)


def _said_of_lane(one: LaneScore) -> str:
    missed = " ".join(name for name, mark in one.found.items() if not counts(mark)) or "-"
    alarms, outside = (
        " ".join(mark.id for mark in marks) or "-" for marks in (one.alarms, one.outside)
    )
    return (
        f"{one.listed.method}, {one.listed.lane}: missed: {missed}; false alarms, also weaker "
        f"echoes: {alarms}; not counted: {outside}."
    )


def _numbers(*values: Optional[float]) -> str:
    return " \u2013 ".join("-" if one is None else f"{one:.3f}" for one in values)


TRIAL = Command(
    "Score lists of candidates against buried targets that nobody knew who measured. A trial says "
    "how many of its own targets were found; it says nothing about any other ground.",
    _add_arguments,
    _score,
)

"""The score of a trial: which targets were found, and how many candidates were false alarms.

The unit is the target. A candidate counts for the nearest target whose halo it is in, and for no
other: one mark on the ground does not prove that two objects were seen. A candidate in no halo is
a false alarm, unless it is outside its lane; that is listed and counts for nothing. Each candidate
is judged by itself, so a longer list never finds less.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.trial.ground import Group, Place, Target, groups_of
from gpr20_analysis.trial.plan import Plan
from gpr20_analysis.trial.seal import Mark, Seal
from gpr20_analysis.trial.statistics import (
    alarm_interval,
    detection_interval,
    mcnemar,
    shown_detection,
)
from gpr20_common.message import Message
from gpr20_survey.results.found import Found, What

MM_PER_M = 1e3
UNKNOWN, MISSED = "not_looked_at", "devices_without_candidate"
Range = Tuple[float, Optional[float]]


@dataclass(frozen=True)
class LaneScore:
    """What a sealed list says of its lane."""

    seal: Seal
    area_m2: float  # of the lane outside all halos [m2]
    found: Dict[str, Mark]  # the most certain candidate of each target that was found
    missed: List[str]  # also what only a candidate that does not count finds
    alarms: List[Mark]  # candidates in no halo
    outside: List[Mark]  # candidates outside the lane and every halo


@dataclass(frozen=True)
class GroupScore:
    """The counts of a method for a group of targets; ranges are 95 % intervals."""

    stratum: str  # name of the group; empty: all
    method: str
    targets: int  # in lanes that the method has a list of
    found: int
    detection: Optional[float]  # share that was found; None without targets
    detection_range: Range
    detection_shown: float  # the one-sided lower limit
    alarms: int
    area_m2: float  # outside the halos of these lanes [m2]
    alarms_per_m2: Optional[float]  # None without ground
    alarms_range: Range
    curve: Tuple[Tuple[float, float], ...]  # false alarms per m2, share found


@dataclass(frozen=True)
class Comparison:
    """Two methods on the same targets: how many only one of them found; McNemar's exact test.

    Where the shares of a method's targets in the strata are others, the totals are not comparable.
    """

    first: str
    second: str
    targets: int
    only_first: int
    only_second: int
    p_value: float
    same_shares: bool


@dataclass(frozen=True)
class Score:
    """The score of each stratum, all targets first; of every two methods; and of each list."""

    groups: List[GroupScore]
    comparisons: List[Comparison]
    lanes: List[LaneScore]


def score_trial(plan: Plan, targets: Sequence[Target], seals: Sequence[Seal]) -> Score:
    """Return the score of sealed lists.

    Raises:
        AnalysisError: A list was sealed for another plan, or two for one lane and method.
    """
    lanes: Dict[Tuple[str, str], LaneScore] = {}
    for seal in seals:
        names = {"method": seal.method, "lane": seal.lane}
        if seal.plan_sha256 != plan.sha256:
            other = Message("the list of {method} for lane {lane} has another plan", **names)
            raise AnalysisError(other, fault=faults.FILE_CHANGED)
        if (seal.method, seal.lane) in lanes:
            twice = Message("there are two sealed lists of {method} for lane {lane}", **names)
            raise AnalysisError(twice, fault=faults.FILE_CHANGED)
        lanes[seal.method, seal.lane] = _score_lane(plan, targets, seal)
    return _Scorer(plan, groups_of(plan.strata, targets, plan.lanes), lanes).score()


def score_found(listed: Seal, records: Sequence[Found], halo_m: float) -> Dict[str, int]:
    """Return how many candidates of a list were what: each record says it of the nearest one.

    Args:
        listed: The list, in the coordinates of the survey.
        records: What was found; of two for one candidate the last one counts.
        halo_m: A record further from every candidate is of none [m].

    Returns:
        Numbers by the values of `What`; `UNKNOWN` and `MISSED` are those of candidates without a
        record, and of devices without a candidate.
    """
    places_m = [((one.x_m, one.y_m), one.id) for one in listed.marks]
    what: Dict[str, What] = {}
    missed = 0
    for one in records:
        name = _nearest((one.x_mm / MM_PER_M, one.y_mm / MM_PER_M), places_m, halo_m)
        if name:
            what[name] = one.what
        else:
            missed += one.what is What.DEVICE
    counts = {kind.value: sum(one is kind for one in what.values()) for kind in What}
    return {**counts, UNKNOWN: len(places_m) - len(what), MISSED: missed}


def _nearest(place_m: Place, named: Sequence[Tuple[Place, str]], halo_m: float) -> str:
    """Return the name of the nearest place within a distance; empty: there is none."""
    near = [(math.dist(place_m, one), name) for one, name in named]
    distance_m, name = min(near, default=(math.inf, ""))
    return name if distance_m <= halo_m else ""


def _counts(plan: Plan, mark: Mark) -> bool:
    return plan.with_doubtful or not mark.doubtful


def _score_lane(plan: Plan, targets: Sequence[Target], seal: Seal) -> LaneScore:
    lane = plan.lane(seal.lane)
    places_m = [(one.place_m, one.name) for one in targets if one.lane == seal.lane]
    found: Dict[str, Mark] = {}
    alarms: List[Mark] = []
    outside: List[Mark] = []
    for mark in sorted(seal.marks, key=lambda one: one.rank):
        place_m = mark.x_m, mark.y_m
        name = _nearest(place_m, places_m, plan.halo_m)
        if name:
            found.setdefault(name, mark)
        else:
            (alarms if lane.contains(place_m) else outside).append(mark)
    counted = [name for name, mark in found.items() if _counts(plan, mark)]
    missed = [name for _, name in places_m if name not in counted]
    area_m2 = lane.area_outside([place for place, _ in places_m], plan.halo_m)
    return LaneScore(seal, area_m2, found, missed, alarms, outside)


class _Scorer:
    def __init__(
        self, plan: Plan, groups: List[Group], lanes: Dict[Tuple[str, str], LaneScore]
    ) -> None:
        self._plan, self._groups, self._lanes = plan, groups, lanes
        self._finds = {
            (method, name): name not in lane.missed
            for (method, _), lane in lanes.items()
            for name in (*lane.found, *lane.missed)
        }

    def score(self) -> Score:
        methods = list(dict.fromkeys(method for method, _ in self._lanes))
        groups = [self._of(group, method) for group in self._groups for method in methods]
        return Score(
            [one for one in groups if one.targets or not one.stratum],
            [self._compared(*pair) for pair in itertools.combinations(methods, 2)],
            list(self._lanes.values()),
        )

    def _in(self, group: Group, method: str) -> List[str]:
        return [one for one in group.targets if (method, one) in self._finds]

    def _of(self, group: Group, method: str) -> GroupScore:
        names = self._in(group, method)
        lanes = [self._lanes[method, one] for one in group.lanes if (method, one) in self._lanes]
        hits = [lane.found[name] for lane in lanes for name in lane.found if name in names]
        false = [mark for lane in lanes for mark in lane.alarms]
        targets, area_m2 = len(names), sum(lane.area_m2 for lane in lanes)
        found = sum(self._finds[method, one] for one in names)
        alarms = sum(_counts(self._plan, one) for one in false)
        low, high = alarm_interval(alarms, area_m2)
        return GroupScore(
            group.name,
            method,
            targets,
            found,
            found / targets if targets else None,
            detection_interval(found, targets),
            shown_detection(found, targets),
            alarms,
            area_m2,
            alarms / area_m2 if area_m2 > 0.0 else None,
            (low, high if math.isfinite(high) else None),
            _curve(hits, false, targets, area_m2),
        )

    def _compared(self, first: str, second: str) -> Comparison:
        both = [one for one in self._in(self._groups[0], first) if (second, one) in self._finds]
        found = [(self._finds[first, one], self._finds[second, one]) for one in both]
        only = found.count((True, False)), found.count((False, True))
        shares = self._shares(first) == self._shares(second)
        return Comparison(first, second, len(both), *only, mcnemar(*only), shares)

    def _shares(self, method: str) -> List[float]:
        counts = [len(self._in(one, method)) for one in self._groups]
        return [round(one / max(counts[0], 1), 9) for one in counts]


def _curve(
    hits: Sequence[Mark], false: Sequence[Mark], targets: int, area_m2: float
) -> Tuple[Tuple[float, float], ...]:
    curve, found, alarms = [(0.0, 0.0)], 0, 0
    marks = sorted([(one.rank, 1) for one in hits] + [(one.rank, 0) for one in false])
    known = marks if targets and area_m2 > 0.0 else []
    for _, same in itertools.groupby(known, lambda one: one[0]):
        for _, is_hit in same:
            found, alarms = found + is_hit, alarms + 1 - is_hit
        curve.append((alarms / area_m2, found / targets))
    return tuple(curve)

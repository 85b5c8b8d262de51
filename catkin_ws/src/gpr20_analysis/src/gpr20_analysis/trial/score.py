"""The score of a trial: which targets were found, and how many candidates were false alarms.

The unit is the target. A candidate counts for the nearest target whose halo it is in, and for no
other: one mark on the ground does not prove that two objects were seen. A candidate in no halo is
a false alarm, unless it is outside its lane; that is listed and counts for nothing. Doubtful
candidates are only in the curves. A longer list never finds less.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from dataclasses import dataclass, replace
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.trial import statistics
from gpr20_analysis.trial.documents import Mark, Plan, Seal
from gpr20_analysis.trial.ground import Group, Place, Target, groups_of
from gpr20_common.message import Message
from gpr20_survey.results.found import Found, What, present

MM_PER_M = 1e3
Range = Tuple[float, Optional[float]]


@dataclass(frozen=True)
class LaneScore:
    """What a sealed list says of its lane."""

    seal: Seal
    area_m2: float  # of the lane outside all halos [m2]
    found: Dict[str, Optional[Mark]]  # the most certain candidate of each target
    alarms: List[Mark]  # candidates in no halo
    outside: List[Mark]  # candidates outside the lane and every halo, which are not counted


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
    """How many targets of both only one of two methods found; McNemar's exact test."""

    first: str
    second: str
    targets: int
    only_first: int
    only_second: int
    p_value: float


@dataclass(frozen=True)
class Score:
    """The score of each stratum, all targets first; of every two methods; and of each list."""

    groups: List[GroupScore]
    comparisons: List[Comparison]
    lanes: List[LaneScore]


Lanes = Mapping[Tuple[str, str], LaneScore]  # by method and lane


def counts(mark: Optional[Mark]) -> bool:
    """Return whether there is a candidate that is not doubtful."""
    return mark is not None and not mark.doubtful


def score_trial(plan: Plan, targets: Sequence[Target], seals: Sequence[Seal]) -> Score:
    """Return the score of sealed lists."""
    lanes: Dict[Tuple[str, str], LaneScore] = {}
    for seal in seals:
        is_of_plan = seal.plan_sha256 == plan.sha256 and seal.lane in plan.lanes
        if not is_of_plan or (seal.method, seal.lane) in lanes:
            other = Message(
                "the list of {method} for lane {lane} is of another plan, or given twice",
                **{"method": seal.method, "lane": seal.lane},
            )
            raise AnalysisError(other, fault=faults.FILE_DAMAGED)
        for one in (one.seal for one in lanes.values()):
            # A table of a heading alone may be that of several lanes.
            if one.list_sha256 == seal.list_sha256 and (seal.marks or seal.survey_id):
                same = Message(
                    "one list is sealed for {first} and for {second}; seal the right one for each",
                    first=f"{one.method}, {one.lane}",
                    second=f"{seal.method}, {seal.lane}",
                )
                raise AnalysisError(same, fault=faults.FILE_DAMAGED)
        lane = plan.lanes[seal.lane]
        own = [one for one in targets if one.lane == seal.lane]
        area_m2 = lane.area_outside([one.place_m for one in own], plan.halo_m)
        scored = _score_lane(seal, own, plan.halo_m, area_m2, lane.contains)
        lanes[seal.method, seal.lane] = scored
    methods = list(dict.fromkeys(method for method, _ in lanes))
    groups = [
        _score_group(group, method, lanes)
        for group in groups_of(plan.strata, targets, plan.lanes)
        for method in methods
    ]
    return Score(
        groups,
        [_compared(*pair, lanes) for pair in itertools.combinations(methods, 2)],
        list(lanes.values()),
    )


def score_found(listed: Seal, records: Sequence[Found], halo_m: float) -> Score:
    """Return the score of a list of a survey by what was found there.

    Devices are the targets, and other finds false alarms; all other candidates count for nothing,
    because nobody looked there. Nor did anybody where no candidate is, so there is no PD.
    """
    finds: Dict[bool, List[Target]] = {True: [], False: []}
    for one in present(records):
        place_m = one.x_mm / MM_PER_M, one.y_mm / MM_PER_M
        name = f"{one.candidate} {one.list_sha256[:8]}"
        finds[one.what is What.DEVICE].append(Target(name, "", place_m, {}))
    devices, others = finds[True], finds[False]
    lane = _score_lane(
        listed, devices, halo_m, listed.area_m2, lambda one: _nearest(one, others, halo_m)
    )
    group = Group("", [one.name for one in devices], [listed.lane])
    score = _score_group(group, listed.method, {(listed.method, listed.lane): lane})
    unknown = replace(score, detection=None, detection_range=(0.0, 1.0), detection_shown=0.0)
    return Score([replace(unknown, curve=())], [], [lane])


def _nearest(place_m: Place, targets: Sequence[Target], halo_m: float) -> str:
    """Return the name of the nearest target within a distance; empty: there is none."""
    near = [(math.dist(place_m, one.place_m), one.name) for one in targets]
    distance_m, name = min(near, default=(math.inf, ""))
    return name if distance_m <= halo_m else ""


def _score_lane(
    seal: Seal,
    targets: Sequence[Target],
    halo_m: float,
    area_m2: float,
    is_searched: Callable[[Place], object],
) -> LaneScore:
    found: Dict[str, Optional[Mark]] = {one.name: None for one in targets}
    alarms: List[Mark] = []
    outside: List[Mark] = []
    for mark in sorted(seal.marks, key=lambda one: one.rank):
        place_m = mark.x_m, mark.y_m
        name = _nearest(place_m, targets, halo_m)
        if name:
            found[name] = found[name] or mark
        else:
            (alarms if is_searched(place_m) else outside).append(mark)
    return LaneScore(seal, area_m2, found, alarms, outside)


def _score_group(group: Group, method: str, lanes: Lanes) -> GroupScore:
    own = [lanes[method, one] for one in group.lanes if (method, one) in lanes]
    best = [mark for lane in own for name, mark in lane.found.items() if name in group.targets]
    false = [mark for lane in own for mark in lane.alarms]
    targets, area_m2 = len(best), sum(lane.area_m2 for lane in own)
    found, alarms = sum(map(counts, best)), sum(map(counts, false))
    low, high = statistics.alarm_interval(alarms, area_m2)
    return GroupScore(
        *(group.name, method, targets, found),
        found / targets if targets else None,
        statistics.detection_interval(found, targets),
        statistics.shown_detection(found, targets),
        *(alarms, area_m2, alarms / area_m2 if area_m2 > 0.0 else None),
        (low, high if math.isfinite(high) else None),
        _curve([one for one in best if one], false, targets, area_m2),
    )


def _compared(first: str, second: str, lanes: Lanes) -> Comparison:
    pairs = [
        (counts(mark), counts(lanes[second, name].found[target]))
        for (method, name), lane in lanes.items()
        if method == first and (second, name) in lanes
        for target, mark in lane.found.items()
    ]
    only = pairs.count((True, False)), pairs.count((False, True))
    return Comparison(first, second, len(pairs), *only, statistics.mcnemar(*only))


def _curve(
    hits: Sequence[Mark], false: Sequence[Mark], targets: int, area_m2: float
) -> Tuple[Tuple[float, float], ...]:
    if not (targets and area_m2 > 0.0):
        return ((0.0, 0.0),)
    first, second = sorted(one.rank for one in false), sorted(one.rank for one in hits)
    points = [
        (bisect_right(first, one) / area_m2, bisect_right(second, one) / targets)
        for one in sorted({*first, *second})
    ]
    return ((0.0, 0.0), *points)

"""The score of a trial: which targets were found, and how many candidates were false alarms.

The unit is the target. A candidate counts for the nearest target whose halo it is in, and for no
other: one mark on the ground does not prove that two objects were seen. A candidate in no halo is
a false alarm, unless it is outside its lane; that is listed and counts for nothing. What is below
the cut of a list is only in the curves. A longer list never finds less.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.trial import statistics
from gpr20_analysis.trial.plan import Mark, MarkList, Plan, Target
from gpr20_common.message import Message


@dataclass(frozen=True)
class LaneScore:
    """What a list says of its lane."""

    listed: MarkList
    area_m2: float  # of the lane outside all halos [m2]
    found: Dict[str, Optional[Mark]]  # the most certain candidate of each target
    alarms: List[Mark]  # candidates in no halo
    outside: List[Mark]  # candidates outside the lane and every halo, which are not counted


@dataclass(frozen=True)
class GroupScore:
    """The counts of a method for a group of targets; ranges are 95 % intervals."""

    stratum: str  # such as "type PMN"; empty: all
    method: str
    targets: int  # in lanes that the method has a list of
    found: int
    detection: Optional[float]  # share that was found; None without targets
    detection_range: Tuple[float, float]
    detection_shown: float  # the one-sided lower limit
    alarms: int
    area_m2: float  # outside the halos of these lanes [m2]
    alarms_per_m2: Optional[float]  # None without ground
    alarms_range: Tuple[float, Optional[float]]
    curve: Tuple[Tuple[float, float], ...]  # false alarms per m2, share found


@dataclass(frozen=True)
class Score:
    """The score of each stratum, all targets first; and of each list."""

    groups: List[GroupScore]
    lanes: List[LaneScore]


Lanes = Mapping[Tuple[str, str], LaneScore]  # by method and lane


def counts(mark: Optional[Mark]) -> bool:
    """Return whether there is a candidate above the cut of its list."""
    return mark is not None and not mark.is_weaker


def score_trial(plan: Plan, targets: Sequence[Target], lists: Sequence[MarkList]) -> Score:
    """Return the score of lists.

    Raises:
        AnalysisError: A list is of no lane of the plan, or there are two of one method and lane.
    """
    lanes: Dict[Tuple[str, str], LaneScore] = {}
    for listed in lists:
        if listed.lane not in plan.lanes or (listed.method, listed.lane) in lanes:
            other = Message(
                "the list of {method} for lane {lane} is given twice, or the plan has no such "
                "lane; lanes: {lanes}",
                **{"method": listed.method, "lane": listed.lane},
                lanes=", ".join(plan.lanes),
            )
            raise AnalysisError(other, fault=faults.INPUT)
        own = [one for one in targets if one.lane == listed.lane]
        lanes[listed.method, listed.lane] = _score_lane(listed, own, plan)
    methods = list(dict.fromkeys(method for method, _ in lanes))
    groups = [
        _score_group(
            stratum, method, names, [lanes[method, one] for one in near if (method, one) in lanes]
        )
        for stratum, names, near in _strata(plan, targets)
        for method in methods
    ]
    return Score(groups, list(lanes.values()))


def _strata(plan: Plan, targets: Sequence[Target]) -> Iterator[Tuple[str, List[str], List[str]]]:
    """Yield what targets are counted together, and the lanes whose false alarms go with them."""
    yield "", [one.target for one in targets], list(plan.lanes)
    for column in plan.strata:
        of_lanes = {
            name: one.notes[column] for name, one in plan.lanes.items() if column in one.notes
        }
        values = [of_lanes.get(one.lane) if of_lanes else one.cells[column] for one in targets]
        for value in sorted({*values, *of_lanes.values()}, key=str):
            names = [one.target for one, own in zip(targets, values) if own == value]
            # A value of a lane limits the false alarms, one of a target does not.
            near = [one for one in plan.lanes if not of_lanes or of_lanes.get(one) == value]
            yield f"{column} {value}", names, near


def _score_lane(listed: MarkList, targets: Sequence[Target], plan: Plan) -> LaneScore:
    lane = plan.lanes[listed.lane]
    found: Dict[str, Optional[Mark]] = {one.target: None for one in targets}
    alarms: List[Mark] = []
    outside: List[Mark] = []
    for mark in sorted(listed.marks, key=lambda one: one.rank):
        place_m = mark.x_m, mark.y_m
        near = [(math.dist(place_m, one.place_m), one.target) for one in targets]
        distance_m, name = min(near, default=(math.inf, ""))
        if distance_m <= plan.halo_m:
            found[name] = found[name] or mark
        else:
            (alarms if lane.contains(place_m) else outside).append(mark)
    area_m2 = lane.area_outside([one.place_m for one in targets], plan.halo_m)
    return LaneScore(listed, area_m2, found, alarms, outside)


def _score_group(
    stratum: str, method: str, names: Sequence[str], lanes: Sequence[LaneScore]
) -> GroupScore:
    best = [mark for lane in lanes for name, mark in lane.found.items() if name in names]
    false = [mark for lane in lanes for mark in lane.alarms]
    targets, area_m2 = len(best), sum(lane.area_m2 for lane in lanes)
    found, alarms = sum(map(counts, best)), sum(map(counts, false))
    low, high = statistics.alarm_interval(alarms, area_m2)
    return GroupScore(
        stratum=stratum,
        method=method,
        targets=targets,
        found=found,
        detection=found / targets if targets else None,
        detection_range=statistics.detection_interval(found, targets),
        detection_shown=statistics.shown_detection(found, targets),
        alarms=alarms,
        area_m2=area_m2,
        alarms_per_m2=alarms / area_m2 if area_m2 > 0.0 else None,
        alarms_range=(low, high if math.isfinite(high) else None),
        curve=_curve([one for one in best if one], false, targets, area_m2),
    )


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

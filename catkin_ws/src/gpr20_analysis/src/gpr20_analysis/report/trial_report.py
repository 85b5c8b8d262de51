"""The score of a trial as a report: tables, warnings and curves; never a word on other ground."""

from __future__ import annotations

import itertools
from typing import Any, Dict, List, Optional, Tuple

from gpr20_analysis.report.records import Report, Section
from gpr20_analysis.trial.documents import Plan
from gpr20_analysis.trial.score import GroupScore, LaneScore, Score, counts
from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.message import Message
from gpr20_survey.results.candidates import SIMULATED

FOOTER = Message(
    "A trial counts targets that were buried for it. It says nothing about any other ground."
)
NO_PD = Message("PD cannot be known from this: nobody looked where no candidate is.")
LEAST_PART = 0.95  # of the area of a lane; where it is less, false alarms per m2 are too few
HEADING = Message("stratum|method|found|PD|interval|PD shown|false alarms|m2|per m2|interval")


def trial_report(
    plan: Optional[Plan], score: Score, language: Language, catalogue: Catalogue
) -> Report:
    """Return the report of a score, without figures; without a plan it is of what was found."""
    title, warnings, lines = Message("What was found at candidates"), [NO_PD], []
    if plan is not None:
        title, warnings = Message("Trial {plan}", plan=plan.sha256[:16]), warnings_of(plan, score)
        promise = Message(
            "The truth is as promised in the plan of {time}. Halo radius {halo_m:g} m. Intervals: "
            "Clopper-Pearson, Poisson. PD shown: one-sided, 95 %. A stratum of targets has the "
            "false alarms of all lanes.",
            **{"time": plan.made[:16], "halo_m": plan.halo_m},
        )
        lines = [catalogue.text(promise)]
    lines += [
        catalogue.tr(
            "{targets} targets, {only_first} found only by {first}, {only_second} only by "
            "{second}: p = {p_value:.3g} (McNemar, exact).",
            **vars(one),
        )
        for one in score.comparisons
    ]
    lists = [
        catalogue.tr(
            "{method}, {lane}: {operator} {made:.16} SHA-256 {sha256:.12}; missed: {missed}; false "
            "alarms, also doubtful ones: {alarms}; not counted: {outside}.",
            **_lane_values(one),
        )
        for one in score.lanes
    ]
    rows = [_row(one, catalogue.tr("all targets")) for one in score.groups]
    heading, said = catalogue.text(HEADING).split("|"), list(map(catalogue.text, warnings))
    first = Section(catalogue.tr("Score"), "", said, lines, rows, tuple(heading))
    second = Section(catalogue.tr("Sealed lists"), lines=lists)
    simulated = any(one.seal.simulated for one in score.lanes)
    marks = (catalogue.tr("SIMULATED"), catalogue.text(SIMULATED)) if simulated else ("", "")
    return Report(catalogue.text(title), [first, second], language, *marks, catalogue.text(FOOTER))


def warnings_of(plan: Plan, score: Score) -> List[Message]:
    """Return which lanes a method did not survey, or not all of."""
    areas_m2 = {(one.seal.method, one.seal.lane): one.seal.area_m2 for one in score.lanes}
    pairs = itertools.product(dict.fromkeys(method for method, _ in areas_m2), plan.lanes)
    return [
        Message(
            "{method} surveyed only {m2:.3g} m2 of lane {lane}: do not compare its totals with "
            "those of others (Simpson's paradox).",
            **{"method": method, "m2": areas_m2.get((method, lane), 0.0), "lane": lane},
        )
        for method, lane in pairs
        if areas_m2.get((method, lane), 0.0) < LEAST_PART * plan.lanes[lane].area_m2
    ]


def _row(one: GroupScore, everything: str) -> Tuple[str, ...]:
    return (
        *(one.stratum or everything, one.method, f"{one.found}/{one.targets}"),
        *(_numbers(one.detection), _numbers(*one.detection_range), _numbers(one.detection_shown)),
        *(str(one.alarms), f"{one.area_m2:.2f}"),
        *(_numbers(one.alarms_per_m2), _numbers(*one.alarms_range)),
    )


def _lane_values(one: LaneScore) -> Dict[str, Any]:
    return {
        **{key: getattr(one.seal, key) for key in ("method", "lane", "operator", "made", "sha256")},
        "missed": " ".join(name for name, mark in one.found.items() if not counts(mark)) or "-",
        "alarms": " ".join(mark.id for mark in one.alarms) or "-",
        "outside": " ".join(mark.id for mark in one.outside) or "-",
    }


def _numbers(*values: Optional[float]) -> str:
    return " \u2013 ".join("-" if one is None else f"{one:.3f}" for one in values)

"""The score of a trial as a report: table, warnings and curves; never a word on other ground."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from gpr20_analysis.report.page import Report, Section
from gpr20_analysis.trial.plan import Plan
from gpr20_analysis.trial.score import GroupScore, LaneScore, Score, counts
from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.message import Message
from gpr20_survey.results.candidates import SIMULATED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTICE = Message(
    "A trial counts targets that were buried for it. It says nothing about any other ground."
)
HEADING = Message("stratum|method|found|PD|interval|PD shown|false alarms|m2|per m2|interval")
LEAST_PART = 0.95  # of the area of a lane; where it is less, false alarms per m2 are too few


def trial_report(plan: Plan, score: Score, language: Language, catalogue: Catalogue) -> Report:
    """Return the report of a score, without figures."""
    promise = catalogue.tr(
        "The truth is the one whose SHA-256 is in the plan: {sum}. Halo radius {halo_m:g} m. "
        "Intervals: 95 %, Clopper-Pearson, Poisson. PD shown: one-sided, 95 %. A stratum of "
        "targets has the false alarms of all lanes.",
        **{"sum": plan.truth_sha256[:16], "halo_m": plan.halo_m},
    )
    lists = [
        catalogue.tr(
            "{method}, {lane}: missed: {missed}; false alarms, also weaker echoes: {alarms}; not "
            "counted: {outside}.",
            **_lane_values(one),
        )
        for one in score.lanes
    ]
    first = Section(
        catalogue.tr("Score"),
        catalogue.text(NOTICE),
        warnings=list(map(catalogue.text, _warnings(plan, score))),
        lines=[promise, *lists],
        heading=tuple(catalogue.text(HEADING).split("|")),
        rows=[_row(one, catalogue.tr("all targets")) for one in score.groups],
    )
    simulated = any(one.listed.simulated for one in score.lanes)
    banner = catalogue.text(SIMULATED) if simulated else ""
    title = catalogue.tr("Trial {plan}", plan=plan.truth_sha256[:16])
    return Report(title, [first], language, banner)


def _warnings(plan: Plan, score: Score) -> List[Message]:
    """Return which lanes a method has no list of, or surveyed only a part of."""
    areas_m2 = {(one.listed.method, one.listed.lane): one.listed.area_m2 for one in score.lanes}
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
        "method": one.listed.method,
        "lane": one.listed.lane,
        "missed": " ".join(name for name, mark in one.found.items() if not counts(mark)) or "-",
        "alarms": " ".join(mark.id for mark in one.alarms) or "-",
        "outside": " ".join(mark.id for mark in one.outside) or "-",
    }


def _numbers(*values: Optional[float]) -> str:
    return " \u2013 ".join("-" if one is None else f"{one:.3f}" for one in values)


def froc_figure(groups: Sequence[GroupScore], catalogue: Catalogue) -> Figure:
    """Draw the share of all targets that each method found over its false alarms per m2.

    A dot with its intervals is what counts; the curve also has what is below the cut of a list.
    """
    from gpr20_analysis.plotting.style import HEIGHT_IN, WIDTH_IN, noted_figure  # optional library

    title = catalogue.tr("FROC with intervals (95 %)")
    figure = noted_figure((2.0 * WIDTH_IN, 1.3 * HEIGHT_IN), title, [])
    axes = figure.subplots()
    axes.set_xlabel(catalogue.tr("false alarms per m2"))
    axes.set_ylabel(catalogue.tr("share of targets found"))
    axes.set_ylim(0.0, 1.03)
    for at, one in enumerate(own for own in groups if not own.stratum):
        axes.step(*np.transpose(one.curve), where="post", color=f"C{at}", label=one.method)
        if one.detection is not None and one.alarms_per_m2 is not None:
            place = one.alarms_per_m2, one.detection
            ends = np.array([one.detection_range, one.alarms_range])
            up_down, aside = np.abs(ends - [place[1:], place[:1]])[..., None]
            axes.errorbar(*place, yerr=up_down, xerr=aside, fmt="o", color=f"C{at}", capsize=3)
    axes.legend()
    return figure

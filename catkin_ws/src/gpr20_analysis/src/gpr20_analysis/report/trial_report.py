"""The score of a trial as a report: tables, warnings and curves; never a word on other ground."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_analysis.report.records import Report, Section
from gpr20_analysis.trial.plan import Plan
from gpr20_analysis.trial.score import MISSED, UNKNOWN, GroupScore, LaneScore, Score
from gpr20_analysis.trial.seal import Mark, Seal
from gpr20_analysis.trial.statistics import alarm_interval, detection_interval, targets_needed
from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.message import Message
from gpr20_survey.no_clearance import SIMULATED
from gpr20_survey.results.found import LABELS, What

FORMAT = "gpr20-trial-score/1"
FOOTER = Message(
    "A trial counts targets that were buried for it. It says nothing about any other ground."
)
LEAST_PART = 0.95
"""Of the area of a lane; where less was surveyed, false alarms per m2 are too few."""
ALL, METHOD, INTERVAL = Message("all targets"), Message("method"), Message("95 % interval")
GROUP_HEADING = (
    *(Message("stratum"), METHOD, Message("found"), Message("PD"), INTERVAL, Message("PD shown")),
    *(Message("false alarms"), Message("m2"), Message("per m2"), INTERVAL),
)
LANE_HEADING = (
    *(METHOD, Message("lane"), Message("sealed"), Message("operator"), Message("SHA-256")),
    *(Message("missed targets"), Message("false alarms, (doubtful)"), Message("outside the lane")),
)


def score_record(plan: Plan, score: Score) -> Dict[str, Any]:
    """Return a score as JSON holds it; None for what is not known."""
    return {
        "format": FORMAT,
        "warning": str(FOOTER),
        "plan_sha256": plan.sha256,
        "simulated": any(one.seal.simulated for one in score.lanes),
        "warnings": [str(one) for one in warnings_of(plan, score)],
        **asdict(score),
    }


def trial_report(plan: Plan, score: Score, language: Language, catalogue: Catalogue) -> Report:
    """Return the report of a score, without figures; its first section is the score."""
    lines = [
        Message(
            "Halo radius {halo_m:g} m. Intervals: Clopper-Pearson, Poisson. PD shown: one-sided, "
            "95 %; the plan asks for {detection:g}. A stratum of targets has the false alarms of "
            "all lanes.",
            halo_m=plan.halo_m,
            detection=plan.detection,
        ),
        Message(
            "The truth is as promised in the plan of {time}; it was known by {who}.",
            time=plan.made[:16],
            who=", ".join(plan.truth_known_by) or "-",
        ),
    ]
    lines += [
        Message(
            "{targets} targets, {only_first} found only by {first}, {only_second} only by "
            "{second}: p = {p_value:.3g} (McNemar, exact).",
            **asdict(one),
        )
        for one in score.comparisons
    ]
    first, second = Section(catalogue.tr("Score")), Section(catalogue.tr("Sealed lists"))
    first.warnings = [catalogue.text(one) for one in warnings_of(plan, score)]
    first.lines = [*map(catalogue.text, lines), *plan.notes.splitlines()]
    first.heading = tuple(map(catalogue.text, GROUP_HEADING))
    first.rows = [_group_row(one, catalogue) for one in score.groups]
    second.heading = tuple(map(catalogue.text, LANE_HEADING))
    second.rows = [_lane_row(one) for one in score.lanes]
    simulated = any(one.seal.simulated for one in score.lanes)
    title = catalogue.tr("Trial {plan}", plan=plan.sha256[:16])
    return _report(title, [first, second], simulated, language, catalogue)


def found_report(
    listed: Seal, counts: Mapping[str, int], language: Language, catalogue: Catalogue
) -> Report:
    """Return the report of what was found at the candidates of a list; see `score_found`."""
    looked, devices = sum(counts[one.value] for one in What), counts[What.DEVICE.value]
    area_m2, share = listed.area_m2 or 0.0, detection_interval(devices, looked)
    alarms = alarm_interval(looked - devices, area_m2)
    lines = [
        Message(
            "Share of devices where somebody looked: {range} (95 %).", range=_range(share, _share)
        ),
        Message(
            "Known false alarms per m2 of the survey: {range} (95 %).",
            range=_range(alarms) if area_m2 else "-",
        ),
        Message("PD cannot be known from this: nobody looked where no candidate is."),
    ]
    rows = [(catalogue.text(label), str(counts[one.value])) for one, label in LABELS.items()]
    rows.append((catalogue.tr("not looked at"), str(counts[UNKNOWN])))
    rows.append((catalogue.tr("devices where no candidate is"), str(counts[MISSED])))
    title = catalogue.tr("What was found at candidates")
    section = Section(title, lines=[catalogue.text(one) for one in lines], rows=rows)
    return _report(title, [section], listed.simulated, language, catalogue)


def warnings_of(plan: Plan, score: Score) -> List[Message]:
    """Return what must be known before the numbers are believed."""
    needed, warnings = targets_needed(plan.detection), []
    few = sum(one.targets < needed for one in score.groups)
    if few:
        few_targets = Message(
            "Too few targets to show a PD of {detection:g} in {few} of {rows} rows: it takes "
            "{needed} that are all found.",
            **{"detection": plan.detection, "few": few, "rows": len(score.groups)},
            needed=needed,
        )
        warnings.append(few_targets)
    warnings += [
        Message(
            "The targets of {first} and {second} have other shares in the strata: compare them in "
            "each stratum, not in all (Simpson's paradox).",
            first=one.first,
            second=one.second,
        )
        for one in score.comparisons
        if not one.same_shares
    ]
    listed = {(one.seal.method, one.seal.lane): one.seal.area_m2 for one in score.lanes}
    for method in dict.fromkeys(method for method, _ in listed):
        for name, lane in plan.lanes.items():
            values = {"method": method, "lane": name}
            area_m2 = listed.get((method, name))
            if (method, name) not in listed:
                warnings.append(Message("{method} has no sealed list of lane {lane}.", **values))
            elif area_m2 is not None and area_m2 < LEAST_PART * lane.area_m2:
                part = Message(
                    "{method} surveyed only {m2:.3g} m2 of lane {lane}.", **values, m2=area_m2
                )
                warnings.append(part)
    return warnings


def report_lines(report: Report) -> List[str]:
    """Return a report as lines of text."""
    lines = [one for one in (report.title, report.banner) if one]
    for section in report.sections:
        lines += ["", section.title, *section.warnings, *section.lines]
        table = [*([section.heading] if section.heading else []), *section.rows]
        widths = [max(map(len, column)) for column in zip(*table)]
        lines += ["  ".join(map(str.ljust, row, widths)).rstrip() for row in table]
    return [*lines, "", report.footer]


def _report(
    title: str, sections: List[Section], simulated: bool, language: Language, catalogue: Catalogue
) -> Report:
    marks = (catalogue.tr("SIMULATED"), catalogue.text(SIMULATED)) if simulated else ("", "")
    return Report(title, sections, language, *marks, catalogue.text(FOOTER))


def _group_row(one: GroupScore, catalogue: Catalogue) -> Tuple[str, ...]:
    share = (
        _share(one.detection),
        _range(one.detection_range, _share),
        _share(one.detection_shown),
    )
    alarms = (str(one.alarms), f"{one.area_m2:.2f}", _number(one.alarms_per_m2))
    name = one.stratum or catalogue.text(ALL)
    found = f"{one.found}/{one.targets}"
    return (name, one.method, found, *share, *alarms, _range(one.alarms_range))


def _lane_row(one: LaneScore) -> Tuple[str, ...]:
    seal, missed = one.seal, " ".join(one.missed) or "-"
    head = (seal.method, seal.lane, seal.sealed[:16], seal.operator, seal.sha256[:12])
    return (*head, missed, _ids(one.alarms), _ids(one.outside))


def _ids(marks: Sequence[Mark]) -> str:
    return " ".join(f"({one.id})" if one.doubtful else one.id for one in marks) or "-"


def _share(value: Optional[float]) -> str:
    return "-" if value is None else f"{value:.3f}"


def _number(value: Optional[float]) -> str:
    return "-" if value is None else f"{value:.3g}"


def _range(
    ends: Tuple[Optional[float], ...], shown: Callable[[Optional[float]], str] = _number
) -> str:
    return " \u2013 ".join(map(shown, ends))

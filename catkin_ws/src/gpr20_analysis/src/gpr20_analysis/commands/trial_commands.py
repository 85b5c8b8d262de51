"""gpr20 trial: score lists of candidates against the truth that the plan of a trial seals."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import outputs
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.report.page import HTML, save_report
from gpr20_analysis.report.trial_report import froc_figure, trial_report
from gpr20_analysis.trial.plan import read_list, read_plan, read_truth
from gpr20_analysis.trial.score import score_trial
from gpr20_common.catalogue import Catalogue, language_from_code
from gpr20_common.terminal_text import say

JSON, FORMAT = ".json", "gpr20-trial-score/1"


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("plan", type=Path, metavar="PLAN.yaml", help="halo, lanes, strata, SHA-256 of the truth")
    add("--truth", type=Path, required=True, metavar="TARGETS.csv", help="the table of targets")
    add("--list", nargs=3, action="append", required=True, metavar=("METHOD", "LANE", "LIST"),
        help="list of gpr20 candidates (.json), or any (.csv); once per method and "
        "lane")  # fmt: skip
    outputs.add_output(parser, [HTML, JSON], f"report: {HTML} or {JSON}")


def _score(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    output, paths = chosen.output, [Path(one) for _method, _lane, one in chosen.list]
    read = [chosen.plan, chosen.truth, *paths]
    outputs.check([output] if output else [], read, chosen.overwrite)
    plan = read_plan(chosen.plan)
    targets = read_truth(chosen.truth, plan)
    lists = [read_list(method, lane, Path(one), plan) for method, lane, one in chosen.list]
    score = score_trial(plan, targets, lists)
    report = trial_report(plan, score, language_from_code(chosen.language), catalogue)
    (section,) = report.sections
    rows = [" | ".join(row) for row in (section.heading, *section.rows)]
    notices = [*filter(None, [report.banner]), section.notice, *section.warnings]
    say(report.title, *notices, *section.lines, *rows)
    if output is not None and output.suffix == JSON:
        values = {"format": FORMAT, "warnings": notices, **asdict(score)}
        with atomic_output(output) as place:
            place.write_text(json.dumps(values, indent=2, allow_nan=False), encoding="utf-8")
    elif output is not None:
        section.figures.append(froc_figure(score.groups, catalogue))
        save_report(report, output)
    return DONE


TRIAL = Command(
    "Score lists of candidates against buried targets that nobody knew who measured. A trial says "
    "how many of its own targets were found; it says nothing about any other ground.",
    _add_arguments,
    _score,
)

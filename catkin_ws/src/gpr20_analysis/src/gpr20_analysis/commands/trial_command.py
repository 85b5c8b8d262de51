"""gpr20 trial: plan a blind trial, seal lists of candidates, and score them against the truth."""

from __future__ import annotations

import argparse
import json
import os
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Union

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import outputs
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import AnalysisError, ExportError, wrong_ending
from gpr20_analysis.read.checks import found_in
from gpr20_analysis.report.build import HTML, PDF, save_report
from gpr20_analysis.report.trial_report import trial_report
from gpr20_analysis.trial import documents
from gpr20_analysis.trial.documents import Plan, Seal, read_candidates, read_plan
from gpr20_analysis.trial.ground import groups_of, read_lanes, read_targets
from gpr20_analysis.trial.score import Score, score_found, score_trial
from gpr20_analysis.trial.statistics import targets_needed
from gpr20_common.catalogue import Catalogue, language_from_code
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.files.durable_files import write_new_file
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.folder.recovery import recover
from gpr20_survey.trace import utc_time

JSON, FORMAT = ".json", "gpr20-trial-score/1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(metavar="ACTION", dest="action", required=True)
    add = actions.add_parser("plan", help="agree on all before anybody measures").add_argument
    add("lanes", type=Path, metavar="LANES.csv", help="lanes and their soil")
    add("targets", type=Path, metavar="TARGETS.csv", help="the truth, which stays secret")
    add("--halo", type=float, required=True, metavar="M", help="radius around a target [m]")
    add("--strata", default="type", metavar="COLUMN,...", help="columns that divide the score")
    add("--output", "-o", type=Path, required=True, metavar="PLAN.json")
    add = actions.add_parser("seal", help="seal a list before the truth opens").add_argument
    add("plan", type=Path, metavar="PLAN.json")
    add("candidates", type=Path, help="list of gpr20 candidates (.json), or any (.csv)")
    add("--lane", required=True, metavar="NAME", help="lane of the plan")
    add("--method", required=True, metavar="NAME", help="such as the device and its settings")
    add("--operator", required=True, metavar="NAME", help="who measured")
    add("--output", "-o", type=Path, required=True, metavar="SEALED.json")
    score = actions.add_parser("score", help="compare sealed lists with the truth")
    add = score.add_argument
    add("plan", type=Path, metavar="PLAN.json", help="with --found: a list of candidates")
    add("lists", type=Path, nargs="*", metavar="SEALED.json", help="sealed lists")
    add("--truth", type=Path, metavar="TARGETS.csv", help="with its salt beside it")
    add("--found", type=Path, metavar="SURVEY", help="what gpr20 found noted, not a truth")
    add("--halo", type=float, metavar="M", help="with --found: how near a record must be [m]")
    add("--output", "-o", type=Path, help=f"report: {HTML}, {PDF} or {JSON}")
    outputs.add_overwrite(score)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Do one of the three; return the exit status."""
    {"plan": _plan, "seal": _seal, "score": _score}[chosen.action](chosen, catalogue)
    return DONE


def _plan(chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    truth, strata = read_regular(chosen.targets), tuple(chosen.strata.split(","))
    lanes = read_lanes(read_regular(chosen.lanes), chosen.lanes.name)
    targets = read_targets(truth, chosen.targets.name, lanes, strata)
    plan = Plan(chosen.halo, strata, lanes)
    # Only when everything is allowed, a salt is made.
    promise = documents.promise_of(documents.salt_of(chosen.targets), truth)
    plan = replace(plan, truth_sha256=promise)
    _write(chosen.output, documents.PLAN, plan, catalogue)
    secret = catalogue.tr(
        "Keep {truth} and its file {salt} together and secret until all lists are sealed. A PD of "
        "0.9 takes {needed} targets that are all found; there are:",
        **{"truth": chosen.targets, "salt": documents.SALT, "needed": targets_needed(0.9)},
    )
    groups, everything = groups_of(strata, targets, lanes), catalogue.tr("all targets")
    say(secret, *(f"{len(one.targets):6}  {one.name or everything}" for one in groups))


def _seal(chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    plan = read_plan(chosen.plan)
    if chosen.lane not in plan.lanes:
        lanes = ", ".join(plan.lanes)
        unknown = Message("there is no lane {lane}; write {lanes}", lane=chosen.lane, lanes=lanes)
        raise AnalysisError(unknown)
    own = {name: getattr(chosen, name).strip() for name in ("method", "lane", "operator")}
    for name in (one for one, text in own.items() if not text):
        raise AnalysisError(Message("--{option} is blank; write a name", option=name))
    listed = read_candidates(chosen.candidates)
    area_m2 = listed.area_m2 or plan.lanes[chosen.lane].area_m2
    sealed = replace(listed, plan_sha256=plan.sha256, area_m2=area_m2, **own)
    _write(chosen.output, documents.SEAL, sealed, catalogue)


def _score(chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    output, plan = chosen.output, None
    if output is not None:
        if output.suffix not in (HTML, PDF, JSON):
            raise ExportError(wrong_ending(output, (HTML, PDF, JSON)))
        outputs.check([Output(output)], [chosen.plan, *chosen.lists], chosen.overwrite)
    if chosen.truth is not None and chosen.lists and chosen.found is None:
        plan = read_plan(chosen.plan)
        seals = [documents.read_seal(one) for one in chosen.lists]
        score = score_trial(plan, documents.read_truth(chosen.truth, plan), seals)
    else:
        score = _score_found(chosen)
    report = trial_report(plan, score, language_from_code(chosen.language), catalogue)
    first, second = report.sections
    rows = [" | ".join(row) for row in (first.heading, *first.rows)]
    said = (*first.warnings, *first.lines, *rows, *second.lines, report.footer)
    say(*filter(None, (report.title, report.banner, *said)))
    if output is None:
        return
    if output.suffix == JSON:
        warnings = [*filter(None, [report.banner]), *first.warnings, report.footer]
        values = {"format": FORMAT, "warnings": warnings, **asdict(score)}
        with atomic_output(output) as place:
            place.write_text(json.dumps(values, indent=2, allow_nan=False), encoding="utf-8")
        return
    if plan is not None:
        from gpr20_analysis.plotting.froc import froc_figure  # its library is optional

        drawn = [one for one in score.groups if one.targets or not one.stratum]
        figure = froc_figure(drawn, [report.banner] if report.banner else [], catalogue)
        first.figures.append((catalogue.tr("FROC with intervals (95 %)"), figure))
    save_report(report, output, catalogue)


def _score_found(chosen: argparse.Namespace) -> Score:
    if None in (chosen.found, chosen.halo) or chosen.lists or chosen.truth:
        wanted = Message("give plan, sealed lists and --truth; or one list, --found and --halo")
        raise AnalysisError(wanted)
    listed = read_candidates(chosen.plan)
    recovered = recover(chosen.found)
    if listed.survey_id not in ("", recovered.survey_id):
        raise AnalysisError(
            Message(
                "{file} is of another survey; give a list of {survey}",
                file=chosen.plan,
                survey=chosen.found,
            )
        )
    halo_m = Plan(chosen.halo, (), {}).halo_m  # within the limits of a plan
    listed = replace(listed, method=chosen.plan.name, lane=chosen.found.name)
    return score_found(listed, found_in(recovered.found.records), halo_m)


def _write(path: Path, form: str, record: Union[Plan, Seal], catalogue: Catalogue) -> None:
    if os.path.lexists(path):
        exists = Message("{path} exists and is never replaced; choose another name", path=path)
        raise ExportError(exists)
    outputs.check([Output(path)], [], overwrite=False)  # no survey's folder
    now = utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)
    content = documents.encode(form, {**asdict(record), "made": now})
    write_new_file(path, content)
    own = json.loads(content)["sha256"]
    say(catalogue.tr("Note this SHA-256 where nobody can change it: {sum}", sum=own))


COMMAND = Command(
    "Score candidates against buried targets that nobody knew who measured. A trial says how many "
    "of its own targets were found; it says nothing about any other ground.",
    add_arguments,
    run,
)

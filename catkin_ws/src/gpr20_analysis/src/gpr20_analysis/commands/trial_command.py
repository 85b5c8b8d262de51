"""gpr20 trial: plan a blind trial, seal lists of candidates, and score them against the truth."""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import outputs
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.commands.outputs import Output
from gpr20_analysis.errors import AnalysisError, ExportError, wrong_ending
from gpr20_analysis.report.build import HTML, PDF, save_report
from gpr20_analysis.report.trial_report import (
    found_report,
    report_lines,
    score_record,
    trial_report,
)
from gpr20_analysis.trial import hashed_file, statistics
from gpr20_analysis.trial.ground import groups_of, read_lanes, read_targets
from gpr20_analysis.trial.plan import SALT, Plan, promise_of, read_plan, read_truth, salt_of
from gpr20_analysis.trial.score import score_found, score_trial
from gpr20_analysis.trial.seal import read_candidates, read_seal
from gpr20_common.catalogue import Catalogue
from gpr20_common.low.catalogue_file import language_from_code
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.files.regular_file import read_regular
from gpr20_survey.folder.found_records import read_found
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.results.found import present
from gpr20_survey.trace import utc_time

JSON = ".json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    actions = parser.add_subparsers(metavar="ACTION", dest="action", required=True)
    plan = actions.add_parser("plan", help="agree on everything before anybody measures")
    add = plan.add_argument
    add("lanes", type=Path, metavar="LANES.csv", help="lanes and their soil")
    add("targets", type=Path, metavar="TARGETS.csv", help="the truth, which stays secret")
    add("--halo", type=float, required=True, metavar="M", help="radius around a target [m]")
    add("--strata", default="type", metavar="COLUMN,...",
        help="columns of both tables that divide the score: type,depth_m,soil")  # fmt: skip
    add("--pd", type=float, default=0.9, help="probability of detection to show (default 0.9)")
    add("--with-doubtful", action="store_true", help="doubtful candidates count too")
    add("--notes", default="", metavar="TEXT", help="about the methods")
    add("--truth-known-by", action="append", default=[], metavar="NAME", help="may be repeated")
    add("--output", "-o", type=Path, required=True, metavar="PLAN.json")
    seal = actions.add_parser("seal", help="seal a list of candidates before the truth opens")
    add = seal.add_argument
    add("plan", type=Path, metavar="PLAN.json")
    add("candidates", type=Path, help="list of gpr20 candidates (.json), or any (.csv)")
    add("--lane", required=True, metavar="NAME", help="lane of the plan")
    add("--method", required=True, metavar="NAME", help="such as the device and its settings")
    add("--operator", required=True, metavar="NAME", help="who measured")
    add("--output", "-o", type=Path, required=True, metavar="SEALED.json")
    score = actions.add_parser("score", help="compare sealed lists with the truth")
    add = score.add_argument
    add("files", type=Path, nargs="+", metavar="FILE",
        help="the plan and the sealed lists; with --found one list of candidates")  # fmt: skip
    truth = score.add_mutually_exclusive_group(required=True)
    truth.add_argument("--truth", type=Path, metavar="TARGETS.csv", help="with its salt beside it")
    truth.add_argument("--found", type=Path, metavar="SURVEY",
        help="what gpr20 found noted in this survey, not a truth; needs --halo")  # fmt: skip
    add("--halo", type=float, metavar="M", help="with --found: how near a record must be [m]")
    add("--output", "-o", type=Path, help=f"report: {HTML}, {PDF} or {JSON}")
    outputs.add_overwrite(score)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Do one of the three; return the exit status."""
    action = {"plan": _plan, "seal": _seal, "score": _score}[chosen.action]
    action(chosen, catalogue)
    return DONE


def _plan(chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    truth = read_regular(chosen.targets)
    lanes = read_lanes(read_regular(chosen.lanes), chosen.lanes.name)
    targets = read_targets(truth, chosen.targets.name, lanes)
    strata = tuple(chosen.strata.split(","))
    groups = groups_of(strata, targets, lanes)
    plan = Plan(
        chosen.halo,
        strata,
        chosen.pd,
        chosen.with_doubtful,
        chosen.notes,
        tuple(chosen.truth_known_by),
        lanes,
        "",
        _now(),
    )
    # Only when everything is allowed, a salt is made.
    plan = replace(plan, truth_sha256=promise_of(salt_of(chosen.targets), truth))
    _write(chosen.output, plan.encode())
    needed = statistics.targets_needed(plan.detection)
    lines = [
        Message(
            "Keep {truth} and its file {salt} together and secret until all lists are sealed.",
            truth=chosen.targets,
            salt=SALT,
        ),
        Message(
            "A PD of {detection:g} takes {needed} targets that are all found; there are:",
            detection=plan.detection,
            needed=needed,
        ),
    ]
    say(*map(catalogue.text, lines))
    everything = catalogue.tr("all targets")
    say(*(f"{len(one.targets):6}  {one.name or everything}" for one in groups))
    _say_sum(read_plan(chosen.output).sha256, catalogue)


def _seal(chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    plan = read_plan(chosen.plan)
    plan.lane(chosen.lane)
    sealed = replace(
        read_candidates(chosen.candidates),
        plan_sha256=plan.sha256,
        method=chosen.method,
        lane=chosen.lane,
        operator=chosen.operator,
        sealed=_now(),
    )
    _write(chosen.output, sealed.encode())
    _say_sum(read_seal(chosen.output).sha256, catalogue)


def _score(chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    if chosen.output is not None:
        if chosen.output.suffix not in (HTML, PDF, JSON):
            raise ExportError(wrong_ending(chosen.output, (HTML, PDF, JSON)))
        outputs.check([Output(chosen.output)], chosen.files, chosen.overwrite)
    language = language_from_code(chosen.language)
    if chosen.found is not None:
        if len(chosen.files) != 1 or chosen.halo is None:
            raise AnalysisError(Message("with --found, give one list of candidates and --halo"))
        listed = read_candidates(chosen.files[0])
        if listed.survey_id not in ("", read_description(chosen.found)["survey_id"]):
            raise AnalysisError(Message("{file} is of another survey", file=chosen.files[0]))
        counts = score_found(listed, present(read_found(chosen.found)), chosen.halo)
        report, record = found_report(listed, counts, language, catalogue), {"counts": counts}
    else:
        plan = read_plan(chosen.files[0])
        seals = [read_seal(one) for one in chosen.files[1:]]
        if not seals:
            raise AnalysisError(Message("give the plan, then one or more sealed lists"))
        score = score_trial(plan, read_truth(chosen.truth, plan), seals)
        report = trial_report(plan, score, language, catalogue)
        record = score_record(plan, score)
    say(*report_lines(report))
    if chosen.output is None:
        return
    if chosen.output.suffix != JSON and chosen.found is None:
        from gpr20_analysis.plotting.froc import froc_figure  # its library is optional

        figure = froc_figure(score.groups, [one for one in (report.banner,) if one], catalogue)
        report.sections[0].figures.append((catalogue.tr("FROC, 95 % intervals"), figure))
    if chosen.output.suffix == JSON:
        with atomic_output(chosen.output) as place:
            place.write_text(json.dumps(record, indent=2, allow_nan=False), encoding="utf-8")
    else:
        save_report(report, chosen.output, catalogue)


def _write(path: Path, content: bytes) -> None:
    if not path.exists():
        outputs.check([Output(path)], [], overwrite=False)  # no survey's folder
    hashed_file.write_once(path, content)


def _now() -> str:
    return utc_time.iso_text(time.time_ns() // utc_time.NS_PER_US)


def _say_sum(own: str, catalogue: Catalogue) -> None:
    say(catalogue.tr("Note this SHA-256 where nobody can change it: {sum}", sum=own))


COMMAND = Command(
    "Score candidates against buried targets that nobody knew who measured. A trial says how many "
    "of its own targets were found; it says nothing about any other ground.",
    add_arguments,
    run,
)

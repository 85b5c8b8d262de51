"""gpr20 batch: one command on many surveys, side by side."""

from __future__ import annotations

import argparse
import copy
import json
import re
import shlex
from pathlib import Path
from typing import Any, Dict, Iterator, List, Sequence, Tuple

from gpr20_analysis.atomic_output import BESIDE
from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.batch_work import (
    Job,
    Outcome,
    connected,
    earlier,
    outcomes,
    standard_workers,
    unfinished_folder,
)
from gpr20_analysis.commands.command import DAMAGED, DONE, NOT_COMPLETE, Command, load
from gpr20_analysis.commands.failure import first_steps
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.conversion import EXPORTS
from gpr20_analysis.sentences import json_fields, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.folder.survey_folder import LOG_FILE, TRACES_FOLDER

FAILURE = 1
ENDINGS = {
    "report": ".html",
    "image": ".nc",
    "candidates": ".csv",
    "process": ".nc",
    "plot": ".png",
    "export": "",
}
"""The commands that make one result of one survey, and its usual ending."""
OF_ONE_SURVEY = ("figures", "publish", "save_recipe")
"""Options whose effect would be the same place for every survey."""
FAILED = "failed"
STATES = {
    "done": Message("done"),
    "not_complete": Message("done, survey not complete"),
    "damaged": Message("done, survey damaged"),
    "exists": Message("exists already"),
    "exists_not_complete": Message("exists already, survey not complete"),
    "exists_damaged": Message("exists already, survey damaged"),
    FAILED: Message("failed"),
}
"""What becomes of a survey: its name for programs and for people."""
MADE = {DONE: "done", NOT_COMPLETE: "not_complete", DAMAGED: "damaged"}
FOUND = {DONE: "exists", NOT_COMPLETE: "exists_not_complete", DAMAGED: "exists_damaged"}
RECORDINGS = ("*.mcap", "*.bag")
PLACE = "/result"
"""Stands for the survey and the result where the command's options are read."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("survey", type=Path, nargs="+",
        help="survey as for other commands, a folder in which all survey folders are found, or "
        "one of recordings")  # fmt: skip
    add("--into", type=Path, required=True, metavar="FOLDER",
        help="folder of the results; each is named like its survey")  # fmt: skip
    add("--command", default="report", metavar="'COMMAND OPTIONS'",
        help=f"what to run, without survey and output: {', '.join(ENDINGS)}; default report; "
        "such as 'image --permittivity 4'")  # fmt: skip
    add("--ending", metavar=".ENDING", help="ending of the results, such as .pdf for reports")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N",
        help="surveys at a time; default: as many as this computer has processors and GiB of free "
        "memory")  # fmt: skip
    where.add_argument("--scheduler", metavar="ADDRESS",
        help="compute on a dask cluster, such as tcp://127.0.0.1:8786; its workers need this "
        "package, and surveys and results under the same paths")  # fmt: skip
    add("--overwrite", action="store_true",
        help="make results again that exist; otherwise those of the same command and the same "
        "state of the survey are kept")  # fmt: skip
    add("--json", action="store_true", help="print the outcome as JSON, for programs")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Run the command on each survey, print the table and return the exit status."""
    if chosen.workers is not None and chosen.workers < 1:
        raise _refused(Message("--workers is {count}; use 1 or more", count=chosen.workers))
    jobs = _jobs(chosen)
    ended: Dict[Job, Outcome] = {}
    if not chosen.overwrite:
        before = {job: earlier(job) for job in jobs}
        ended.update({job: outcome for job, outcome in before.items() if outcome is not None})
    left = [job for job in jobs if job not in ended]
    if left:
        progress = inputs.progress_bar("surveys")
        workers = connected(chosen.scheduler, chosen.workers or standard_workers(len(left)))
        with unfinished_folder(chosen.into.absolute()) as unfinished, workers as client:
            ended.update(progress(outcomes(client, left, unfinished), len(left)))
    rows = [(job, ended[job]) for job in jobs]
    if chosen.json:
        print(json.dumps({"surveys": [_record(*row) for row in rows]}, indent=2))
    else:
        _print(rows, catalogue)
    return FAILURE if any(outcome.error for outcome in ended.values()) else DONE


def _jobs(chosen: argparse.Namespace) -> List[Job]:
    command, call = _call(chosen)
    ending = chosen.ending
    if ending is None:
        ending = EXPORTS.find(call.format).ending if command == "export" else ENDINGS[command]
    elif not ending.startswith(".") or "/" in ending:
        raise _refused(
            Message(
                "--ending is {ending}; it begins with a dot and names no folder, such as .pdf",
                ending=repr(ending),
            )
        )
    jobs: Dict[Path, Job] = {}
    for given in chosen.survey:
        for survey, name in _surveys(given, chosen.into.absolute()):
            own = copy.copy(call)
            own.survey = survey.absolute()
            result = chosen.into.absolute() / f"{name}{ending}"
            if result in jobs:
                raise _refused(
                    Message(
                        "{first} and {second} would both become {result}; give the folder that "
                        "holds both, or another --into for one of them",
                        first=jobs[result].call.survey,
                        second=own.survey,
                        result=result,
                    )
                )
            jobs[result] = Job(name, result, command, own, _made_of(chosen.command, own.survey))
    return list(jobs.values())


def _surveys(given: Path, into: Path) -> Iterator[Tuple[Path, str]]:
    """Yield each survey at a path, and the name of its result."""
    below = [] if (given / LOG_FILE).exists() else sorted(given.rglob(LOG_FILE))
    # An import that is being written, or was cut off, is no survey.
    below = [one for one in below if not one.parent.parent.name.startswith(BESIDE)]
    # An export can look like a survey.
    found = [one for one in below if into not in one.absolute().parents]
    for described in found:
        yield described.parent, str(described.parent.relative_to(given))
    # A folder of recordings; one with traces is a survey whose description is lost.
    loose = [] if (given / TRACES_FOLDER).exists() else RECORDINGS
    recordings = [one for kind in loose for one in sorted(given.glob(kind)) if not below]
    for recording in recordings:
        yield recording, recording.stem
    if not found and not recordings:
        place = given.resolve()
        yield given, place.name if place.is_dir() else place.stem


def _made_of(command: str, survey: Path) -> str:
    """Return what a result is made of, in words that differ where it may differ."""
    # A running survey gets traces while its log stays as it is.
    parts = [survey, survey / LOG_FILE, survey / TRACES_FOLDER]
    # Of the files that the command names, such as a recipe or a model.
    parts += [Path(one) for word in shlex.split(command) for one in re.split("[=:,]", word) if one]
    changed_ns = max((one.stat().st_mtime_ns for one in parts if one.exists()), default=None)
    return f"{' '.join(shlex.split(command))} of {survey}, changed {changed_ns}"


def _call(chosen: argparse.Namespace) -> Tuple[str, argparse.Namespace]:
    """Return the command and its arguments, those of survey and output left open.

    Raises:
        AnalysisError: The command cannot be run on many surveys.
    """
    try:
        command, *options = shlex.split(chosen.command) or [""]
    except ValueError as error:
        raise _refused(
            Message(
                "--command is {command}; close its quotation",
                command=repr(chosen.command),
                details=error,
            )
        ) from error
    if command not in ENDINGS:
        raise _refused(
            Message(
                "--command begins with {command}; it must begin with one of: {allowed}",
                command=repr(command),
                allowed=", ".join(ENDINGS),
            )
        )
    loaded = load(command)
    parser = argparse.ArgumentParser(prog=f"gpr20 batch --command {command}")
    loaded.add_arguments(parser)
    # The output comes first: one among the options would be a second one, or replace it.
    places = [*options, PLACE, PLACE] if command == "export" else ["-o", PLACE, *options, PLACE]
    call = parser.parse_args(places)
    kept = [name for name in OF_ONE_SURVEY if getattr(call, name, None)]
    if call.output not in (Path(PLACE), [Path(PLACE)]):
        kept.append("output")
    if kept:
        raise _refused(
            Message(
                "--command has --{option}, which would be the same for every survey; leave it out",
                option=kept[0].replace("_", "-"),
            )
        )
    for name, value in vars(call).items():
        # Workers may have another working directory.
        if isinstance(value, Path):
            setattr(call, name, value.absolute())
    call.overwrite, call.json, call.language = True, False, chosen.language
    return command, call


def _refused(message: Message) -> AnalysisError:
    return AnalysisError(message, fault=NOT_ALLOWED)


def _state(outcome: Outcome) -> str:
    if outcome.error:
        return FAILED
    return (FOUND if outcome.seconds is None else MADE)[outcome.status]


def _record(job: Job, outcome: Outcome) -> Dict[str, Any]:
    record: Dict[str, Any] = {
        "survey": str(job.call.survey),
        "state": _state(outcome),
        "result": str(job.result) if job.result.exists() else None,
        "seconds": None if outcome.seconds is None else round(outcome.seconds, 3),
        "remarks": list(outcome.remarks),
    }
    if outcome.error:
        record["error"] = json_fields(outcome.error)
    return record


def _print(rows: Sequence[Tuple[Job, Outcome]], catalogue: Catalogue) -> None:
    title, time, result = catalogue.tr("survey"), catalogue.tr("s"), catalogue.tr("result")
    width = max(len(title), *(len(job.name) for job, _ in rows))
    say(f"{title:{width}}  {time:>8}  {result}")
    for job, outcome in rows:
        seconds = "" if outcome.seconds is None else f"{outcome.seconds:.1f}"
        state = catalogue.text(STATES[_state(outcome)])
        say(f"{job.name:{width}}  {seconds:>8}  {state}")
        for remark in outcome.remarks:
            say(f"    {remark}")
        if outcome.error:
            for line in [outcome.error, *first_steps(outcome.error)]:
                say(f"    {shown(line)}")


COMMAND = Command(
    "Run a command of gpr20 on many surveys side by side, by processes of this computer or by a "
    "dask cluster. The failure of one survey does not stop the others; a table at the end says "
    "what became of each.",
    add_arguments,
    run,
    "exit status: 0 all results are there, 1 a survey failed, 3 refused or failed; the table or "
    "the message gives the reason",
)

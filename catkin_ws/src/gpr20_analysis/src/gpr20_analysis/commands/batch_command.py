"""gpr20 batch: one command on many surveys, side by side, by the workers of dask."""

from __future__ import annotations

import argparse
import contextlib
import copy
import io
import json
import logging
import shlex
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterator, List, Optional, Sequence, Tuple

import dask
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, wait
from distributed import TimeoutError as DaskTimeoutError

from gpr20_analysis import faults
from gpr20_analysis.atomic_output import BESIDE, put
from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import DONE, Command, load
from gpr20_analysis.commands.failure import first_steps, message_of
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.exports import ENDINGS as EXPORTED
from gpr20_analysis.sentences import json_fields, shown
from gpr20_analysis.work import available_bytes, processors
from gpr20_common.catalogue import Catalogue, language_from_code, read_catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.folder.survey_folder import LOG_FILE, TRACES_FOLDER

FAILURE = 1
ENDINGS = {"report": ".html", "image": ".nc", "candidates": ".csv", "process": ".nc",
           "plot": ".png", "export": ""}  # fmt: skip
"""The commands that make one result of one survey, and its usual ending."""
OF_ONE_SURVEY = ("figures", "publish")
"""Options whose effect would be the same place for every survey."""
MADE = ("done", "not complete", "damaged")
"""States of a survey by the exit status of its command; the others are "exists" and "failed"."""
PLACE = "/result"
"""Stands for the survey and the result where the command's options are read."""
CONNECT_LIMIT_S = 10.0
WORKER_BYTES = 1 << 30
"""Memory that a survey of usual size needs."""
# A survey that waits behind another one would share the blame for a worker's death, and a busy
# computer may need more than the usual 15 s to start a worker again.
SETTINGS = {
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.scheduler.allowed-failures": 1,
    "distributed.deploy.lost-worker-timeout": "60s",
}
WITHOUT_CTRL_C = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
"""What a worker of this computer runs first: it is ended in order by the process it belongs to."""


@dataclass(frozen=True, eq=False)
class Job:
    """One survey: its name in the table, where the result is put, and the command's arguments."""

    name: str
    result: Path
    command: str
    call: argparse.Namespace


@dataclass(frozen=True)
class Outcome:
    """What became of a survey, after how long [s], what the command said, and why it failed."""

    state: str
    seconds: float = 0.0
    remarks: Tuple[str, ...] = ()
    error: Optional[Message] = None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("survey", type=Path, nargs="+",
        help="survey as for other commands, or a folder in which all survey folders are found",
        )  # fmt: skip
    add("--into", type=Path, required=True, metavar="FOLDER",
        help="folder of the results; each is named like its survey")  # fmt: skip
    add("--command", dest="work", type=shlex.split, default=["report"], metavar="'COMMAND OPTIONS'",
        help=f"what to run, without survey and output: {', '.join(ENDINGS)}; default report; "
        "such as 'image --permittivity 4'")  # fmt: skip
    add("--ending", metavar=".ENDING", help="ending of the results, such as .pdf for reports")
    add("--workers", type=int, metavar="N",
        help="surveys at a time; default: as many as this computer has processors and GiB of free "
        "memory")  # fmt: skip
    add("--scheduler", metavar="ADDRESS",
        help="compute on a dask cluster, such as tcp://127.0.0.1:8786; its workers need this "
        "package, and surveys and results under the same paths")  # fmt: skip
    add("--time-limit", type=float, default=3600.0, metavar="S",
        help="give up what is left if no survey ends for so long; default 3600")  # fmt: skip
    add("--overwrite", action="store_true", help="make results again that exist, else kept")
    add("--json", action="store_true", help="print the outcome as JSON, for programs")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Run the command on each survey, print the table and return the exit status."""
    jobs = _jobs(chosen)
    ended = {} if chosen.overwrite else {one: _earlier(one) for one in jobs if one.result.exists()}
    left = [job for job in jobs if job not in ended]
    if left:
        usual = max(1, min(len(left), processors(), int(available_bytes() // WORKER_BYTES)))
        chosen.into.mkdir(parents=True, exist_ok=True)
        unfinished = tempfile.TemporaryDirectory(prefix=BESIDE, dir=str(chosen.into.absolute()))
        with unfinished as folder, connected(chosen.scheduler, chosen.workers or usual) as client:
            done = outcomes(client, left, Path(folder), chosen.time_limit)
            ended.update(inputs.progress_bar("surveys")(done, len(left)))
    rows = [(job, ended[job]) for job in jobs]
    if chosen.json:
        print(json.dumps({"surveys": [_record(*row) for row in rows]}, indent=2))
    else:
        _print(rows)
    return FAILURE if any(outcome.error for outcome in ended.values()) else DONE


@contextlib.contextmanager
def connected(address: Optional[str], workers: int) -> Iterator[Client]:
    """Yield the client of the scheduler at an address, or of processes of this computer.

    Raises:
        AnalysisError: No scheduler with workers answers at the address.
    """
    # What goes wrong is said by this command.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(SETTINGS))
        # A command checks its memory itself; dask would kill what a command may need.
        place = address or stack.enter_context(
            LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                memory_limit=0,
                preload=WITHOUT_CTRL_C,
                dashboard_address="127.0.0.1:0",  # None takes port 8787, which may be in use
                silence_logs=logging.CRITICAL,
            )
        )
        try:
            client = stack.enter_context(Client(place, timeout=CONNECT_LIMIT_S))
            client.wait_for_workers(1, CONNECT_LIMIT_S)
        except (OSError, ValueError, DaskTimeoutError) as error:
            raise _refused(
                Message(
                    "no dask scheduler with workers answers at {address} within {limit_s:g} s; "
                    "start it, and workers with 'dask worker {address}'",
                    address=address or "127.0.0.1",
                    limit_s=CONNECT_LIMIT_S,
                    details=error,
                )
            ) from error
        yield client


def outcomes(
    client: Client, jobs: Sequence[Job], unfinished: Path, limit_s: float
) -> Iterator[Tuple[Job, Outcome]]:
    """Yield each job when it has ended; if none ends for the limit, all that are left have failed.

    Args:
        client: Of the scheduler.
        jobs: What to do.
        unfinished: Folder for what is not finished, on the file system of the results.
        limit_s: The limit [s].
    """
    left = {client.submit(compute, job, unfinished, pure=False): job for job in jobs}
    while left:
        try:
            done = wait(list(left), timeout=limit_s, return_when="FIRST_COMPLETED").done
        except (DaskTimeoutError, CancelledError, OSError):
            done = set(left)
        for future in done:
            job = left.pop(future)
            yield job, future.result() if future.status == "finished" else _lost(future, job)


def _lost(future: Future, job: Job) -> Outcome:
    """Return the outcome of a job whose worker has not answered."""
    error = future.exception() if future.status == "error" else None
    if isinstance(error, KilledWorker):
        reason = Message(
            "every worker that computed this survey was killed, probably for lack of memory; use "
            "fewer workers",
            details=error,
        ).with_fault(faults.TOO_LARGE)
    elif error is not None:
        reason = message_of(error, f"gpr20 batch {job.call.survey}")
    else:
        reason = Message(
            "the dask scheduler or its workers have ended or took too long, and this survey is not "
            "done; repeat the same command, which keeps what is done"
        ).with_fault(NOT_ALLOWED)
    return Outcome("failed", error=reason)


def compute(job: Job, unfinished: Path) -> Outcome:
    """Run a job's command, on a worker.

    Args:
        job: What to do.
        unfinished: Folder for what is not finished, on the file system of the results.
    """
    started_s = time.monotonic()
    folder = Path(tempfile.mkdtemp(dir=str(unfinished)))
    made = folder / job.result.name
    call = copy.copy(job.call)
    call.output = [made] if isinstance(call.output, list) else made
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            status = load(job.command).run(call, read_catalogue(language_from_code(call.language)))
        job.result.parent.mkdir(parents=True, exist_ok=True)
        # What is beside it comes first: the result marks the job as done.
        for one in sorted(folder.iterdir(), key=lambda path: path == made):
            put(one, job.result.with_name(one.name), folder / "replaced")
    except Exception as error:  # whatever it is, it is reported for this survey only
        reason = message_of(error, f"gpr20 {job.command} {call.survey}")
        return Outcome("failed", time.monotonic() - started_s, error=reason)
    return Outcome(MADE[status], time.monotonic() - started_s, tuple(said.getvalue().splitlines()))


def _jobs(chosen: argparse.Namespace) -> List[Job]:
    command, call = _call(chosen)
    ending = EXPORTED[call.format] if command == "export" else ENDINGS[command]
    ending = ending if chosen.ending is None else chosen.ending
    if ending and (not ending.startswith(".") or "/" in ending):
        raise _refused(
            Message(
                "--ending is {ending}; it begins with a dot and names no folder, such as .pdf",
                ending=repr(ending),
            )
        )
    jobs: Dict[Path, Job] = {}
    for given in chosen.survey:
        for survey, name in surveys_at(given, chosen.into.absolute()):
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
            jobs[result] = Job(name, result, command, own)
    return list(jobs.values())


def surveys_at(given: Path, into: Path) -> Iterator[Tuple[Path, str]]:
    """Yield each survey at a path, and the name of its result."""
    below = [] if (given / LOG_FILE).exists() else sorted(given.rglob(LOG_FILE))
    # An import that is being written, or was cut off, is no survey; an export can look like one.
    found = [one.parent for one in below if not one.parent.parent.name.startswith(BESIDE)]
    found = [one for one in found if into not in one.absolute().parents]
    yield from ((one, str(one.relative_to(given))) for one in found)
    if not found:
        place = given.resolve()
        yield given, place.name if place.is_dir() else place.stem


def _call(chosen: argparse.Namespace) -> Tuple[str, argparse.Namespace]:
    """Return the command and its arguments, those of survey and output left open."""
    command, *options = chosen.work or [""]
    if command not in ENDINGS:
        raise _refused(
            Message(
                "--command begins with {command}; it must begin with one of: {allowed}",
                command=repr(command),
                allowed=", ".join(ENDINGS),
            )
        )
    parser = argparse.ArgumentParser(prog=f"gpr20 batch --command {command}")
    load(command).add_arguments(parser)
    # The output comes first: one among the options would be a second one, or replace it.
    places = [*options, PLACE, PLACE] if command == "export" else ["-o", PLACE, *options, PLACE]
    call = parser.parse_args(places)
    kept = [name for name in OF_ONE_SURVEY if getattr(call, name, None)]
    kept += [] if call.output in (Path(PLACE), [Path(PLACE)]) else ["output"]
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


def _earlier(job: Job) -> Outcome:
    """Return the outcome of a job whose result is there; one of an earlier survey is an error."""
    survey = job.call.survey
    # A running survey gets traces while its log stays as it is.
    parts = [one for one in (survey, survey / LOG_FILE, survey / TRACES_FOLDER) if one.exists()]
    if all(one.stat().st_mtime_ns <= job.result.stat().st_mtime_ns for one in parts):
        return Outcome("exists")
    reason = Message("{result} is older than the survey; give --overwrite", result=job.result)
    return Outcome("failed", error=reason.with_fault(NOT_ALLOWED))


def _refused(message: Message) -> AnalysisError:
    return AnalysisError(message, fault=NOT_ALLOWED)


def _record(job: Job, outcome: Outcome) -> Dict[str, object]:
    return {
        "survey": str(job.call.survey),
        "state": outcome.state,
        "result": str(job.result) if job.result.exists() else None,
        "seconds": round(outcome.seconds, 3),
        "remarks": list(outcome.remarks),
        "error": outcome.error and json_fields(outcome.error),
    }


def _print(rows: Sequence[Tuple[Job, Outcome]]) -> None:
    width = max(len("survey"), *(len(job.name) for job, _ in rows))
    say(f"{'survey':{width}}  {'s':>8}  result")
    for job, outcome in rows:
        say(f"{job.name:{width}}  {outcome.seconds:8.1f}  {outcome.state}")
        errors = [outcome.error, *first_steps(outcome.error)] if outcome.error else []
        for line in (*outcome.remarks, *map(shown, errors)):
            say(f"    {line}")


COMMAND = Command(
    "Run a command of gpr20 on many surveys side by side, by processes of this computer or by a "
    "dask cluster. The failure of one survey does not stop the others; a table at the end says "
    "what became of each.",
    add_arguments,
    run,
    "exit status: 0 all results are there, 1 a survey failed, 3 refused or failed; the table or "
    "the message gives the reason",
)

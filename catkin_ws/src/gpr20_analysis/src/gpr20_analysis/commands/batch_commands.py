"""gpr20 batch: one command on many surveys, side by side, by the workers of dask."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import logging
import shlex
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterator, List, Optional, Sequence, Tuple

import dask
from distributed import CancelledError, Client, Future, KilledWorker, wait
from distributed import TimeoutError as DaskTimeoutError

from gpr20_analysis.atomic_output import BESIDE, put
from gpr20_analysis.commands import inputs
from gpr20_analysis.commands.command import REFUSED, Command
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.work import available_bytes, processors
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.folder.survey_folder import LOG_FILE, TRACES_FOLDER

EXISTS, FAILED = "exists", "failed"
ENDINGS = {"report": ".html", "image": ".nc", "candidates": ".csv", "process": ".nc",
           "plot": ".png", "export": ""}  # fmt: skip
"""The commands that make one result of one survey, and its usual ending."""
STATES = ("done", "not complete", "damaged", FAILED)
"""What became of a survey, by the exit status of its command."""
KILLED = "every worker that computed it was killed, probably for lack of memory; use fewer workers"
LOST = "the scheduler or its workers have ended or took too long; repeat the same command"
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
LOCAL = {
    "threads_per_worker": 1,
    "memory_limit": 0,  # a command checks its memory itself; dask would kill what it may need
    # A worker leaves Ctrl-C to the process that it belongs to.
    "preload": "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)",
    "dashboard_address": "127.0.0.1:0",  # None takes port 8787, which may be in use
    "silence_logs": logging.CRITICAL,
}
"""The workers of this computer."""


@dataclass
class Job:
    """One survey.

    Attributes:
        survey: Its path.
        result: Where its result is put.
        state: What became of it: EXISTS or one of STATES.
        said: What the command said of it, or why there is no result.
    """

    survey: Path
    result: Path
    state: str = EXISTS
    said: Sequence[str] = ()

    @property
    def is_current(self) -> bool:
        """Whether the result is there and not older than the survey."""
        # A running survey gets traces while its log stays as it is.
        parts = (self.survey, self.survey / LOG_FILE, self.survey / TRACES_FOLDER)
        changed_ns = [one.stat().st_mtime_ns for one in parts if one.exists()]
        return self.result.exists() and self.result.stat().st_mtime_ns >= max(changed_ns, default=0)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("survey", type=Path, nargs="+",
        help="survey as for other commands, or a folder in which all survey folders are found",
        )  # fmt: skip
    add("--into", type=Path, required=True, metavar="FOLDER",
        help="folder of the results; each is named like its survey")  # fmt: skip
    add("--command", dest="work", type=shlex.split, default=["report"], metavar="'COMMAND OPTIONS'",
        help=f"what to run, without survey and output: {', '.join(ENDINGS)}; default report; "
        "such as 'image --permittivity 4'")  # fmt: skip
    add("--ending", metavar=".ENDING", help="ending of the results, such as .json for lists")
    add("--workers", type=int, metavar="N",
        help="surveys at a time; default: as many as this computer has processors and GiB of free "
        "memory")  # fmt: skip
    add("--scheduler", metavar="ADDRESS",
        help="compute on a dask cluster, such as tcp://127.0.0.1:8786; its workers need this "
        "package and all files under the same paths; give whole paths in --command")  # fmt: skip
    add("--time-limit", type=float, default=3600.0, metavar="S",
        help="give up what is left if no survey ends for so long; default 3600")  # fmt: skip
    add("--overwrite", action="store_true",
        help="make results again that are newer than their surveys, else kept")  # fmt: skip
    add("--json", action="store_true", help="print the outcome as JSON, for programs")


def _batch(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    jobs = _jobs(chosen)
    left = [job for job in jobs if chosen.overwrite or not job.is_current]
    if left:
        usual = max(1, min(len(left), processors(), int(available_bytes() // WORKER_BYTES)))
        chosen.into.mkdir(parents=True, exist_ok=True)
        unfinished = tempfile.TemporaryDirectory(prefix=BESIDE, dir=str(chosen.into.absolute()))
        with unfinished as place, connected(chosen.scheduler, chosen.workers or usual) as client:
            folders = [Path(place, str(number)) for number in range(len(left))]
            calls = [_call(chosen, *each) for each in zip(left, folders)]
            ended = outcomes(client, calls, chosen.time_limit)
            for number, state, said in inputs.progress_bar("surveys")(ended, len(left)):
                left[number].state, left[number].said = state, said
                if state != FAILED:
                    _put(folders[number], left[number].result)
    if chosen.json:
        print(json.dumps({"surveys": list(map(vars, jobs))}, indent=2, default=str))  # noqa: T201
    else:
        for job in jobs:
            say(f"{job.state:12}  {job.survey}", *(f"    {line}" for line in job.said))
    return int(any(job.state == FAILED for job in jobs))


def _call(chosen: argparse.Namespace, job: Job, folder: Path) -> List[str]:
    """Return the arguments of gpr20 that make the result of a survey in a folder."""
    command, *options = chosen.work
    made = str(folder / job.result.name)
    output = [made] if command == "export" else ["-o", made]
    return [command, *options, str(job.survey), *output, "--language", chosen.language]


def _put(folder: Path, result: Path) -> None:
    """Move what a command has made to its place."""
    # What is left of a worker that was killed has another name.
    made = [one for one in folder.iterdir() if not one.name.startswith(BESIDE)]
    result.parent.mkdir(parents=True, exist_ok=True)
    # What is beside the result comes first: the result marks the survey as done.
    for one in sorted(made, key=lambda path: path.name == result.name):
        put(one, result.with_name(one.name), folder / "replaced")


@contextlib.contextmanager
def connected(address: Optional[str], workers: int) -> Iterator[Client]:
    """Yield the client of the scheduler at an address, or of processes of this computer.

    Raises:
        AnalysisError: No scheduler with workers answers at the address.
    """
    # What goes wrong is said by this command.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    where = {"address": address} if address else {"n_workers": workers, **LOCAL}
    with dask.config.set(SETTINGS), contextlib.ExitStack() as stack:
        try:
            client = stack.enter_context(Client(timeout=CONNECT_LIMIT_S, **where))
            client.wait_for_workers(1, CONNECT_LIMIT_S)
        except (OSError, ValueError, DaskTimeoutError) as error:
            raise AnalysisError(
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
    client: Client, calls: Sequence[List[str]], limit_s: float
) -> Iterator[Tuple[int, str, Sequence[str]]]:
    """Yield number, state and words of each call when it has ended.

    Args:
        client: Of the scheduler.
        calls: Arguments of gpr20.
        limit_s: If none ends for so long, all that are left are lost [s].
    """
    left: Dict[Future, int] = {
        client.submit(called, call, pure=False): number for number, call in enumerate(calls)
    }
    while left:
        try:
            done = wait(list(left), timeout=limit_s, return_when="FIRST_COMPLETED").done
        except (DaskTimeoutError, CancelledError, OSError):
            done = set(left)
        for future in done:
            error = future.exception() if future.status == "error" else None
            if future.status == "finished":
                status, said = future.result()
            elif isinstance(error, KilledWorker):
                status, said = REFUSED, [KILLED]
            else:
                status, said = REFUSED, [LOST if error is None else repr(error)]
            yield left.pop(future), STATES[status], said


def called(arguments: List[str]) -> Tuple[int, List[str]]:
    """Call gpr20 on a worker; return its exit status and the lines of what it says."""
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        status = main(arguments)
    lines = said.getvalue().splitlines()
    # A wrong option: the usage would be said of each survey.
    return status, lines[-1:] if lines and lines[0].startswith("usage: ") else lines


def _jobs(chosen: argparse.Namespace) -> List[Job]:
    command = chosen.work[0] if chosen.work else ""
    if command not in ENDINGS:
        raise AnalysisError(
            Message(
                "--command begins with {command}; it must begin with one of: {allowed}",
                command=repr(command),
                allowed=", ".join(ENDINGS),
            )
        )
    ending = ENDINGS[command] if chosen.ending is None else chosen.ending
    into = chosen.into.absolute()
    jobs: Dict[Path, Job] = {}
    for given in chosen.survey:
        for survey, name in surveys_at(given, into):
            result = into / f"{name}{ending}"
            if result in jobs:
                raise AnalysisError(
                    Message(
                        "{first} and {second} would both become {result}; give the folder that "
                        "holds both, or another --into for one of them",
                        first=jobs[result].survey,
                        second=survey,
                        result=result,
                    )
                )
            jobs[result] = Job(survey.absolute(), result)
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


BATCH = Command(
    "Run a command of gpr20 on many surveys side by side, by processes of this computer or by a "
    "dask cluster. The failure of one survey does not stop the others; a table at the end says "
    "what became of each.",
    _add_arguments,
    _batch,
    "exit status: 0 all results are there, 1 a survey failed, 3 refused or failed; the table or "
    "the message gives the reason",
)

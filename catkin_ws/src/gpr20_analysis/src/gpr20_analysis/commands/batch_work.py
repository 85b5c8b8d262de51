"""The work of gpr20 batch: one command on each of many surveys, by the workers of dask."""

from __future__ import annotations

import argparse
import contextlib
import copy
import io
import json
import logging
import shutil
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Collection, Iterator, Optional, Sequence, Tuple

import dask
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, wait
from distributed import TimeoutError as DaskTimeoutError
from tqdm import tqdm

from gpr20_analysis import faults
from gpr20_analysis.atomic_output import BESIDE, put
from gpr20_analysis.commands.command import REFUSED, load
from gpr20_analysis.commands.failure import message_of
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.lazy import available_bytes
from gpr20_analysis.threads import processors
from gpr20_common.catalogue import language_from_code, read_catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message

TIME_LIMIT_S = 10.0
POLL_S = 2.0
IDLE_LIMIT_S = 180.0
"""If no worker computes for so long, what is left is given up."""
WITHOUT_CTRL_C = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
"""What a worker of this computer runs first: it is ended in order by the process it belongs to."""
WORKER_BYTES = 1 << 30
"""Memory that a survey of usual size needs."""


@dataclass(frozen=True, eq=False)
class Job:
    """One survey.

    Attributes:
        name: The survey's, in the table.
        result: Where the result is put.
        command: Name of the command.
        call: Arguments of the command, but for the output.
        made_of: The command with its options, the survey, and when that changed last: a result of
            the same needs not be made again.
    """

    name: str
    result: Path
    command: str
    call: argparse.Namespace
    made_of: str

    @property
    def note(self) -> Path:
        """The file beside the result that says what it was made of and what became of it."""
        return self.result.with_name(f".{self.result.name}.made")


@dataclass(frozen=True)
class Outcome:
    """What became of a survey.

    Attributes:
        status: The command's exit status.
        seconds: How long it took; None: the result was there.
        remarks: What the command said about the survey, such as what has no data.
        error: Why there is no result.
    """

    status: int
    seconds: Optional[float]
    remarks: Tuple[str, ...] = ()
    error: Optional[Message] = None


def earlier(job: Job) -> Optional[Outcome]:
    """Return the outcome of an earlier run, None if there is no result yet.

    A result that is not of this command, these options and this state of the survey is an error.
    """
    if not job.result.exists():
        return None
    try:
        noted = json.loads(job.note.read_text(encoding="utf-8"))
        if noted["made_of"] == job.made_of:
            return Outcome(int(noted["status"]), None, tuple(map(str, noted["remarks"])))
    except (OSError, ValueError, TypeError, KeyError):
        pass  # as if it said something else
    return Outcome(
        REFUSED,
        None,
        error=Message(
            "{result} is there, but not known to be of this command and this state of the survey; "
            "give --overwrite or another --into",
            result=job.result,
        ).with_fault(NOT_ALLOWED),
    )


def standard_workers(jobs: int) -> int:
    """Return how many workers this computer has the processors and the memory for."""
    return max(1, min(jobs, processors(), int(available_bytes() // WORKER_BYTES)))


@contextlib.contextmanager
def connected(address: Optional[str], workers: int) -> Iterator[Client]:
    """Yield the client of the scheduler at an address, or of processes of this computer.

    Raises:
        AnalysisError: No scheduler answers at the address, or it has no workers.
    """
    if not address:
        # A survey that waits behind another one would share the blame for a worker's death. A busy
        # computer may need more than the usual 15 s to start a worker again.
        settings = {"scheduler.worker-saturation": 1.0, "deploy.lost-worker-timeout": "60s"}
        alone = dask.config.set({f"distributed.{key}": one for key, one in settings.items()})
        # A command checks its memory itself; dask would kill what a command may need.
        with alone, LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            memory_limit=0,
            preload=WITHOUT_CTRL_C,
            dashboard_address="127.0.0.1:0",  # None takes port 8787, which may be in use
            silence_logs=logging.CRITICAL,
        ) as cluster, Client(cluster) as client:
            yield client
        return
    # What goes wrong is said by this command, as with silence_logs above.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=TIME_LIMIT_S)
    except (OSError, ValueError) as error:
        raise AnalysisError(
            Message(
                "no dask scheduler answers at {address} within {limit_s:g} s; start it and its "
                "workers, or leave --scheduler out",
                address=address,
                limit_s=TIME_LIMIT_S,
                details=error,
            ),
            fault=NOT_ALLOWED,
        ) from error
    with client:
        if not client.nthreads():
            raise AnalysisError(
                Message(
                    "the cluster at {address} has no workers; start them with "
                    "'dask worker {address}'",
                    address=address,
                ),
                fault=NOT_ALLOWED,
            )
        yield client


@contextlib.contextmanager
def unfinished_folder(into: Path) -> Iterator[Path]:
    """Yield a folder for what is not finished, beside the results; it is removed at the end."""
    into.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix=BESIDE, dir=str(into)))
    try:
        yield folder
    finally:
        shutil.rmtree(str(folder), ignore_errors=True)


def outcomes(
    client: Client, jobs: Sequence[Job], unfinished: Path
) -> Iterator[Tuple[Job, Outcome]]:
    """Yield each job when it has ended.

    The job of a worker that dies is done again by another one. What a dead worker has begun to
    write stays in the folder of what is unfinished. Without scheduler or workers every job that is
    left ends, too.
    """
    left = {client.submit(compute, job, unfinished, pure=False): job for job in jobs}
    worked_s = time.monotonic()
    while left:
        try:
            for ended in _some_ended(client, left):
                error = ended.exception(TIME_LIMIT_S)
                outcome = None if error else ended.result(TIME_LIMIT_S)
                job = left.pop(ended)
                yield job, _lost(error, job) if outcome is None else outcome
            worked_s = time.monotonic()
        except (DaskTimeoutError, OSError, CancelledError) as error:
            # Without contact to the scheduler everything is cancelled.
            if isinstance(error, CancelledError) or time.monotonic() - worked_s > IDLE_LIMIT_S:
                reason = Message(
                    "the dask scheduler or its workers have ended, and this survey is not done; "
                    "repeat the same command, which keeps what is done",
                    details=type(error).__name__,
                ).with_fault(NOT_ALLOWED if client.cluster is None else faults.TOO_LARGE)
                yield from ((job, Outcome(REFUSED, 0.0, error=reason)) for job in left.values())
                return


def _some_ended(client: Client, begun: Collection[Future]) -> Collection[Future]:
    """Return what has ended after a moment.

    Raises:
        DaskTimeoutError, OSError: No worker computes, or the scheduler does not answer.
        CancelledError: The contact to the scheduler is lost.
    """
    try:
        return wait(list(begun), timeout=POLL_S, return_when="FIRST_COMPLETED").done
    except DaskTimeoutError:
        if any(client.sync(client.scheduler.processing, callback_timeout=TIME_LIMIT_S).values()):
            return ()
        if client.cluster is not None:
            # To the same number: each worker that was given up is replaced.
            client.cluster.scale(len(client.cluster.worker_spec))
        raise


def compute(job: Job, unfinished: Path) -> Outcome:
    """Run a job's command, on a worker.

    Args:
        job: What to do.
        unfinished: Folder for what is not finished, on the file system of the results.
    """
    started_s = time.monotonic()
    # Its own is shared by processes: one that is killed could not give it back.
    tqdm.set_lock(threading.RLock())
    folder = Path(tempfile.mkdtemp(dir=str(unfinished)))
    made = folder / job.result.name
    call = copy.copy(job.call)
    call.output = [made] if isinstance(call.output, list) else made
    said = io.StringIO()
    status, reason = REFUSED, None
    try:
        # One survey is computed by one worker.
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(
            said
        ), dask.config.set(scheduler="threads"):
            status = load(job.command).run(call, read_catalogue(language_from_code(call.language)))
        job.result.parent.mkdir(parents=True, exist_ok=True)
        note = {"made_of": job.made_of, "status": status, "remarks": said.getvalue().splitlines()}
        (folder / job.note.name).write_text(json.dumps(note), encoding="utf-8")
        # The file that marks a job as done comes last.
        for one in sorted(folder.iterdir(), key=lambda path: path == made):
            put(one, job.result.with_name(one.name), folder / "replaced")
    except Exception as error:  # whatever it is, it is reported for this survey only
        reason = message_of(error, f"gpr20 {job.command} {call.survey}")
    remarks = () if reason else said.getvalue().splitlines()
    return Outcome(status, time.monotonic() - started_s, tuple(remarks), reason)


def _lost(error: BaseException, job: Job) -> Outcome:
    reason = message_of(error, f"gpr20 batch {job.call.survey}")
    if isinstance(error, KilledWorker):
        reason = Message(
            "every worker that computed this survey was killed, probably for lack of memory; use "
            "fewer workers",
            details=error,
        ).with_fault(faults.TOO_LARGE)
    return Outcome(REFUSED, 0.0, error=reason)

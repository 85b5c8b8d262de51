"""The program that does the work: a child process that never disturbs a survey."""

from __future__ import annotations

import importlib.util
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import IO, Any, Callable, Optional, Sequence

from gpr20_common.message import Message
from gpr20_imaging.faults import ImagingError

WORKER = (sys.executable, "-m", "gpr20_imaging.mid.worker")
# Lowest priority for processor and disk; killed with the thread that started it.
PREFIX = (
    ("nice", "-n", "19"),
    ("ionice", "-c", "3"),
    ("setpriv", "--pdeathsig", "KILL"),
)
# The first to be killed if the memory of the computer runs out.
OOM_SCORE = 1000
MEMORY_SHARE, LEAST_MEMORY_BYTES = 0.5, 512 << 20
# As long as a request needs to leave no partial output behind.
END_LIMIT_S = 5.0
LONGEST_ERROR = 2000
# Every workspace has the analysis, but not the libraries that it needs; one of them is xarray.
NEEDED = ("gpr20_analysis", "xarray")
Report = Callable[[Message], None]


def memory_limit_bytes() -> int:
    """Return how much memory the child may use [bytes]: half of that of the computer."""
    total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return max(LEAST_MEMORY_BYTES, int(MEMORY_SHARE * total))


class WorkerProcess:
    """Asks one child process, which is started when it is needed and ends when it is idle.

    It is killed when the thread that called `start` ends.

    Args:
        command: The program of the child; the number of the connection's file is added.
    """

    def __init__(self, command: Sequence[str] = WORKER) -> None:
        self._command = command
        self._child: Optional[subprocess.Popen] = None
        self._connection: Optional[Connection] = None
        self._errors: Optional[IO[bytes]] = None
        self._is_ending = False

    @property
    def has_analysis(self) -> bool:
        """Whether the analysis and its libraries are on this computer."""
        return all(importlib.util.find_spec(name) is not None for name in NEEDED)

    def start(self) -> None:
        """Start the process unless it runs, with the lowest priority and bounded memory.

        Raises:
            ImagingError: It cannot be started.
        """
        if self._child is not None and self._child.poll() is None and not self._is_ending:
            return
        self.close()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the process)
        self._connection, theirs = Pipe()
        lowered = [word for tool in PREFIX if shutil.which(tool[0]) for word in tool]
        with theirs:
            try:
                self._child = subprocess.Popen(
                    [*lowered, *self._command, str(theirs.fileno())],
                    stdin=subprocess.DEVNULL,
                    stdout=self._errors,
                    stderr=self._errors,
                    pass_fds=[theirs.fileno()],
                )
                limit = memory_limit_bytes()
                resource.prlimit(self._child.pid, resource.RLIMIT_DATA, (limit, limit))
                Path(f"/proc/{self._child.pid}/oom_score_adj").write_text(str(OOM_SCORE))
            except ProcessLookupError:
                return  # it has ended already; its status says why
            except OSError as error:
                message = Message("the analysis cannot be started", details=error)
                raise ImagingError(message) from error

    def ask(self, limit_s: float, report: Report, name: str, *arguments: Any) -> Any:
        """Return the answer of the process to a request.

        Args:
            limit_s: The process is killed after this time [s].
            report: Called with what is being done.
            name: Which request.
            arguments: What it needs.

        Raises:
            ImagingError: There is none; the message says why.
        """
        self.start()
        child, connection = self._child, self._connection
        assert child is not None and connection is not None
        timer = threading.Timer(limit_s, child.kill)
        timer.daemon = True
        timer.start()
        try:
            connection.send((name, arguments))
            while True:
                stage, result, failure = connection.recv()
                if stage is None:
                    break
                report(stage)
        except (EOFError, BrokenPipeError, ConnectionResetError) as error:
            if child.wait() == 0:
                # It was idle, and ended as the request came.
                return self.ask(limit_s, report, name, *arguments)
            raise self._died(child.returncode, limit_s) from error
        finally:
            timer.cancel()
        if failure is not None:
            raise ImagingError(failure)
        return result

    def end(self) -> None:
        """Ask the process to end, and kill it if it does not; do not wait."""
        child = self._child
        if child is not None and child.poll() is None:
            # Whatever it still answers, it does not answer the next request.
            self._is_ending = True
            child.terminate()
            killer = threading.Timer(END_LIMIT_S, child.kill)
            killer.daemon = True
            killer.start()

    def close(self) -> None:
        """End the process, if there is one, and wait for its end."""
        if self._child is not None:
            self._child.kill()
            self._child.wait()
        for one in (self._connection, self._errors):
            if one is not None:
                one.close()
        self._child = self._connection = self._errors = None
        self._is_ending = False

    def _died(self, status: int, limit_s: float) -> ImagingError:
        assert self._errors is not None
        self._errors.seek(0)
        errors = self._errors.read().decode("utf-8", "replace").strip()
        return ImagingError(
            Message(
                "the analysis ended before its result was complete, for lack of memory or after "
                "{limit_s:g} s",
                limit_s=limit_s,
                details=f"{status}: {errors[-LONGEST_ERROR:]}",
            )
        )

"""The analysis in a child process, which stays and reads only new traces for the next image."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
import threading
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import IO, Any, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import ImagingError
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.low.child_process import end_child, start_child
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hiding_map import HidingMap

WORKER = (sys.executable, "-m", "gpr20_imaging.low.analysis_worker")
# Every workspace has the analysis, but not the libraries that it needs; one of them is xarray.
NEEDED = ("gpr20_analysis", "xarray")
FOCUS_LIMIT_S, LIMIT_S = 300.0, 1800.0
LONGEST_ERROR = 2000


class AnalysisProcess:
    """Asks one child process at a time; starts it when it is needed.

    Args:
        command: The program of the child; the number of the connection's file is added.
    """

    def __init__(self, command: Sequence[str] = WORKER) -> None:
        self._command = command
        self._child: Optional[subprocess.Popen] = None
        self._connection: Optional[Connection] = None
        self._errors: Optional[IO[bytes]] = None

    @property
    def is_installed(self) -> bool:
        """Whether the analysis and its libraries are on this computer."""
        return all(importlib.util.find_spec(name) is not None for name in NEEDED)

    def focus(
        self, folder: Path, permittivity: Optional[float], cancellation: Cancellation
    ) -> FocusedImage:
        """Return the focused image of a survey, running or past.

        Args:
            folder: The survey's folder.
            permittivity: Relative permittivity of the ground; None: what the survey says.
            cancellation: Ends the process.

        Raises:
            ImagingError: There is no image; the message says why.
        """
        image: FocusedImage = self._ask(FOCUS_LIMIT_S, cancellation, "focus", folder, permittivity)
        return image

    def map_hidden(
        self,
        folder: Path,
        permittivity: Optional[float],
        target: str,
        cancellation: Cancellation,
    ) -> HidingMap:
        """Return where a target could hide in a survey.

        Args:
            folder: The survey's folder.
            permittivity: Relative permittivity of the ground; None: what the survey says.
            target: As for `target_of`.
            cancellation: Ends the process.

        Raises:
            ImagingError: There is no map; the message says why.
        """
        found: HidingMap = self._ask(
            LIMIT_S, cancellation, "map_hidden", folder, permittivity, target
        )
        return found

    def write(
        self,
        what: str,
        folder: Path,
        output: Path,
        permittivity: Optional[float],
        language: str,
        cancellation: Cancellation,
    ) -> None:
        """Write a file about a survey.

        Args:
            what: "report" or "candidates".
            folder: The survey's folder.
            output: The file; its ending says the format.
            permittivity: Relative permittivity of the ground; None: what the survey says.
            language: Code of the language of reports.
            cancellation: Ends the process.

        Raises:
            ImagingError: There is no file; the message says why.
        """
        self._ask(LIMIT_S, cancellation, f"write_{what}", folder, output, permittivity, language)

    def close(self) -> None:
        """End the process, if there is one, and wait for its end."""
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            child.wait()
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if self._errors is not None:
            self._errors.close()
            self._errors = None

    def _ask(self, limit_s: float, cancellation: Cancellation, name: str, *arguments: Any) -> Any:
        cancellation.check()
        child, connection = self._running()
        timer = threading.Timer(limit_s, child.kill)
        timer.daemon = True
        try:
            with cancellation.stopping(lambda: end_child(child)):
                timer.start()
                answer = _exchange(connection, (name, arguments))
                if answer is None:
                    child.wait()
        finally:
            timer.cancel()
        if answer is None:
            raise self._died(child, limit_s)
        result, failure = answer
        if failure is not None:
            raise ImagingError(failure)
        return result

    def _running(self) -> Tuple[subprocess.Popen, Connection]:
        if self._child is not None and self._child.poll() is None:
            assert self._connection is not None
            return self._child, self._connection
        self.close()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the process)
        ours, theirs = Pipe()
        with theirs:
            self._connection = ours
            try:
                self._child = start_child(
                    [*self._command, str(theirs.fileno())],
                    stdin=subprocess.DEVNULL,
                    stdout=self._errors,
                    stderr=self._errors,
                    pass_fds=[theirs.fileno()],
                )
            except OSError as error:
                raise ImagingError(
                    Message("the analysis cannot be started", details=error),
                    fault=faults.OTHER_COMPUTER,
                ) from error
        return self._child, ours

    def _died(self, child: subprocess.Popen, limit_s: float) -> ImagingError:
        assert self._errors is not None
        self._errors.seek(0)
        errors = self._errors.read().decode("utf-8", "replace").strip()
        return ImagingError(
            Message(
                "the analysis ended before its result was complete, for lack of memory or after "
                "{limit_s:g} s",
                limit_s=limit_s,
                details=f"{child.returncode}: {errors[-LONGEST_ERROR:]}",
            ),
            fault=faults.OTHER_COMPUTER,
        )


def _exchange(connection: Connection, request: Any) -> Optional[Tuple[Any, Optional[Message]]]:
    """Return result and failure; None if the process has ended."""
    try:
        connection.send(request)
        answer: Tuple[Any, Optional[Message]] = connection.recv()
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return None
    return answer

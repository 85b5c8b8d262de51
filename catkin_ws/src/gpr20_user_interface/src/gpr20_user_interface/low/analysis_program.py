"""The command gpr20 of the analysis, as a process of its own at low priority."""

from __future__ import annotations

import shutil
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Optional, Sequence

COMMAND = "gpr20"
LOW_PRIORITY = ("nice", "-n", "19")
# As long as the command needs to leave no partial output behind.
END_LIMIT_S = 5.0


@dataclass(frozen=True)
class ProgramEnded:
    """A program has ended.

    Attributes:
        number: Which one, as `BackgroundProgram.start` returned it.
        status: Exit status.
        output: What it printed.
        errors: What it printed as errors.
    """

    number: int
    status: int
    output: str
    errors: str


def gpr20_path() -> Optional[str]:
    """Return the command beside this interpreter, or on the path; None if it is not installed."""
    beside = Path(sys.executable).with_name(COMMAND)
    return str(beside) if beside.exists() else shutil.which(COMMAND)


class AnalysisProgram:
    """Runs the command, at most once at a time.

    Args:
        listener: Called with ProgramEnded, from a thread of this class.
        find: Returns the command; None if it is not installed.
    """

    def __init__(
        self,
        listener: Callable[[ProgramEnded], None],
        find: Callable[[], Optional[str]] = gpr20_path,
    ) -> None:
        self._listener = listener
        self._find = find
        self._process: Optional[subprocess.Popen] = None
        self._number = 0

    def is_installed(self) -> bool:
        """Whether the command is on this computer."""
        return self._find() is not None

    def start(self, arguments: Sequence[str]) -> int:
        """Start the command; a former one is cancelled.

        Args:
            arguments: Its arguments.

        Returns:
            The number of this run, which its ProgramEnded has too.
        """
        self.cancel()
        self._number += 1
        self._process = subprocess.Popen(
            [*LOW_PRIORITY, self._find() or COMMAND, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
        )
        threading.Thread(
            target=self._wait, args=(self._process, self._number), name="analysis", daemon=True
        ).start()
        return self._number

    def cancel(self) -> None:
        """Ask the command to end, if it is running, and end it if it does not; do not wait."""
        process, self._process = self._process, None
        if process is None or process.poll() is not None:
            return
        process.terminate()
        killer = threading.Timer(END_LIMIT_S, process.kill)
        killer.daemon = True
        killer.start()

    def _wait(self, process: subprocess.Popen, number: int) -> None:
        output, errors = process.communicate()
        self._listener(ProgramEnded(number, process.returncode, output, errors))

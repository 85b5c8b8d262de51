"""The command gpr20 of the analysis, one run at a time."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Optional, Sequence

from gpr20_common.message import Message, verbatim
from gpr20_common.sent_message import received_message
from gpr20_imaging import faults
from gpr20_imaging.errors import ImagingError
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.low.child_process import end_child, start_child

COMMAND = "gpr20"
# Every workspace has the command, but not the libraries that it needs; this is one of them.
LIBRARY = "xarray"
LONGEST_REASON = 1000


def gpr20_path() -> Optional[str]:
    """Return the command beside this interpreter, or on the path; None if it cannot run."""
    if importlib.util.find_spec(LIBRARY) is None:
        return None
    beside = Path(sys.executable).with_name(COMMAND)
    return str(beside) if beside.exists() else shutil.which(COMMAND)


@dataclass(frozen=True)
class CommandResult:
    """A command has ended.

    Attributes:
        status: Exit status.
        output: What it printed.
        errors: What it printed as errors.
    """

    status: int
    output: str
    errors: str

    @property
    def failure(self) -> Message:
        """Why it failed, with the fault that it has printed as JSON, if it has."""
        try:
            error = json.loads(self.output)["error"]
            return received_message(error["message"], error["message_json"], error["fault_code"])
        except (ValueError, KeyError, TypeError):
            pass
        text = self.errors.strip()[-LONGEST_REASON:]
        if text:
            return verbatim(text)
        return Message("the analysis ended with status {status}", status=self.status)


class AnalysisCommand:
    """Runs the command and waits for it.

    Args:
        find: Returns the command; None if it is not installed.
    """

    def __init__(self, find: Callable[[], Optional[str]] = gpr20_path) -> None:
        self._find = find

    @property
    def is_installed(self) -> bool:
        """Whether the command is on this computer."""
        return self._find() is not None

    @property
    def path(self) -> str:
        """The command."""
        return self._find() or COMMAND

    def run(
        self, arguments: Sequence[str], limit_s: float, cancellation: Cancellation
    ) -> CommandResult:
        """Run the command.

        Args:
            arguments: Its arguments; with `--json` it says as data why it failed.
            limit_s: Time limit [s].
            cancellation: Ends it.

        Raises:
            ImagingError: It could not be started, exceeded the limit or was cancelled.
        """
        cancellation.check()
        try:
            child = start_child(
                [self.path, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                encoding="utf-8",
                errors="replace",
            )
        except OSError as error:
            raise ImagingError(
                Message("the analysis cannot be started", details=error), fault=faults.NOT_INSTALLED
            ) from error
        with cancellation.stopping(lambda: end_child(child)):
            try:
                output, errors = child.communicate(timeout=limit_s)
            except subprocess.TimeoutExpired:
                child.kill()
                child.communicate()
                raise ImagingError(
                    Message("the analysis took longer than {limit_s:g} s", limit_s=limit_s),
                    fault=faults.TOO_MUCH,
                ) from None
        return CommandResult(child.returncode, output, errors)

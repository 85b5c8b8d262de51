"""The command `gpr20 focus`, which stays and reads only new traces for the next image."""

from __future__ import annotations

import json
import subprocess
import tempfile
import threading
from pathlib import Path
from typing import IO, Any, Callable, Dict, Optional

from gpr20_common.message import Message
from gpr20_common.sent_message import received_message
from gpr20_imaging import faults
from gpr20_imaging.errors import ImagingError
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.low.child_process import end_child, start_child

LONGEST_ERROR = 2000


class FocusProcess:
    """Asks one child process at a time; starts it when it is needed.

    Args:
        command: Returns the path of the command gpr20.
        limit_s: Time limit of an image [s].
    """

    def __init__(self, command: Callable[[], str], limit_s: float) -> None:
        self._command = command
        self._limit_s = limit_s
        self._child: Optional[subprocess.Popen] = None
        self._errors: Optional[IO[bytes]] = None

    def ask(
        self, folder: Path, permittivity: Optional[float], cancellation: Cancellation
    ) -> Dict[str, Any]:
        """Return the answer of the command, with the bytes of the levels as `levels_db`.

        Args:
            folder: The survey's folder.
            permittivity: Relative permittivity of the ground; None: estimate it.
            cancellation: Ends the process.

        Raises:
            ImagingError: There is no image; the message says why.
        """
        child = self._running()
        assert child.stdin is not None and child.stdout is not None
        with tempfile.TemporaryDirectory(prefix="gpr20_imaging_") as place:
            levels = Path(place) / "levels"
            request = {"survey": str(folder), "permittivity": permittivity, "levels": str(levels)}
            timer = threading.Timer(self._limit_s, child.kill)
            timer.daemon = True
            try:
                with cancellation.stopping(lambda: end_child(child)):
                    timer.start()
                    line = self._exchange(child, json.dumps(request))
            finally:
                timer.cancel()
            if not line:
                raise self._died(child)
            answer: Dict[str, Any] = json.loads(line)
            if "error" in answer:
                error = answer["error"]
                raise ImagingError(
                    received_message(error["message"], error["message_json"], error["fault_code"])
                )
            return {**answer, "levels_db": levels.read_bytes()}

    def close(self) -> None:
        """End the process, if there is one, and wait for its end."""
        child, self._child = self._child, None
        if child is not None:
            assert child.stdin is not None and child.stdout is not None
            child.kill()
            child.wait()
            # What a dead process did not read any more.
            for stream in (child.stdin, child.stdout):
                try:
                    stream.close()
                except BrokenPipeError:
                    continue
        if self._errors is not None:
            self._errors.close()
            self._errors = None

    def _running(self) -> subprocess.Popen:
        if self._child is not None and self._child.poll() is None:
            return self._child
        self.close()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed with the process)
        try:
            self._child = start_child(
                [self._command(), "focus"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                encoding="utf-8",
            )
        except OSError as error:
            raise ImagingError(
                Message("the analysis cannot be started", details=error), fault=faults.NOT_INSTALLED
            ) from error
        return self._child

    @staticmethod
    def _exchange(child: subprocess.Popen, request: str) -> str:
        assert child.stdin is not None and child.stdout is not None
        try:
            child.stdin.write(request + "\n")
            child.stdin.flush()
        except BrokenPipeError:
            return ""
        line: str = child.stdout.readline()
        return line

    def _died(self, child: subprocess.Popen) -> ImagingError:
        status = child.wait()
        assert self._errors is not None
        self._errors.seek(0)
        errors = self._errors.read().decode("utf-8", "replace").strip()
        return ImagingError(
            Message(
                "the analysis ended before the image was complete, for lack of memory or after "
                "{limit_s:g} s",
                limit_s=self._limit_s,
                details=f"{status}: {errors[-LONGEST_ERROR:]}",
            ),
            fault=faults.TOO_MUCH,
        )

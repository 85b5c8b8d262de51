"""Whether a display can be opened, tried in a process of its own."""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import tempfile
from typing import Callable, NoReturn, Optional

# A screen over a slow network opens within this time [s].
OPEN_LIMIT_S = 15.0
# A library that cannot open the display says why in a few lines.
MAX_WORDS_BYTES = 65536
NO_ANSWER = "no answer within {limit_s:g} s"


def display_problem(
    open_display: Callable[[], object], limit_s: float = OPEN_LIMIT_S
) -> Optional[str]:
    """Return why the display cannot be opened; None if it can.

    A library without a display ends its process with a core dump, so the attempt is made in
    a child. Call it before there are threads.

    Args:
        open_display: Opens the display, such as the constructor of an application.
        limit_s: How long the attempt may take [s].
    """
    with tempfile.TemporaryFile() as words:
        fork = multiprocessing.get_context("fork")
        child = fork.Process(target=_attempt, args=(open_display, words.fileno()))
        child.start()
        child.join(limit_s)
        if child.exitcode is None:
            child.kill()
            child.join()
            return NO_ANSWER.format(limit_s=limit_s)
        words.seek(0)
        # Warnings are no problem.
        said = words.read(MAX_WORDS_BYTES).decode(errors="replace")
        return None if child.exitcode == 0 else _first_line(said)


def _attempt(open_display: Callable[[], object], writing: int) -> NoReturn:
    status = 1
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for stream in (1, 2):
            os.dup2(writing, stream)
        open_display()
        status = 0
    except Exception as error:
        os.write(writing, repr(error).encode())
    finally:
        os._exit(status)


def _first_line(words: str) -> str:
    """Return the line that names the display, or else the first one."""
    lines = [line.strip() for line in words.splitlines() if line.strip()]
    named = [line for line in lines if "display" in line]
    return (named or lines or [""])[0]

"""Programs of this computer that are asked, and work that may hang."""

from __future__ import annotations

import subprocess
import threading
from typing import Callable, List, Sequence, TypeVar

# Of a program that has nothing to do but to say what it knows, on a busy computer.
ANSWER_LIMIT_S = 4.0
# What a check that fails raises.
FAILURES = (OSError, ValueError, LookupError)

Found = TypeVar("Found")


def answer_of(
    command: Sequence[str],
    limit_s: float = ANSWER_LIMIT_S,
    statuses: Sequence[int] = (0,),
) -> str:
    """Return what a program prints.

    Args:
        command: The program and its arguments.
        limit_s: Within which it must end [s].
        statuses: Exit statuses of an answer.

    Raises:
        FileNotFoundError: It is not installed.
        OSError: It failed or was late.
    """
    try:
        ended = subprocess.run(
            command, capture_output=True, timeout=limit_s, text=True, errors="replace"
        )
    except subprocess.TimeoutExpired as error:
        raise TimeoutError(str(error)) from error
    if ended.returncode not in statuses:
        raise OSError(ended.stderr.strip() or f"{command[0]} ended with {ended.returncode}")
    return ended.stdout


def in_time(work: Callable[[], Found], limit_s: float) -> Found:
    """Return what some work finds that cannot be interrupted if it hangs, such as on a disk.

    Raises:
        TimeoutError: It took longer.
        OSError, ValueError, LookupError: The work raised it.
    """
    found: List[Found] = []
    failed: List[Exception] = []

    def run() -> None:
        try:
            found.append(work())
        except FAILURES as error:
            failed.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(limit_s)
    if failed:
        raise failed[0]
    if not found:
        raise TimeoutError(f"no answer within {limit_s:g} s")
    return found[0]

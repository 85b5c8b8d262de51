"""Run a command with a time limit that ends all of its descendants."""

from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Mapping, Optional, Sequence

import psutil

# Longer than roslaunch takes to end its nodes.
END_LIMIT_S = 20.0


@dataclass(frozen=True)
class Ended:
    """How a command ended.

    Attributes:
        status: Its exit status; None if the time limit ended it.
        printed: What it printed, on both streams.
    """

    status: Optional[int]
    printed: str


def end_descendants(pid: int, and_itself: bool) -> None:
    """End the descendants of a process, in whatever session: a launch ends its own nodes.

    Args:
        pid: The process; it is no error if it has ended already.
        and_itself: Whether to end the process too.
    """
    try:
        parent = psutil.Process(pid)
        family = parent.children(recursive=True)
    except psutil.NoSuchProcess:
        return
    if and_itself:
        family.insert(0, parent)
    for one in family:
        # psutil never mistakes a new process with the same number for the old one.
        with contextlib.suppress(psutil.NoSuchProcess):
            one.terminate()
    _gone, alive = psutil.wait_procs(family, END_LIMIT_S)
    for one in alive:
        with contextlib.suppress(psutil.NoSuchProcess):
            one.kill()


def run_limited(
    command: Sequence[str], environment: Mapping[str, str], limit_s: float, folder: Path
) -> Ended:
    """Run a command in a session of its own.

    Args:
        command: The program and its arguments.
        environment: Its whole environment.
        limit_s: After this many seconds it is ended with its descendants.
        folder: Where it starts.
    """
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        status: Optional[int] = None
        try:
            status = process.wait(limit_s)
        except subprocess.TimeoutExpired:
            os.write(log.fileno(), f"\nended after the limit of {limit_s:g} s\n".encode())
        finally:
            if process.poll() is None:
                end_descendants(process.pid, and_itself=True)
                process.wait()
        log.seek(0)
        return Ended(status, log.read().decode(errors="replace"))

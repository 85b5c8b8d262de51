"""A lock on a folder, which only one process can hold."""

from __future__ import annotations

import contextlib
import fcntl
import os
import time
from pathlib import Path
from typing import Iterator, Optional

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError

# How long somebody who adds one fact waits for another who does the same.
SHORT_WAIT_S = 5.0
# `writer_of` holds the lock for a moment.
_LOOK_S = 0.2
_POLL_S = 0.01


@contextlib.contextmanager
def locked(folder: Path, wait_s: float = _LOOK_S) -> Iterator[None]:
    """Hold the lock of a survey's folder, as every writer of it does; readers need not.

    It ends with the process at the latest.

    Raises:
        SurveyRefusedError: Another process holds it, also after `wait_s`.
        OSError: The folder cannot be opened or locked.
    """
    descriptor = os.open(str(folder), os.O_RDONLY | os.O_DIRECTORY)
    try:
        deadline_s = time.monotonic() + wait_s
        while not _take(descriptor, fcntl.LOCK_EX):
            if time.monotonic() >= deadline_s:
                raise SurveyRefusedError(
                    Message(
                        "the survey in {folder} is being written by another process ({process}), "
                        "for example by another robot with the same data folder; end the survey "
                        "there first, or the process if it hangs",
                        folder=printable(folder),
                        process=_holder(descriptor),
                    ),
                    fault=faults.LOCKED,
                )
            time.sleep(_POLL_S)
        yield
    finally:
        os.close(descriptor)


def writer_of(folder: Path) -> Optional[str]:
    """Return the number of the process that writes a survey's folder; None: nobody does."""
    descriptor = os.open(str(folder), os.O_RDONLY | os.O_DIRECTORY)
    try:
        return None if _take(descriptor, fcntl.LOCK_SH) else _holder(descriptor)
    finally:
        os.close(descriptor)


def _take(descriptor: int, kind: int) -> bool:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _holder(descriptor: int) -> str:
    """Return the number of the process that holds a lock; "?" if this system does not show it."""
    # Lines as "1: FLOCK  ADVISORY  WRITE 4711 00:2a:52 0 EOF", with the inode after the device.
    inode = str(os.fstat(descriptor).st_ino)
    locks = Path("/proc/locks")
    lines = locks.read_text(encoding="ascii").splitlines() if locks.exists() else []
    found = [one for one in map(str.split, lines) if one[1] == "FLOCK"]
    return next((one[4] for one in found if one[5].split(":")[-1] == inode), "?")

"""A lock on a folder, which only one process can hold."""

from __future__ import annotations

import contextlib
import fcntl
import os
from pathlib import Path
from typing import Iterator

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError, printable


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a survey's folder; it ends with the process at the latest.

    It writes nothing, and does not prevent anybody from reading the folder or from changing it
    without asking for the lock.

    Raises:
        SurveyRefusedError: Another process holds it.
        OSError: The folder cannot be opened or locked.
    """
    descriptor = os.open(str(folder), os.O_RDONLY | os.O_DIRECTORY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise SurveyRefusedError(
                Message(
                    "the survey in {folder} is being written by another process ({process}), for "
                    "example by another robot with the same data folder; end the survey there "
                    "first, or the process if it hangs",
                    folder=printable(folder),
                    process=_holder(descriptor),
                ),
                fault=faults.LOCKED,
            ) from None
        yield
    finally:
        os.close(descriptor)


def _holder(descriptor: int) -> str:
    """Return the number of the process that holds a lock; "?" if this system does not show it."""
    # Lines as "1: FLOCK  ADVISORY  WRITE 4711 00:2a:52 0 EOF", with the inode after the device.
    inode = os.fstat(descriptor).st_ino
    locks = Path("/proc/locks")
    for line in locks.read_text(encoding="ascii").splitlines() if locks.exists() else []:
        columns = line.split()
        if columns[1] == "FLOCK" and columns[5].split(":")[-1] == str(inode):
            return columns[4]
    return "?"

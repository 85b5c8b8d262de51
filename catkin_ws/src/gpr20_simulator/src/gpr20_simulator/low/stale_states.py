"""Clearing away the shared states of launches that have ended."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import time
from pathlib import Path
from typing import List

# A shared state that was just made is opened, and a node that died is there again, within this [s].
GRACE_S = 60.0
# A shared state, or the step memory of one of its axes.
NAME = re.compile(r"([0-9a-f]{32})(_[xyz]_steps)?")


def remove_stale_states(folder: Path) -> int:
    """Remove the shared states that no process has open, with the files beside them.

    Args:
        folder: Where the states of this user are; may be missing.

    Returns:
        How many files were removed.

    Raises:
        OSError: The folder cannot be read, or a file not be removed.
    """
    names = sorted(one.name for one in folder.iterdir()) if folder.is_dir() else []
    known = [match for match in map(NAME.fullmatch, names) if match]
    states = sorted({match.group(1) for match in known})
    return sum(_remove(folder, state, [one.group() for one in known]) for state in states)


def _remove(folder: Path, state: str, names: List[str]) -> int:
    paths = [folder / name for name in names if name.startswith(state)]
    with contextlib.ExitStack() as held:
        for path in paths:
            try:
                stream = held.enter_context(path.open("rb"))
            except FileNotFoundError:
                return 0  # another launch clears away, too
            if abs(time.time() - os.fstat(stream.fileno()).st_mtime) < GRACE_S:
                return 0
            if path.name == state and not _is_free(stream.fileno()):
                return 0
        # While the lock is held: who opens the state now sees that it is gone.
        for path in paths:
            path.unlink()
    return len(paths)


def _is_free(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True

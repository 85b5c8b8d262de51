"""How fast a disk stores traces durably."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

# As a survey: one JSON file and two recordings.
FILES = 3
TRACES = 4
ENOUGH_S = 2.0


def slowest_trace_s(folder: Path, trace_bytes: int) -> float:
    """Return how long the slowest of some traces took [s], each flushed to the disk.

    The files have no names, so nothing is left of them however this process ends.

    Args:
        folder: On the disk.
        trace_bytes: Size of one trace in all files together.

    Raises:
        OSError: The disk refused.
    """
    # Random, so that a disk that compresses does not gain from it.
    part = os.urandom(trace_bytes // FILES)
    slowest_s = 0.0
    first_s = time.monotonic()
    for _trace in range(TRACES):
        begin_s = time.monotonic()
        for _file in range(FILES):
            with tempfile.TemporaryFile(dir=folder, prefix=".gpr20-", suffix=".tmp") as file:
                file.write(part)
                file.flush()
                os.fsync(file.fileno())
        slowest_s = max(slowest_s, time.monotonic() - begin_s)
        if time.monotonic() - first_s > ENOUGH_S:
            break
    return slowest_s

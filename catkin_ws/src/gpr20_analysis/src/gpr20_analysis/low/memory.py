"""How much memory may still be had."""

from __future__ import annotations

import resource
from pathlib import Path

MEMINFO = Path("/proc/meminfo")
AVAILABLE = "MemAvailable:"
BYTES_PER_KIB = 1024


def available_bytes(meminfo: Path = MEMINFO) -> int:
    """Return what the system can give without swapping, or this process's own limit if less.

    Raises:
        OSError: The system does not tell.
    """
    lines = meminfo.read_text(encoding="ascii").splitlines()
    told = [int(line.split()[1]) * BYTES_PER_KIB for line in lines if line.startswith(AVAILABLE)]
    if not told:
        raise OSError(f"{meminfo} does not tell {AVAILABLE[:-1]}")
    limits = (resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_DATA, resource.RLIMIT_AS))
    return min([*told, *(limit for limit in limits if limit != resource.RLIM_INFINITY)])

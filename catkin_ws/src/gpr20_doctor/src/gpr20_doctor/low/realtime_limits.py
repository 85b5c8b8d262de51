"""What the system grants to processes that make pulses."""

from __future__ import annotations

import os
import resource
import threading
from typing import List, Optional


def priority_limit() -> int:
    """Return the highest real-time priority that this user may set."""
    return resource.getrlimit(resource.RLIMIT_RTPRIO)[0]


def memory_limit() -> Optional[int]:
    """Return how much memory this user may lock [bytes]; None: no limit."""
    limit = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    return None if limit == resource.RLIM_INFINITY or os.geteuid() == 0 else limit


def can_set_priority(priority: int) -> bool:
    """Return whether SCHED_FIFO with a priority is granted."""
    granted: List[bool] = []

    def try_it() -> None:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except OSError:
            granted.append(False)
        else:
            granted.append(True)

    # In Linux it holds for the calling thread, and this one ends at once.
    thread = threading.Thread(target=try_it)
    thread.start()
    thread.join()
    return granted == [True]

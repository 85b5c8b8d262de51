"""Asking the system for punctual wake-ups."""

from __future__ import annotations

import ctypes
import gc
import os
from dataclasses import dataclass
from typing import List

# Below the kernel's own real-time threads (50 and 99), above everything else.
PRIORITY = 45
# From <sys/mman.h> and <sys/prctl.h> of Linux.
MCL_CURRENT, MCL_FUTURE = 1, 2
PR_SET_TIMERSLACK = 29


@dataclass(frozen=True)
class Scheduling:
    """What the system granted.

    Attributes:
        realtime: Whether all of it was granted.
        sentence: What was, and why not all, for people.
    """

    realtime: bool
    sentence: str


# Everything is left as it is for a robot whose time is not the real one.
ORDINARY = Scheduling(False, "ordinary scheduling: the simulated robot does not run in real time")


def realtime_scheduling() -> Scheduling:
    """Ask for SCHED_FIFO, locked memory and exact timers for this process.

    What is refused is named in the answer; the process works without it, less punctually.
    """
    # A collection in the middle of a move would be a late pulse; there are no cycles to collect.
    gc.collect()
    gc.freeze()
    gc.disable()
    refused: List[str] = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError as error:
        refused.append(f"SCHED_FIFO ({error.strerror})")
    library = ctypes.CDLL(None, use_errno=True)
    if library.mlockall(MCL_CURRENT | MCL_FUTURE) != 0:
        refused.append(f"locked memory ({os.strerror(ctypes.get_errno())})")
    # Only has an effect without SCHED_FIFO: ordinary timers may fire 50 us late by design.
    library.prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)
    if refused:
        return Scheduling(
            False,
            f"pulses without real-time scheduling, refused: {', '.join(refused)}; allow rtprio and "
            "memlock in /etc/security/limits.d",
        )
    return Scheduling(True, f"real-time scheduling: SCHED_FIFO {PRIORITY}, memory locked")

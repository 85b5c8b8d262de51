"""Real-time scheduling of a process."""

from __future__ import annotations

import ctypes
import gc
import os
from dataclasses import dataclass
from typing import List

from gpr20_common.faults import NOT_SET_UP
from gpr20_common.message import Message
from gpr20_survey.axes.axis_parameters import PULSE_PRIORITY

# From <sys/mman.h> and <sys/prctl.h> of Linux.
MCL_CURRENT, MCL_FUTURE = 1, 2
PR_SET_TIMERSLACK = 29


@dataclass(frozen=True)
class Scheduling:
    """What the system granted.

    Attributes:
        realtime: Whether all of it was granted.
        message: What was granted, and what to do if not all was.
    """

    realtime: bool
    message: Message


# For a simulated robot that moves faster than the real one.
ORDINARY = Scheduling(
    False, Message("ordinary scheduling: the simulated robot does not run in real time")
)


def realtime_scheduling() -> Scheduling:
    """Request SCHED_FIFO, locked memory and exact timers for this process.

    The result names what was refused; the process works without it, less punctually.
    """
    # A garbage collection during a move would delay a pulse; there are no cycles to collect.
    gc.collect()
    gc.freeze()
    gc.disable()
    refused: List[str] = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PULSE_PRIORITY))
    except OSError as error:
        refused.append(f"SCHED_FIFO ({error.strerror})")
    library = ctypes.CDLL(None, use_errno=True)
    if library.mlockall(MCL_CURRENT | MCL_FUTURE) != 0:
        refused.append(f"locked memory ({os.strerror(ctypes.get_errno())})")
    # Has an effect only without SCHED_FIFO: ordinary timers may fire 50 us late by design.
    library.prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)
    if refused:
        without = Message(
            "pulses are made without real-time scheduling and can be late; allow rtprio and "
            "memlock in /etc/security/limits.d",
            details=f"refused: {', '.join(refused)}",
        ).with_fault(NOT_SET_UP.as_warning())
        return Scheduling(False, without)
    granted = Message("real-time scheduling", details=f"SCHED_FIFO {PULSE_PRIORITY}, memory locked")
    return Scheduling(True, granted)

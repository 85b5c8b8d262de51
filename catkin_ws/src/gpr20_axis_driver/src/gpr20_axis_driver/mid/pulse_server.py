"""The process that makes the pulses of an axis: what its node starts and sends motions to.

It gets the axis's hardware (pickled, opened here) and then one motion at a time. It ends, with the
pins low, when its parent closes the connection or dies; a parent that hangs ends the motion.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import signal
import sys
import time
from multiprocessing.connection import Connection
from typing import List, NoReturn

from gpr20_axis_driver.faults import PulseProcessError
from gpr20_axis_driver.low.step_counter import StepCounter
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.motion import AxisHardware
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_SET_UP
from gpr20_common.message import Message
from gpr20_survey.axes.axis_parameters import PULSE_PRIORITY

# The parent counts a beat with every poll; one that counts none for this long can no longer
# stop the motion.
SILENT_PARENT_S = 2.0
# How often the endstop of an axis at rest is read [s].
ENDSTOP_PERIOD_S = 0.1
PARENT_GONE = (EOFError, BrokenPipeError, ConnectionResetError)
# From <sys/mman.h> and <sys/prctl.h> of Linux.
MCL_CURRENT, MCL_FUTURE = 1, 2
PR_SET_TIMERSLACK = 29
ORDINARY = Message("ordinary scheduling: the simulated robot does not run in real time")


def main() -> NoReturn:
    """Run as the process; the arguments are two descriptors and the parent's number."""
    # From here on a termination runs every `finally`, so the pins end low.
    signal.signal(signal.SIGTERM, lambda _signal, _frame: sys.exit(128 + signal.SIGTERM))
    connection = Connection(int(sys.argv[1]))
    try:
        _serve(connection, StepCounter(int(sys.argv[2])), int(sys.argv[3]))
    except PARENT_GONE:
        # The parent has closed the connection or is dead; nobody is left to report to.
        sys.exit(0)
    except Gpr20Error as error:
        with contextlib.suppress(*PARENT_GONE):  # its launch may end already
            connection.send(PulseProcessError(error.message))
        sys.exit(1)
    except Exception as error:
        failure = Message(
            "the pulse process of this axis failed; see the log and home the axis",
            details=f"{type(error).__name__}: {error}",
        )
        connection.send(PulseProcessError(failure))
        raise


def _serve(connection: Connection, counter: StepCounter, parent: int) -> NoReturn:
    """Carry out the parent's motions until it closes the connection or dies."""
    hardware: AxisHardware = connection.recv()
    scheduling = realtime_scheduling() if hardware.realtime else ORDINARY
    loop = PulseLoop.of(hardware, counter)
    try:
        connection.send(scheduling)
        # Without an endstop there is nothing to read, and the process sleeps until a motion comes.
        period_s = None if hardware.parameters.sensor_pin is None else ENDSTOP_PERIOD_S
        while True:
            loop.read_endstop()
            while not connection.poll(period_s):
                loop.read_endstop()
            motion = connection.recv()
            connection.send(loop.run(motion, _Parent(counter, parent).wants_stop))
    finally:
        loop.close()


class _Parent:
    """Decides, during one motion, whether to end it."""

    def __init__(self, counter: StepCounter, number: int) -> None:
        self._counter = counter
        self._number = number
        self._note()

    def _note(self) -> None:
        self._beats, self._noted_s = self._counter.beats, time.monotonic()

    def wants_stop(self) -> bool:
        """Return whether the parent requested the end, is dead, or hangs."""
        # A dead parent cannot set the flag; its child is then adopted by another process.
        if self._counter.stop_requested or os.getppid() != self._number:
            return True
        if self._counter.beats != self._beats:
            self._note()
        return time.monotonic() - self._noted_s > SILENT_PARENT_S


def realtime_scheduling() -> Message:
    """Request SCHED_FIFO, locked memory and exact timers for this process.

    Returns what was granted, or with a fault what was refused; the process works without it, less
    punctually.
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
        return Message(
            "pulses are made without real-time scheduling and can be late; allow rtprio and "
            "memlock in /etc/security/limits.d",
            details=f"refused: {', '.join(refused)}",
        ).with_fault(NOT_SET_UP.as_warning())
    return Message("real-time scheduling", details=f"SCHED_FIFO {PULSE_PRIORITY}, memory locked")


if __name__ == "__main__":
    main()

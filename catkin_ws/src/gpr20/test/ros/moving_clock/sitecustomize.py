"""A computer's clock that is set while the robot runs: Python imports this at its start.

GPR20_CLOCK_OFFSET is a file that holds the seconds by which the time of day is off. The
monotonic clock is not touched, as on a real computer.
"""

import os
import time
from pathlib import Path

OFFSET = Path(os.environ["GPR20_CLOCK_OFFSET"])


def offset_s():
    """Return by how much the clock is off now [s]."""
    try:
        return int(OFFSET.read_text() or 0)
    except FileNotFoundError:
        return 0


def set_off(call, unit):
    """Return a call that returns the time of day by the clock that is off."""
    return lambda: call() + offset_s() * unit


time.time = set_off(time.time, 1)
time.time_ns = set_off(time.time_ns, 10**9)

"""Doing something again and again until the node ends."""

from __future__ import annotations

import math
import threading
import time
from typing import Callable

import rospy

from gpr20_common.low.thread_fault import log_fault

STOP_LIMIT_S = 2.0
# A call that fails again and again is logged this often [s].
LOG_PERIOD_S = 10.0


class Periodic:
    """Calls a function at a fixed rate [s] in a thread of its own, also after a call that failed.

    It ends before the node's topics are closed; a `rospy.Timer` would publish to closed ones.
    """

    def __init__(self, period_s: float, action: Callable[[], None]) -> None:
        self._period_s = period_s
        self._action = action
        self._name = getattr(action, "__qualname__", repr(action))
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._repeat, name=self._name, daemon=True)
        self._thread.start()
        rospy.on_shutdown(self.stop)

    def stop(self) -> None:
        """Return when no call is under way and none will come."""
        self._ended.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(STOP_LIMIT_S)

    def _repeat(self) -> None:
        due_s, logged_s = time.monotonic(), -math.inf
        while not self._ended.wait(max(0.0, due_s - time.monotonic())):
            # Calls that were missed are left out, not made up for in a burst.
            late = time.monotonic() - due_s >= self._period_s
            due_s = (time.monotonic() if late else due_s) + self._period_s
            try:
                self._action()
            except Exception:  # the next call is independent of it
                if time.monotonic() - logged_s >= LOG_PERIOD_S:
                    logged_s = time.monotonic()
                    log_fault(self._name)

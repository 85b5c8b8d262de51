"""Doing something again and again until the node ends."""

from __future__ import annotations

import threading
import time
from typing import Callable

import rospy

STOP_LIMIT_S = 2.0


class Periodic:
    """Calls a function at a fixed rate in a thread of its own.

    It ends before the node's topics are closed. A `rospy.Timer` runs a moment longer
    and then publishes to a closed topic.
    """

    def __init__(self, period_s: float, action: Callable[[], None]) -> None:
        self._period_s = period_s
        self._action = action
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._repeat, daemon=True)
        self._thread.start()
        rospy.on_shutdown(self.stop)

    def stop(self) -> None:
        """Return when no call is under way and none will come."""
        self._ended.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(STOP_LIMIT_S)

    def _repeat(self) -> None:
        due_s = time.monotonic()
        while not self._ended.is_set():
            self._action()
            # Calls that were missed are left out, not made up for in a burst.
            due_s = max(due_s + self._period_s, time.monotonic())
            self._ended.wait(due_s - time.monotonic())

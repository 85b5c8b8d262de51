"""A clock that runs faster than the real one, for drivers of a faster simulated robot."""

from __future__ import annotations

import threading
import time

from gpr20_common.low.clock import Clock


class ScaledClock(Clock):
    """Lets `factor` seconds pass in each real second.

    A driver that waits by this clock works unchanged, `factor` times as fast.
    """

    def __init__(self, factor: float) -> None:
        self._factor = factor

    @property
    def factor(self) -> float:
        """How many times faster than the real time this clock runs."""
        return self._factor

    def now_s(self) -> float:
        """Return the scaled time [s] since some fixed moment."""
        return time.monotonic() * self._factor

    def sleep_until_s(self, deadline_s: float) -> None:
        """Return once the scaled time has reached the deadline [s]."""
        remaining_s = deadline_s / self._factor - time.monotonic()
        if remaining_s > 0.0:
            time.sleep(remaining_s)

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        """Wait for the event for at most `timeout_s` scaled seconds."""
        return event.wait(timeout_s / self._factor)

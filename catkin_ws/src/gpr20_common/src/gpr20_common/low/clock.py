"""The passing of time, as a thing that can be handed in."""

from __future__ import annotations

import threading
import time


def time_of_day_us() -> int:
    """Return the time of day [us since 1970, UTC], for time stamps alone: it may be set."""
    return time.time_ns() // 1000


class Clock:
    """Seconds that only go forward, and waiting for them; beside them, the time of day."""

    def now_s(self) -> float:
        return time.monotonic()

    def time_of_day_us(self) -> int:
        return time_of_day_us()

    def sleep_until_s(self, deadline_s: float) -> None:
        """Return once `now_s()` has reached the deadline [s]; at once if it is past."""
        time.sleep(max(0.0, deadline_s - time.monotonic()))

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        return event.wait(timeout_s)

"""Time that only the test moves."""

import threading


class FakeClock:
    def __init__(self) -> None:
        self._now_s = 1000.0

    def now_s(self) -> float:
        return self._now_s

    def advance(self, seconds: float) -> None:
        self._now_s += seconds

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        self._now_s += timeout_s
        return event.is_set()

"""The time limit of a request, and the end of all requests."""

from __future__ import annotations

import threading

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_vna_acquisition.errors import VnaClosedError, VnaTimeoutError


class RequestDeadline:
    """Limits a request as a whole: an instrument that is slow at every step counts as hanging."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._closed = False
        # Set when the running request must end before its time limit.
        self._ending = threading.Event()
        self._limit_s = 0.0
        self._begun_s = self._deadline_s = clock.now_s()

    def begin(self, limit_s: float) -> None:
        """Begin a request that may take `limit_s` [s]."""
        self._ending.clear()
        self._limit_s = limit_s
        self._begun_s = self._clock.now_s()
        self._deadline_s = self._begun_s + limit_s

    def extend(self, duration_s: float) -> None:
        """Allow the running request so much more time [s]."""
        self._limit_s += duration_s
        self._deadline_s += duration_s

    def close(self) -> None:
        """End the running request at its next step, and every later one at its first."""
        self._closed = True
        self._ending.set()

    def abandon(self) -> None:
        """End the running request at its next step, if there is one."""
        self._ending.set()

    def since_begin_s(self) -> float:
        """Return how long ago [s] the last request began."""
        return self._clock.now_s() - self._begun_s

    def now_s(self) -> float:
        """Return the time [s] since a fixed moment."""
        return self._clock.now_s()

    def check(self) -> None:
        """Do nothing, unless the request must end.

        Raises:
            VnaClosedError: The driver is shutting down.
            VnaTimeoutError: The request exceeded its time limit, or was abandoned.
        """
        if self._closed:
            raise VnaClosedError(Message("the VNA driver is shutting down"))
        if self._ending.is_set():
            raise VnaTimeoutError(Message("the request was ended by a later one"))
        if self._clock.now_s() > self._deadline_s:
            raise VnaTimeoutError(
                Message("request exceeded {limit_s:.3g} s", limit_s=self._limit_s)
            )

    def pause_s(self, duration_s: float) -> None:
        """Wait [s], unless the request must end; raise as `check` does."""
        self._clock.wait_s(self._ending, duration_s)
        self.check()

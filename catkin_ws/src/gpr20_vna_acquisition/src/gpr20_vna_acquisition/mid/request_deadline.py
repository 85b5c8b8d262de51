"""The time limit of a request, and the end of all requests."""

from __future__ import annotations

import threading

from gpr20_common.faults import BUSY
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
        self._limit_s = self._extended_s = 0.0
        self._extensible = False
        self._deadline_s = clock.now_s()

    def begin(self, limit_s: float, waited_s: float = 0.0, extensible: bool = False) -> None:
        """Begin a request.

        Args:
            limit_s: How long it may take [s].
            waited_s: For how much of that it already waited for another request [s].
            extensible: Whether `extend` applies to it.
        """
        self._ending.clear()
        self._limit_s = limit_s
        self._deadline_s = self._clock.now_s() + limit_s - waited_s
        self._extensible, self._extended_s = extensible, 0.0

    def extend(self, duration_s: float) -> None:
        """Allow an extensible request so much more time [s] in total.

        Each attempt of a request may call it; only the longest duration counts. Any other request
        keeps its limit, which its caller knows.
        """
        more_s = max(0.0, duration_s - self._extended_s)
        if self._extensible:
            self._extended_s += more_s
            self._limit_s += more_s
            self._deadline_s += more_s

    def close(self) -> None:
        """End the running request at its next step, and every later one at its first."""
        self._closed = True
        self._ending.set()

    def abandon(self) -> None:
        """End the running request at its next step, if there is one."""
        self._ending.set()

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
            raise _superseded()
        if self._clock.now_s() > self._deadline_s:
            raise VnaTimeoutError(
                Message(
                    "the VNA took longer than {limit_s:.3g} s for a request", limit_s=self._limit_s
                )
            )

    def pause_s(self, duration_s: float) -> None:
        """Wait [s], unless the request must end; raise as `check` does."""
        self._clock.wait_s(self._ending, duration_s)
        self.check()


class LentDeadline:
    """The time limit of the requests for a class outside this package, until it is taken back.

    A call of such a class may never return. If it does after it was given up, it must neither use
    the instrument again nor change the time limit of a later request.
    """

    def __init__(self, deadline: RequestDeadline) -> None:
        self._deadline = deadline
        self._taken_back = threading.Event()

    def take_back(self) -> None:
        """End whatever still uses it, at its next step."""
        self._taken_back.set()

    def extend(self, duration_s: float) -> None:
        """Allow an extensible request so much more time [s] in total."""
        self.check()
        self._deadline.extend(duration_s)

    def now_s(self) -> float:
        """Return the time [s] since a fixed moment."""
        return self._deadline.now_s()

    def check(self) -> None:
        """Do nothing, unless the request must end; raise as `RequestDeadline.check` does."""
        if self._taken_back.is_set():
            raise _superseded()
        self._deadline.check()

    def pause_s(self, duration_s: float) -> None:
        """Wait [s], unless the request must end; raise as `check` does."""
        self.check()
        self._deadline.pause_s(duration_s)
        self.check()


def _superseded() -> VnaTimeoutError:
    return VnaTimeoutError(Message("the request was ended by a later one"), fault=BUSY)

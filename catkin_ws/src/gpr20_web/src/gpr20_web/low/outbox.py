"""Sending things in a thread of its own, without anybody waiting for it."""

from __future__ import annotations

import queue
import threading
from typing import Callable, Generic, Optional, Tuple, TypeVar

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.message import Message
from gpr20_web import faults

Thing = TypeVar("Thing")
LONGEST_DELAY_S = 300.0


class Outbox(Generic[Thing]):
    """Sends in the order in which it was given; what fails is tried again behind the others.

    Args:
        send: Sends one thing; OSError and Gpr20Error: it did not succeed.
        failure: What did not succeed, for the report.
        report: Takes each new problem, in that thread.
        delay_s: After a failure [s]; twice as long after each that follows, to 5 min.
        tries: How often a thing is tried.

    Attributes:
        problem: Why the last try did not succeed; None if it did.
    """

    def __init__(
        self,
        send: Callable[[Thing], None],
        failure: Message,
        report: Callable[[Message], None],
        delay_s: float,
        tries: int,
    ) -> None:
        self._send, self._failure, self._report = send, failure, report
        self._delay_s, self._tries = delay_s, tries
        self._things: queue.Queue[Optional[Tuple[Thing, int]]] = queue.Queue()
        self._ended = threading.Event()
        self.problem: Optional[Message] = None
        self._thread = threading.Thread(target=self._work, name="outbox", daemon=True)
        self._thread.start()

    def put(self, thing: Thing) -> None:
        """Send a thing later."""
        self._things.put((thing, self._tries))

    def close(self, limit_s: float) -> None:
        """Try once more to send what waits, for at most so long [s]; then no more."""
        self._ended.set()
        self._things.put(None)
        self._thread.join(limit_s)

    def _work(self) -> None:
        failures = 0
        for thing, tries in iter(self._things.get, None):
            failures += 1
            with faults_logged("outbox"):
                if self._is_sent(thing):
                    failures = 0
                    continue
                if tries > 1:
                    self._things.put((thing, tries - 1))
                self._ended.wait(min(self._delay_s * 2.0 ** min(failures - 1, 20), LONGEST_DELAY_S))

    def _is_sent(self, thing: Thing) -> bool:
        former = self.problem
        try:
            self._send(thing)
        except (OSError, Gpr20Error) as error:
            reason = error.message if isinstance(error, Gpr20Error) else os_reason(error)
            self.problem = Message("{failure}: {reason}", failure=self._failure, reason=reason)
            if former is None:
                self._report(self.problem.with_fault(faults.NOT_SENT))
            return False
        self.problem = None
        return True

"""Sending one thing after another without anybody waiting for it."""

from __future__ import annotations

import threading
from collections import deque
from typing import Callable, Deque, Generic, Optional, Tuple, TypeVar

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.message import Message
from gpr20_web import faults

Thing = TypeVar("Thing")
MOST_WAITING = 1000
LONGEST_DELAY_S = 300.0


class Outbox(Generic[Thing]):
    """Sends in the order in which it was given, in a thread of its own.

    Args:
        send: Sends one thing. OSError: it is tried again; Gpr20Error: it is given up.
        failure: What did not succeed, for the report.
        report: Takes each new problem, in that thread.
        delay_s: Before the second try [s]; twice as long before each that follows, to 5 min.
        tries: How often a thing is tried; None: until it succeeds.

    Attributes:
        problem: Why the last try did not succeed; None if it did.
    """

    def __init__(
        self,
        send: Callable[[Thing], None],
        failure: Message,
        report: Callable[[Message], None],
        delay_s: float,
        tries: Optional[int] = None,
    ) -> None:
        self._send, self._failure, self._report = send, failure, report
        self._delay_s, self._tries = delay_s, tries
        self._things: Deque[Thing] = deque()
        self._lost, self._ended = 0, False
        self._changed = threading.Condition()
        self.problem: Optional[Message] = None
        self._thread = threading.Thread(target=self._work, name="outbox", daemon=True)
        self._thread.start()

    def put(self, thing: Thing) -> None:
        """Send a thing later; it is lost, and that is reported, while too many wait."""
        with self._changed:
            if len(self._things) < MOST_WAITING:
                self._things.append(thing)
            else:
                self._lost += 1
            self._changed.notify_all()

    @property
    def waiting(self) -> Tuple[Thing, ...]:
        """What is not sent yet, the oldest first."""
        with self._changed:
            return tuple(self._things)

    def close(self, limit_s: float) -> None:
        """Send what waits, as long as that succeeds, for at most so long [s]; then no more."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        self._thread.join(limit_s)

    def _work(self) -> None:
        failures = 0
        while self._wait(failures):
            thing = self._things[0]
            again = False
            with faults_logged("outbox"):
                again = self._try(thing)
            failures = failures + 1 if again else 0
            if self._tries is not None and failures >= self._tries:
                again, failures = False, 0
            with self._changed:
                if not again:
                    self._things.popleft()
                lost, self._lost = self._lost, 0
            if lost:
                words = Message("{failure}: {count} lost", failure=self._failure, count=lost)
                self._report(words.with_fault(faults.NOT_SENT))

    def _wait(self, failures: int) -> bool:
        """Return when the next thing is to be tried, or nothing any more."""
        with self._changed:
            delay_s = min(self._delay_s * 2.0 ** min(failures - 1, 20), LONGEST_DELAY_S)
            if failures and self._changed.wait_for(lambda: self._ended, delay_s):
                return False
            self._changed.wait_for(lambda: self._ended or bool(self._things))
            return bool(self._things)

    def _try(self, thing: Thing) -> bool:
        """Try to send; return whether it must be tried again."""
        former, again = self.problem, False
        try:
            self._send(thing)
            self.problem = None
        except (OSError, Gpr20Error) as error:
            again = isinstance(error, OSError)
            reason = os_reason(error) if isinstance(error, OSError) else error.message
            self.problem = Message("{failure}: {reason}", failure=self._failure, reason=reason)
            if former is None or not again:
                self._report(self.problem.with_fault(faults.NOT_SENT))
        return again

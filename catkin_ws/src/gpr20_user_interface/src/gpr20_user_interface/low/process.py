"""This process: signals that ask it to stop, and its end."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import Any, Callable, Dict, NoReturn, Optional

NAMES = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM"}


class SecondStopSignal(BaseException):
    """A second signal: leave at once.

    Not an Exception, so that no handler of failures catches it.
    """


def _raise_second() -> None:
    raise SecondStopSignal


class StopSignals:
    """While entered, the first signal calls one callable, each further one another.

    Both are called in the main thread between any two steps of the program: they may set a
    flag, use `queue.SimpleQueue.put` or raise, but not wait for a lock.

    Args:
        on_first: Called with the name of the first signal.
        on_next: Called at each further one; by default raises SecondStopSignal.
    """

    def __init__(
        self, on_first: Callable[[str], None], on_next: Callable[[], None] = _raise_second
    ) -> None:
        self._on_first = on_first
        self._on_next = on_next
        self._count = 0
        self._former: Dict[int, Any] = {}

    @property
    def received(self) -> bool:
        """Whether there was a signal."""
        return self._count > 0

    def __enter__(self) -> StopSignals:
        for number in NAMES:
            self._former[number] = signal.signal(number, self._receive)
        return self

    def __exit__(self, *_exception: object) -> None:
        for number, handler in self._former.items():
            signal.signal(number, handler)

    def _receive(self, number: int, _frame: Optional[FrameType]) -> None:
        self._count += 1
        if self._count == 1:
            self._on_first(NAMES[signal.Signals(number)])
        else:
            self._on_next()


def leave_now(status: int) -> NoReturn:
    """End the process without the exit handlers of libraries, which may wait for the network."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)

"""Events on their way from other threads and from signals to the main thread."""

from __future__ import annotations

import queue
from typing import Optional

from gpr20_user_interface.mid.events import Event


class EventQueue:
    """A queue that a signal handler may put into while the main thread waits at it."""

    def __init__(self) -> None:
        # Unlike queue.Queue its put() is reentrant.
        self._queue: queue.SimpleQueue = queue.SimpleQueue()

    def put(self, event: Event) -> None:
        """Add an event; never blocks."""
        self._queue.put(event)

    def next(self, timeout_s: float) -> Optional[Event]:
        """Wait for the next event for at most `timeout_s` [s]; None if there was none."""
        try:
            return self._queue.get(timeout=timeout_s)
        except queue.Empty:
            return None

"""A thread for the calls of a library that may never return."""

from __future__ import annotations

import threading
import time
from queue import SimpleQueue
from typing import Any, Callable, Optional

# How often a waiting caller asks whether it must give up [s].
CHECK_PERIOD_S = 0.1


class CallNotEndedError(TimeoutError):
    """A call did not end in time, and still runs."""


class _Call:
    def __init__(self, action: Callable[[], Any]) -> None:
        self.action = action
        self.done = threading.Event()
        self.result: Any = None
        self.error: Optional[BaseException] = None

    def run(self) -> None:
        try:
            self.result = self.action()
        except BaseException as error:  # the caller raises it in its own thread
            self.error = error
        self.done.set()


class CallThread:
    """Makes calls one after the other, so that the caller can give up each of them.

    A call that was given up may still run. Nothing may follow it but `end`.
    """

    def __init__(self, name: str) -> None:
        self._calls: SimpleQueue[Optional[_Call]] = SimpleQueue()
        self._running: Optional[_Call] = None
        threading.Thread(target=self._work, name=name, daemon=True).start()

    @property
    def busy(self) -> bool:
        """Whether a call that was given up still runs."""
        return self._running is not None and not self._running.done.is_set()

    def run(self, action: Callable[[], Any], limit_s: float, check: Callable[[], None]) -> Any:
        """Make a call and return its result.

        Args:
            action: The call.
            limit_s: How long it may take [s].
            check: Called again and again while it runs; raises if the caller must give up.

        Raises:
            CallNotEndedError: It took longer.
        """
        call = self._running = _Call(action)
        deadline_s = time.monotonic() + limit_s
        self._calls.put(call)
        while not call.done.wait(min(CHECK_PERIOD_S, max(0.0, deadline_s - time.monotonic()))):
            check()
            if time.monotonic() >= deadline_s:
                raise CallNotEndedError(f"not ended within {limit_s:.3g} s")
        if call.error is not None:
            raise call.error
        return call.result

    def end(self) -> None:
        """End the thread when its last call has ended; does not wait."""
        self._calls.put(None)

    def _work(self) -> None:
        while True:
            call = self._calls.get()
            if call is None:
                return
            call.run()

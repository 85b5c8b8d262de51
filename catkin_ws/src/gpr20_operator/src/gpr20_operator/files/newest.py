"""Work beside the window's thread, of which only the newest counts."""

from __future__ import annotations

import threading
from typing import Callable, Generic, Optional, TypeVar

from gpr20_common.low.thread_fault import faults_logged

Value = TypeVar("Value")


class Newest(Generic[Value]):
    """Calls a function with the newest value in a thread: a slow disk never delays the window."""

    def __init__(self, act: Callable[[Value], None]) -> None:
        self._act = act
        self._changed = threading.Condition()
        self._wanted: Optional[Value] = None
        self._working = False

    def put(self, value: Value) -> None:
        """Call the function soon; a value that waits is dropped."""
        with self._changed:
            self._wanted = value
            if self._working:
                return
            self._working = True
        threading.Thread(target=self._work, name=self._act.__qualname__, daemon=True).start()

    def wait(self, timeout_s: float) -> bool:
        """Return whether nothing is left to do within a time [s]."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._working, timeout_s)

    def _work(self) -> None:
        while True:
            with self._changed:
                if self._wanted is None:
                    self._working = False
                    self._changed.notify_all()
                    return
                value, self._wanted = self._wanted, None
            with faults_logged(self._act.__qualname__):
                self._act(value)

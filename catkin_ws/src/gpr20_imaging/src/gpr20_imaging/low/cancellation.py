"""Whether a request was cancelled, and what ends it."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import Callable, Iterator, Optional

from gpr20_common.message import Message
from gpr20_imaging.errors import CancelledError


class Cancellation:
    """The wish to end one request; may be used from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._is_cancelled = False
        self._stop: Optional[Callable[[], None]] = None

    def cancel(self) -> None:
        """End what runs for the request, and what it would begin."""
        with self._lock:
            self._is_cancelled = True
            if self._stop is not None:
                self._stop()

    def check(self) -> None:
        """Raise if the request was cancelled.

        Raises:
            CancelledError: It was.
        """
        if self._is_cancelled:
            raise CancelledError(Message("The request was cancelled."))

    @contextmanager
    def stopping(self, stop: Callable[[], None]) -> Iterator[None]:
        """Call a function if the request is cancelled inside the block.

        Args:
            stop: Ends what the block waits for.

        Raises:
            CancelledError: The request was cancelled, before the block or in it.
        """
        with self._lock:
            self.check()
            self._stop = stop
        try:
            yield
        finally:
            with self._lock:
                self._stop = None
        self.check()

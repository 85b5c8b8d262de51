"""Computes images beside the window."""

from __future__ import annotations

import threading
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Iterable, Optional

from PyQt5.QtCore import QObject, pyqtSignal

from gpr20_viewer.session import ImageRequest, ViewSession


class Closed(Exception):
    """The window was closed, so a computation in progress ends."""


class LiveBridge(QObject):
    """Computes the latest request; one that was replaced before its turn is never begun.

    Attributes:
        computed: An image is ready.
        failed: The image of a request cannot be made: request, error.
    """

    # Emitted by the worker; they arrive in the window's own thread.
    computed = pyqtSignal(object)
    failed = pyqtSignal(object, object)

    def __init__(self, session: ViewSession) -> None:
        super().__init__()
        self._session = session
        self._worker = ThreadPoolExecutor(1, "images")
        self._last: Optional[Future] = None
        self._closed = threading.Event()

    def request(self, wanted: ImageRequest) -> None:
        """Compute an image next, in place of one that is still waiting."""
        if self._last is not None:
            self._last.cancel()
        self._last = self._worker.submit(self._compute, wanted)

    def close(self) -> None:
        """End the thread; return when nothing more will be emitted."""
        self._closed.set()
        self._worker.shutdown()

    def _compute(self, wanted: ImageRequest) -> None:
        try:
            self.computed.emit(self._session.compute(wanted, self._until_closed))
        except Closed:
            return
        # The window shows it, and asks for something else.
        except Exception as error:
            self.failed.emit(wanted, error)

    def _until_closed(self, items: Iterable, total: Optional[int] = None) -> Iterable:
        for item in items:
            if self._closed.is_set():
                raise Closed
            yield item

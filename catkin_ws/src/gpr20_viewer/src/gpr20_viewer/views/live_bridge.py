"""Passes what a worker thread computed to the thread of the window."""

from __future__ import annotations

from PyQt5.QtCore import QObject, pyqtSignal

from gpr20_viewer.latest_worker import LatestWorker
from gpr20_viewer.live_image import ImageRequest, LiveImage
from gpr20_viewer.session import ViewSession


class LiveBridge(QObject):
    """Computes images of a session beside the window.

    Attributes:
        computed: An image is ready.
        failed: The image of a request cannot be made: request, error.
    """

    computed = pyqtSignal(object)
    failed = pyqtSignal(object, object)

    def __init__(self, session: ViewSession) -> None:
        super().__init__()
        # Signals are emitted by the worker and arrive in the window's own thread.
        self._worker: LatestWorker[ImageRequest, LiveImage] = LatestWorker(
            session.compute,
            lambda _request, image: self.computed.emit(image),
            self.failed.emit,
        )

    def request(self, wanted: ImageRequest) -> None:
        """Compute an image next, in place of one that is still waiting."""
        self._worker.request(wanted)

    def close(self) -> None:
        """End the thread; return when nothing more will be emitted."""
        self._worker.close()

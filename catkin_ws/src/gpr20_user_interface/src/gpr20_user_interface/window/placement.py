"""The place of the window on the screen: the whole screen, or a window that fits on it."""

from __future__ import annotations

from dataclasses import dataclass

from PyQt5.QtCore import QEvent, QObject, QRect, Qt
from PyQt5.QtGui import QGuiApplication, QScreen
from PyQt5.QtWidgets import QWidget


@dataclass(frozen=True)
class Area:
    """A rectangle on the screen [pixels]."""

    left: int
    top: int
    width: int
    height: int

    def contains(self, other: Area) -> bool:
        """Whether another rectangle is completely inside this one."""
        return (
            self.left <= other.left
            and self.top <= other.top
            and other.left + other.width <= self.left + self.width
            and other.top + other.height <= self.top + self.height
        )


def fitted(window: Area, frame: Area, free: Area) -> Area:
    """Return the largest place of a framed window that is not larger than it is now.

    Args:
        window: The window without its frame.
        frame: The window with its frame.
        free: The part of the screen that windows may use.

    Returns:
        Left and top of the frame, width and height of the window without it.
    """
    sides, ends = frame.width - window.width, frame.height - window.height
    width = min(window.width, free.width - sides)
    height = min(window.height, free.height - ends)
    left = max(free.left, min(frame.left, free.left + free.width - width - sides))
    top = max(free.top, min(frame.top, free.top + free.height - height - ends))
    return Area(left, top, width, height)


# A window manager adds the frame after the window is shown, and may move it once more. Later the
# place is the user's.
PLACED_AFTER_EVENTS = 20


class ScreenPlacement(QObject):
    """Shows a window and keeps all of it on the screen.

    Args:
        window: The window.
        full_screen: Whether it covers the screen, without a frame. Otherwise it keeps its size
            if it fits on the screen together with its frame, and is smaller if not.
    """

    def __init__(self, window: QWidget, full_screen: bool) -> None:
        super().__init__(window)
        self._window = window
        self._full_screen = full_screen
        self._events_left = PLACED_AFTER_EVENTS
        if full_screen:
            window.setWindowFlag(Qt.WindowType.FramelessWindowHint)
        application = QGuiApplication.instance()
        if isinstance(application, QGuiApplication):
            application.primaryScreenChanged.connect(lambda _screen: self._place())
            application.screenAdded.connect(self._watch)
        for screen in QGuiApplication.screens():
            self._watch(screen)

    def show(self) -> None:
        """Show the window."""
        self._place()
        if self._full_screen:
            self._window.showFullScreen()
        else:
            self._window.installEventFilter(self)
            self._window.show()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window."""
        if event.type() in (QEvent.Type.Move, QEvent.Type.Resize) and self._events_left > 0:
            self._events_left -= 1
            self._place()
        return super().eventFilter(watched, event)

    def _watch(self, screen: QScreen) -> None:
        # A screen that is rotated, or has another resolution.
        screen.geometryChanged.connect(lambda _geometry: self._screen_changed())

    def _screen_changed(self) -> None:
        self._events_left = PLACED_AFTER_EVENTS
        self._place()

    def _place(self) -> None:
        screen = QGuiApplication.primaryScreen()
        if screen is None:
            return  # while it is being replaced by another one
        if self._full_screen:
            if self._window.geometry() != screen.geometry():
                self._window.setGeometry(screen.geometry())
            return
        window, frame = self._window.geometry(), self._window.frameGeometry()
        free = _area(screen.availableGeometry())
        if not free.contains(_area(frame)):
            place = fitted(_area(window), _area(frame), free)
            self._window.resize(place.width, place.height)
            self._window.move(place.left, place.top)


def _area(rectangle: QRect) -> Area:
    return Area(rectangle.left(), rectangle.top(), rectangle.width(), rectangle.height())

"""Which touches count: none right after a change under the finger, none on a locked screen.

STOP always counts.
"""

from __future__ import annotations

import enum
import math
from typing import Callable, Optional, Sequence

from PyQt5.QtCore import QCoreApplication, QEvent, QObject, QPoint, QPointF, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent, QTouchEvent, QWindow
from PyQt5.QtWidgets import QPushButton, QStackedWidget, QWidget

from gpr20_common.low.clock import Clock
from gpr20_user_interface.look.look import look_of

# After a change [s]: a bounced touch comes within about 0.15 s; a person needs longer to see what
# has opened.
QUIET_S = 0.4


class TouchTarget(enum.Enum):
    """What a touch begins on."""

    STOP = "stop"
    UNLOCK = "unlock"
    OTHER = "other"
    TOO_SMALL = "too small"
    """What a gloved finger does not hit alone on this screen."""
    DIMMED = "dimmed"
    """What nobody sees well."""


class _Touch(enum.Enum):
    """What becomes of the touch that is there."""

    NONE = enum.auto()
    IGNORED = enum.auto()
    TAKEN = enum.auto()
    # Of STOP: nothing ends it but the finger.
    STOP = enum.auto()


class TouchGuard:
    """Decides about touches. Belongs to one thread.

    Attributes:
        locked: Whether the screen is locked against touches.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._changed_s = -math.inf
        self._touch = _Touch.NONE
        self.locked = False

    @property
    def quiet(self) -> bool:
        """Whether what is under a finger has just changed."""
        return self._clock.now_s() - self._changed_s < QUIET_S

    @property
    def taken(self) -> bool:
        """Whether there is a touch that counts."""
        return self._touch in (_Touch.TAKEN, _Touch.STOP)

    @property
    def touching(self) -> bool:
        """Whether there is a touch, whether it counts or not."""
        return self._touch is not _Touch.NONE

    def press(self, target: TouchTarget) -> bool:
        """Begin a touch; return whether it counts."""
        if target is TouchTarget.STOP:
            self._touch = _Touch.STOP
        elif self._allows(target):
            self._touch = _Touch.TAKEN
        else:
            self._touch = _Touch.IGNORED
        return self.taken

    def release(self) -> bool:
        """End the touch; return whether it counted to its end."""
        taken, self._touch = self.taken, _Touch.NONE
        return taken

    def note_change(self) -> bool:
        """Note that something was opened or closed under the finger.

        Returns:
            Whether a touch that counted is to be dropped: it was meant for something else.
        """
        self._changed_s = self._clock.now_s()
        return self.drop()

    def set_locked(self, locked: bool) -> bool:
        """Lock or unlock the screen; return as `note_change`."""
        self.locked = locked
        return self.note_change()

    def drop(self) -> bool:
        """Take the touch no more, as when another finger comes; return as `note_change`."""
        if self._touch is not _Touch.TAKEN:
            return False
        self._touch = _Touch.IGNORED
        return True

    def _allows(self, target: TouchTarget) -> bool:
        if self.quiet or target in (TouchTarget.TOO_SMALL, TouchTarget.DIMMED):
            return False
        return not self.locked or target is TouchTarget.UNLOCK


TOUCH_CHANGE = QEvent.Type(QEvent.registerEventType())


def note_touch_change(widget: QWidget) -> None:
    """Tell the window of a widget that the widget has opened or closed something.

    The window takes no touch for a moment: one that comes now was meant for what was there
    before.
    """
    QCoreApplication.sendEvent(widget.window(), QEvent(TOUCH_CHANGE))


PRESSES = (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick)
BEGINS = (*PRESSES, QEvent.Type.TouchBegin, QEvent.Type.Wheel, QEvent.Type.KeyPress)
# Outside of every widget: a button that is released here does not act.
NOWHERE = QPointF(-100_000.0, -100_000.0)


class TouchFilter(QObject):
    """Passes on the touches of a window that its TouchGuard takes.

    It looks at what the screen sends to the whole window, so that nothing in the window has to
    know of it. Qt makes a mouse event of every touch.

    Args:
        window: The window.
        guard: Decides.
        stop: The button that always works.
        unlock: The button that works while the screen is locked.
        views: Work on a screen that is too small to operate the robot, where nothing else does.
        wake: Notes a touch; returns whether it only wakes a dimmed screen.
    """

    # A finger or a key has come, whatever becomes of it.
    touched = pyqtSignal()
    # A touch came that does not count because the screen is too small.
    too_small = pyqtSignal()

    def __init__(
        self,
        window: QWidget,
        guard: TouchGuard,
        stop: QPushButton,
        unlock: QWidget,
        views: Sequence[QWidget],
        wake: Callable[[], bool],
    ) -> None:
        super().__init__(window)
        self._window = window
        self.guard = guard
        self._stop = stop
        self._unlock = unlock
        self._views, self._wake = views, wake
        self._screen: Optional[QWindow] = None
        window.installEventFilter(self)

    def watch_pages(self) -> None:
        """Notice from now on when another tab or page is shown."""
        for pages in self._window.findChildren(QStackedWidget):
            if isinstance(pages, QStackedWidget):
                pages.currentChanged.connect(lambda _number: self.note_change())

    def note_change(self) -> None:
        """Note that something else is under the finger now."""
        self._drop(self.guard.note_change())

    def set_locked(self, locked: bool) -> None:
        """Lock or unlock the screen."""
        self._drop(self.guard.set_locked(locked))

    def take_fingers(self, places: Sequence[QPoint]) -> None:
        """Note that several fingers touch the screen.

        Qt makes a mouse of the first one alone: STOP would not notice another one while a hand
        rests on the screen.

        Args:
            places: Where fingers have just come.
        """
        self.touched.emit()
        self._drop(self.guard.drop())
        if self._stop in map(self._window.childAt, places):
            self._stop.pressed.emit()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window, or comes from the screen."""
        if watched is self._window:
            if event.type() == TOUCH_CHANGE:
                self.note_change()
            elif event.type() in (QEvent.Type.Show, QEvent.Type.WinIdChange):
                self._follow_screen()
            return False
        if event.type() in BEGINS:
            self.touched.emit()
        if isinstance(event, QMouseEvent):
            return self._is_ignored(event)
        if event.type() == QEvent.Type.Wheel:
            return self.guard.quiet or self.guard.locked
        if event.type() == QEvent.Type.KeyPress:
            return self._wake()
        if isinstance(event, QTouchEvent) and len(event.touchPoints()) > 1:
            begins = Qt.TouchPointState.TouchPointPressed
            points = [one for one in event.touchPoints() if one.state() == begins]
            if points:
                self.take_fingers([one.pos().toPoint() for one in points])
        return False

    def _is_ignored(self, event: QMouseEvent) -> bool:
        if event.source() == Qt.MouseEventSource.MouseEventSynthesizedByApplication:
            return False  # that of _drop
        if event.type() in PRESSES:
            return not self._takes_press(event)
        if event.type() == QEvent.Type.MouseButtonRelease:
            return self.guard.touching and not self.guard.release()
        return self.guard.touching and not self.guard.taken

    def _takes_press(self, event: QMouseEvent) -> bool:
        if event.type() == QEvent.Type.MouseButtonDblClick and self.guard.touching:
            return self.guard.taken  # Qt's second event of the same press
        if self.guard.touching and event.buttons() != event.button():
            self._drop(self.guard.drop())
            return self.guard.taken
        target = self._target(event)
        if self._wake() and target is not TouchTarget.STOP:
            target = TouchTarget.DIMMED
        if target is TouchTarget.TOO_SMALL and not self.guard.locked:
            self.too_small.emit()
        return self.guard.press(target)

    def _target(self, event: QMouseEvent) -> TouchTarget:
        touched = self._window.childAt(event.pos())
        if touched is self._stop:
            return TouchTarget.STOP
        if touched is self._unlock:
            return TouchTarget.UNLOCK
        seen = any(one is touched or one.isAncestorOf(touched) for one in self._views)
        return (
            TouchTarget.OTHER if seen or look_of(self._window).touchable else TouchTarget.TOO_SMALL
        )

    def _drop(self, dropped: bool) -> None:
        """Let the widget that has a touch forget it, without acting."""
        if not dropped or self._screen is None:
            return
        release = QMouseEvent(
            QEvent.Type.MouseButtonRelease,
            *(NOWHERE, NOWHERE, NOWHERE),
            Qt.MouseButton.LeftButton,
            Qt.MouseButtons(Qt.MouseButton.NoButton),
            Qt.KeyboardModifiers(Qt.KeyboardModifier.NoModifier),
            Qt.MouseEventSource.MouseEventSynthesizedByApplication,
        )
        # Not at once: the widget may be in the middle of the press.
        QCoreApplication.postEvent(self._screen, release)

    def _follow_screen(self) -> None:
        screen = self._window.windowHandle()
        if screen is not None and screen is not self._screen:
            self._screen = screen
            screen.installEventFilter(self)

"""Connects the window with its guard against touches, and with the lock of the screen."""

from __future__ import annotations

from typing import Callable, Sequence

from PyQt5.QtCore import QEvent, QObject, Qt, pyqtSignal
from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_user_interface.look.look import look_of
from gpr20_user_interface.touch.filter import TouchFilter
from gpr20_user_interface.touch.guard import TouchGuard
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_label, row, say

BAND_PX = 62


class LockBand(QWidget):
    """Says why touches have no effect, over the bottom of a locked or a small screen.

    There are buttons, which do not act then; the title of a card stays in sight.
    """

    unlocked = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("lock_band")
        self.unlock = HoldButton()
        say(self.unlock, Message("HOLD TO UNLOCK"))
        self.unlock.held.connect(self.unlocked)
        self.text = new_label("locked", wraps=True)
        self.locked = False
        # Not where the lock is: a touch that comes twice must not begin the hold.
        self.setLayout(row((self.text, 1), self.unlock))
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.hide()
        window.installEventFilter(self)

    def show_state(self, locked: bool) -> None:
        """Show whether the screen is locked; a screen that is too small always says so."""
        self.locked = locked
        self.unlock.setVisible(locked)
        small = Message("This screen is too small to operate the robot. Use 800x480 or larger.")
        say(self.text, Message("Screen locked. STOP works.") if locked else small)
        self.setVisible(locked or not look_of(self).touchable)
        self.cover()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window."""
        if event.type() == QEvent.Type.Resize:
            self.cover()
        return super().eventFilter(watched, event)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed, such as the size of everything."""
        if event.type() == QEvent.Type.StyleChange:
            self.show_state(self.locked)
        super().changeEvent(event)

    def cover(self) -> None:
        """Lie over everything that is there, also over what has opened since."""
        window, height_px = self.parentWidget(), look_of(self).px(BAND_PX)
        self.setGeometry(0, window.height() - height_px, window.width(), height_px)
        self.raise_()


class TouchBinding:
    """Guards every touch of a window; it is made when everything else in the window exists.

    Args:
        window: The window.
        stop: STOP, which always works.
        views: Work on a screen that is too small to operate the robot.
        wake: Notes a touch; returns whether it only wakes a dimmed screen.
        clock: Measures the time after something has opened or closed.

    Attributes:
        band: What a locked screen shows.
        touches: Takes the touches.
    """

    def __init__(
        self,
        window: QWidget,
        stop: QPushButton,
        views: Sequence[QWidget],
        wake: Callable[[], bool],
        clock: Clock,
    ) -> None:
        self._window = window
        self.band = LockBand(window)
        self.band.unlock.set_clock(clock)
        self.band.unlocked.connect(lambda: self.set_locked(False))
        self.touches = TouchFilter(
            *(window, TouchGuard(clock), stop, self.band.unlock, views, wake)
        )
        self.touches.watch_pages()
        self.touches.too_small.connect(self._on_too_small)

    def set_locked(self, locked: bool) -> None:
        """Lock or unlock the screen, and show which it is."""
        self.touches.set_locked(locked)
        self.band.show_state(locked)

    def _on_too_small(self) -> None:
        # Nothing on a small screen could close them.
        for overlay in self._window.findChildren(Overlay):
            if isinstance(overlay, Overlay):
                overlay.hide()

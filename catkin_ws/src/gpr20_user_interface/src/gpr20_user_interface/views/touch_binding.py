"""Connects the window with its guard against touches, and with the lock of the screen."""

from __future__ import annotations

from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.low.clock import Clock
from gpr20_user_interface.mid.touch_guard import TouchGuard
from gpr20_user_interface.views.binding import Binding
from gpr20_user_interface.views.lock_band import BAND_PX, LockBand
from gpr20_user_interface.views.lock_button import LockButton
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.touch_filter import TouchFilter


class TouchBinding(Binding):
    """Guards every touch of a window; it is made when everything else in the window exists.

    Args:
        window: The window.
        stop: STOP, which always works.
        clock: Measures the time after something has opened or closed.

    Attributes:
        lock_button: Locks the screen; for the right of the tabs.
        band: What a locked screen shows.
        touches: Takes the touches.
    """

    def __init__(self, window: QWidget, stop: QPushButton, clock: Clock) -> None:
        self._window = window
        self.lock_button = LockButton()
        self.lock_button.clicked.connect(lambda: self.set_locked(True))
        self.band = LockBand(window)
        self.band.unlock.set_clock(clock)
        self.band.unlocked.connect(lambda: self.set_locked(False))
        self.touches = TouchFilter(window, TouchGuard(clock), stop, self.band.unlock)
        self.touches.watch_pages()
        self.touches.refused.connect(self.band.flash)

    def set_locked(self, locked: bool) -> None:
        """Lock or unlock the screen, and show which it is."""
        self.touches.set_locked(locked)
        self.band.setVisible(locked)
        for overlay in self._window.findChildren(Overlay):
            if isinstance(overlay, Overlay):
                overlay.leave_free(BAND_PX if locked else 0)
        if locked:
            self.band.cover()

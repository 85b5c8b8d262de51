"""Connects the window with its guard against touches, and with the lock of the screen."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QWidget

from gpr20_common.low.clock import Clock
from gpr20_user_interface.look.look import GAP_PX, TOP_BAR_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.touch.filter import TouchFilter
from gpr20_user_interface.touch.guard import TouchGuard
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.widgets import set_look

BAND_PX = 62
FLASH_MS = 600


class LockBand(TranslatedWidget):
    """Covers the top of every tab while the screen is locked; hidden at first."""

    unlocked = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("lock_band")
        self.unlock = HoldButton()
        self.unlock.held.connect(self.unlocked)
        self.text = QLabel()
        self.text.setObjectName("locked")
        self._flash = QTimer(self)
        self._flash.setSingleShot(True)
        self._flash.setInterval(FLASH_MS)
        self._flash.timeout.connect(lambda: set_look(self.text, "flash", False))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(GAP_PX)
        layout.addWidget(self.unlock)
        layout.addWidget(self.text, 1)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.hide()
        window.installEventFilter(self)
        self.retranslate()

    def cover(self) -> None:
        """Lie over everything that is there."""
        look, window = look_of(self), self.parentWidget()
        self.setGeometry(0, look.px(TOP_BAR_PX), window.width(), look.px(BAND_PX))
        self.raise_()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window."""
        if event.type() == QEvent.Type.Resize and self.isVisible():
            self.cover()
        return super().eventFilter(watched, event)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        if self.isVisible():
            self.cover()

    def flash(self) -> None:
        """Let the operator see why a touch does nothing."""
        set_look(self.text, "flash", True)
        self._flash.start()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.unlock.setText(self.tr("HOLD TO UNLOCK"))
        self.text.setText(self.tr("Screen locked. STOP works."))


class TouchBinding(Page):
    """Guards every touch of a window; it is made when everything else in the window exists.

    Args:
        window: The window.
        stop: STOP, which always works.
        clock: Measures the time after something has opened or closed.

    Attributes:
        band: What a locked screen shows.
        touches: Takes the touches.
    """

    def __init__(self, window: QWidget, stop: QPushButton, clock: Clock) -> None:
        self._window = window
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

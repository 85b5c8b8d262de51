"""Connects the window with its guard against touches, and with the lock of the screen."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, QObject, QPointF, QRectF, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QPainter, QPaintEvent, QPen
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QWidget

from gpr20_common.low.clock import Clock
from gpr20_user_interface.look.look import GAP_PX, TAB_PX, TOP_BAR_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.touch.filter import TouchFilter
from gpr20_user_interface.touch.guard import TouchGuard
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.widgets import set_look

SIGN_PX = 30
# In the sixteenths of a degree that Qt counts.
HALF_CIRCLE = 180 * 16


class LockButton(QPushButton):
    """A padlock, painted: not every robot's fonts have one."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("lock")
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Qt: the button, and the padlock on it."""
        super().paintEvent(event)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        side = float(look_of(self).px(SIGN_PX))
        ink = self.palette().buttonText().color()
        painter.translate(QRectF(self.rect()).center())
        painter.fillRect(QRectF(-0.4 * side, -0.05 * side, 0.8 * side, 0.55 * side), ink)
        painter.setPen(QPen(ink, 0.12 * side))
        left, top, width = -0.24 * side, -0.5 * side, 0.48 * side
        painter.drawArc(QRectF(left, top, width, 0.6 * side), 0, HALF_CIRCLE)
        for x in (left, left + width):
            painter.drawLine(QPointF(x, -0.2 * side), QPointF(x, 0.0))


# That of the tabs, and the line below them.
BAND_PX = TAB_PX + 2
FLASH_MS = 600


class LockBand(TranslatedWidget):
    """Covers the bar of the tabs while the screen is locked; hidden at first."""

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
        """Lie over the bar of the tabs, and over everything else that is there."""
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

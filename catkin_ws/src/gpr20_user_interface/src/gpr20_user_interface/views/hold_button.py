"""A button for what must not happen by accident: it acts only after it was held."""

from __future__ import annotations

from PyQt5.QtCore import QRect, QTimer, pyqtSignal
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent
from PyQt5.QtWidgets import QPushButton

from gpr20_user_interface.views.look import look_of
from gpr20_user_interface.views.palette import TextColours

HOLD_MS = 1000
TICK_MS = 50


class HoldButton(QPushButton):
    """Emits `held` when a finger has rested on it; a tap does nothing."""

    held = pyqtSignal()

    def __init__(self, text: str = "") -> None:
        super().__init__(text)
        self.setObjectName("hold")
        self._held_ms = 0
        self._timer = QTimer(self)
        self._timer.setInterval(TICK_MS)
        self._timer.timeout.connect(self._tick)
        self.pressed.connect(self._begin)
        self.released.connect(self._cancel)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger that leaves the button does not hold it."""
        super().mouseMoveEvent(event)
        if not self.rect().contains(event.pos()):
            self._cancel()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Qt: fill the button as time passes."""
        super().paintEvent(event)
        if self._held_ms:
            painter = QPainter(self)
            colour = QColor(look_of(self).text(TextColours.PRESSED).ground)
            colour.setAlphaF(0.6)
            width = self.width() * self._held_ms // HOLD_MS
            painter.fillRect(QRect(0, 0, width, self.height()), colour)

    def _begin(self) -> None:
        self._held_ms = 0
        self._timer.start()

    def _cancel(self) -> None:
        self._timer.stop()
        self._held_ms = 0
        self.update()

    def _tick(self) -> None:
        self._held_ms += TICK_MS
        self.update()
        if self._held_ms >= HOLD_MS:
            self._cancel()
            self.setDown(False)
            self.held.emit()

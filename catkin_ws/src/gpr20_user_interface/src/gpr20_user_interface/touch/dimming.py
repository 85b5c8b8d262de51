"""The dark cover of a dimmed screen, which leaves STOP bright."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import QEvent, QObject, QPoint, QRect, Qt
from PyQt5.QtGui import QColor, QPainter, QPaintEvent, QRegion
from PyQt5.QtWidgets import QWidget

from gpr20_common.low.clock import Clock

# An eighth of the light: what is shown can still be read in the dark.
DARKNESS = QColor(0, 0, 0, 222)


class DimCover(QWidget):
    """Darkens a window some time after the last touch.

    Args:
        window: The window.
        stop: Its button STOP, which is not covered.
        clock: Measures the time.
        after_s: Time after the last touch [s]; None: never.

    Attributes:
        dimmed: Whether the screen is dimmed.
    """

    def __init__(
        self, window: QWidget, stop: QWidget, clock: Clock, after_s: Optional[float] = None
    ) -> None:
        super().__init__(window)
        self._stop, self._clock, self._after_s = stop, clock, after_s
        self._touched_s = clock.now_s()
        self.dimmed = False
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self.hide()
        window.installEventFilter(self)

    def set_after(self, after_s: Optional[float]) -> None:
        """Dim after another time [s] from now on; None: never."""
        self._after_s = after_s
        self.wake()

    def refresh(self, awake: bool) -> None:
        """Dim the screen when it is time.

        Args:
            awake: Whether something is shown that must be seen, such as an alarm.
        """
        if awake:
            self.wake()
        elif self._after_s is not None:
            self.dimmed = self._clock.now_s() - self._touched_s >= self._after_s
        self._show()

    def wake(self) -> bool:
        """Note a touch.

        Returns:
            Whether it only wakes the screen: it must have no other effect, because nobody sees
            well what it would act on. STOP always acts.
        """
        was_dimmed, self.dimmed = self.dimmed, False
        self._touched_s = self._clock.now_s()
        self._show()
        return was_dimmed

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window."""
        if event.type() == QEvent.Type.Resize:
            self._show()
        return super().eventFilter(watched, event)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802
        """Qt: draw the widget."""
        QPainter(self).fillRect(self.rect(), DARKNESS)

    def _show(self) -> None:
        if self.dimmed:
            self.setGeometry(self.parentWidget().rect())
            corner = self._stop.mapTo(self.parentWidget(), QPoint(0, 0))
            bright = QRect(corner, self._stop.size()) if self._stop.isVisible() else QRect()
            self.setMask(QRegion(self.rect()) - QRegion(bright))
            self.raise_()
        self.setVisible(self.dimmed)

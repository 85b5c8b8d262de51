"""The dark cover of a dimmed screen, under which STOP stays bright and acts."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import QEvent, QObject, QPoint, QRect, Qt
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QRegion, QTouchEvent
from PyQt5.QtWidgets import QWidget

from gpr20_common.low.clock import Clock


class Dimming:
    """Dims the screen some time after the last touch.

    Args:
        clock: Measures the time.
        after_s: Time after the last touch [s]; None: never.

    Attributes:
        dimmed: Whether the screen is dimmed.
    """

    def __init__(self, clock: Clock, after_s: Optional[float] = None) -> None:
        self.dimmed = False
        self._clock = clock
        self._after_s = after_s
        self._touched_s = clock.now_s()

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

    def wake(self) -> bool:
        """Note a touch.

        Returns:
            Whether it only wakes the screen: it must have no other effect, because nobody sees
            well what it would act on. STOP always acts.
        """
        was_dimmed, self.dimmed = self.dimmed, False
        self._touched_s = self._clock.now_s()
        return was_dimmed


# An eighth of the light: what is shown can still be read in the dark.
DARKNESS = QColor(0, 0, 0, 222)
BEGINS = (QEvent.Type.MouseButtonPress, QEvent.Type.TouchBegin, QEvent.Type.KeyPress)
ENDS = (
    QEvent.Type.MouseButtonRelease,
    QEvent.Type.TouchEnd,
    QEvent.Type.TouchCancel,
    QEvent.Type.KeyRelease,
)
# Of the touch that woke the screen: parts of it, too.
PARTS = (QEvent.Type.MouseMove, QEvent.Type.MouseButtonDblClick, QEvent.Type.TouchUpdate)


class DimCover(QWidget):
    """Darkens a window while it is dimmed, and takes the touch that wakes it.

    Args:
        window: The window.
        stop: Its button STOP, which is not covered.
        dimming: When the window is dimmed.
    """

    def __init__(self, window: QWidget, stop: QWidget, dimming: Dimming) -> None:
        super().__init__(window)
        self._stop = stop
        self._dimming = dimming
        # Parts of the touch that has woken the screen have no effect either.
        self._waking = False
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_NoSystemBackground)
        self.hide()
        window.installEventFilter(self)

    def refresh(self) -> None:
        """Cover the window if it is dimmed."""
        if self._dimming.dimmed:
            self._cover()
        self.setVisible(self._dimming.dimmed)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Qt: something happens to the window, or to its place on the screen."""
        if watched is self.parentWidget():
            if event.type() == QEvent.Type.Show:
                # What comes from the screen, before any widget gets it.
                self.parentWidget().windowHandle().installEventFilter(self)
            elif event.type() == QEvent.Type.Resize and self.isVisible():
                self._cover()
        elif event.type() in BEGINS and not self._waking:
            self._waking = self._dimming.wake() and not self._meets_stop(event)
            self.refresh()
            return self._waking
        elif event.type() in ENDS and self._waking:
            self._waking = False
            return True
        elif event.type() in PARTS or event.type() in BEGINS:
            return self._waking
        return False

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802
        """Qt: draw the widget."""
        QPainter(self).fillRect(self.rect(), DARKNESS)

    def _meets_stop(self, event: QEvent) -> bool:
        if isinstance(event, QMouseEvent):
            place = event.globalPos()
        elif isinstance(event, QTouchEvent) and event.touchPoints():
            place = event.touchPoints()[0].screenPos().toPoint()
        else:
            return False
        return self._stop.isVisible() and self._stop_area().contains(
            self.parentWidget().mapFromGlobal(place)
        )

    def _stop_area(self) -> QRect:
        corner = self._stop.mapTo(self.parentWidget(), QPoint(0, 0))
        return QRect(corner, self._stop.size())

    def _cover(self) -> None:
        self.setGeometry(self.parentWidget().rect())
        shown = QRegion(self.rect())
        self.setMask(shown - QRegion(self._stop_area()) if self._stop.isVisible() else shown)
        self.raise_()

"""A finger on the screen of a window, or on a picture of the ground, and what is seen there."""

from PyQt5.QtCore import QEvent, QPoint, QPointF, QRect, Qt
from PyQt5.QtGui import QColor, QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from gpr20_user_interface.touch.guard import QUIET_S
from gpr20_user_interface.touch.hold import HoldButton

STEP_S = 0.05
# Touches count again after something has opened or closed.
AFTER_S = QUIET_S + 0.05


class Finger:
    """Touches a window through its screen, so that nothing of the window is left out.

    Time passes only by `wait`.
    """

    def __init__(self, window, clock):
        self._window = window
        self._clock = clock
        self._held = window.findChildren(HoldButton)
        for button in self._held:
            button.set_clock(clock)
        QApplication.processEvents()
        # The window has just opened.
        self.wait(1.0)

    def wait(self, seconds):
        """Let time pass; buttons that are held notice it."""
        while seconds > 0.0:
            self._clock.advance(min(STEP_S, seconds))
            seconds -= STEP_S
            for button in self._held:
                button.tick()

    def press(self, where):
        QTest.mousePress(self._screen, Qt.LeftButton, Qt.NoModifier, self._place(where))

    def move(self, where):
        QTest.mouseMove(self._screen, self._place(where))

    def release(self, where):
        QTest.mouseRelease(self._screen, Qt.LeftButton, Qt.NoModifier, self._place(where))

    def tap(self, where, seconds=0.03):
        place = self._place(where)
        self.press(place)
        self.wait(seconds)
        self.release(place)

    def hold(self, where, seconds=1.1):
        self.tap(where, seconds)

    @property
    def _screen(self):
        return self._window.windowHandle()

    def _place(self, where):
        return where if isinstance(where, QPoint) else place_of(self._window, where).center()


def place_of(window, widget):
    return QRect(widget.mapTo(window, QPoint()), widget.size())


def pixel_of(plot, across, second):
    place = plot.to_screen(across, second)
    return QPoint(round(place.x()), round(place.y()))


def touch(plot, across, second):
    QTest.mouseClick(plot, Qt.LeftButton, pos=pixel_of(plot, across, second))


def drag(plot, start, end, steps=3):
    first, last = (QPointF(pixel_of(plot, *one)) for one in (start, end))
    QTest.mousePress(plot, Qt.LeftButton, pos=first.toPoint())
    for number in range(1, steps + 1):
        at = first + (last - first) * number / steps
        # QTest moves the mouse without a button.
        held = (Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
        QApplication.sendEvent(plot, QMouseEvent(QEvent.MouseMove, at, *held))
    QTest.mouseRelease(plot, Qt.LeftButton, pos=last.toPoint())


def colours(plot, across, second, reach=0):
    image, at = plot.grab().toImage(), pixel_of(plot, across, second)
    around = range(-reach, reach + 1)
    return {QColor(image.pixel(at.x() + dx, at.y() + dy)).name() for dx in around for dy in around}

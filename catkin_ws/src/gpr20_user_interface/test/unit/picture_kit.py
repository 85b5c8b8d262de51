"""Touching and looking at a picture of the ground."""

from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QColor, QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication


def pixel_of(plot, across, second):
    place = plot.to_screen(across, second)
    return QPoint(round(place.x()), round(place.y()))


def touch(plot, across, second):
    """Tap a place of a picture."""
    QTest.mouseClick(plot.viewport(), Qt.LeftButton, pos=pixel_of(plot, across, second))


def drag(plot, start, end, steps=3):
    """Drag a finger from one place of a picture to another one."""
    first, last = (QPointF(pixel_of(plot, *one)) for one in (start, end))
    QTest.mousePress(plot.viewport(), Qt.LeftButton, pos=first.toPoint())
    for number in range(1, steps + 1):
        at = first + (last - first) * number / steps
        # QTest moves the mouse without a button.
        held = (Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
        QApplication.sendEvent(plot.viewport(), QMouseEvent(QEvent.MouseMove, at, *held))
    QTest.mouseRelease(plot.viewport(), Qt.LeftButton, pos=last.toPoint())


def colours(plot, across, second, reach=0):
    """Return the colours around a place as they are painted."""
    image, at = plot.grab().toImage(), pixel_of(plot, across, second)
    around = range(-reach, reach + 1)
    return {QColor(image.pixel(at.x() + dx, at.y() + dy)).name() for dx in around for dy in around}

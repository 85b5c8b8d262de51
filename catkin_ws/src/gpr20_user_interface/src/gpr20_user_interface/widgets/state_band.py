"""The state of the job as a coloured band with a sign and a pattern of its own."""

from __future__ import annotations

from typing import Callable, Dict

from PyQt5.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PyQt5.QtWidgets import QFrame, QLabel

from gpr20_operator.robot.job import JobLevel
from gpr20_user_interface.look.look import LEVEL_COLOURS, look_of
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.widgets.widgets import set_look

SIGN_PX = 36
STRIPE_PX = 10


class StateBand(QFrame):
    """A frame in the colours of a level; a touch asks for more about the state."""

    touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("band")
        self.show_level(JobLevel.REST)

    def show_level(self, level: JobLevel) -> None:
        """Take the colours of a level."""
        set_look(self, "job", level.value)
        for label in self.findChildren(QLabel):
            assert isinstance(label, QLabel)
            set_look(label, "job", level.value)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger leaves the band, or what is written on it."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.touched.emit()


class StateSign(TranslatedWidget):
    """The sign of a level, on its pattern; both are known without their colours."""

    def __init__(self) -> None:
        super().__init__()
        self.level = JobLevel.REST
        self.restyle()

    def show_level(self, level: JobLevel) -> None:
        """Draw the sign of a level."""
        if level is not self.level:
            self.level = level
            self.update()

    def retranslate(self) -> None:
        """A sign is the same in every language."""

    def restyle(self) -> None:
        """Take the size of the look."""
        side_px = look_of(self).px(SIGN_PX)
        if self.minimumWidth() != side_px:
            self.setFixedWidth(side_px)
            self.setMinimumHeight(side_px)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw pattern and sign."""
        look = look_of(self)
        colours = look.text(LEVEL_COLOURS[self.level])
        ink, ground = QColor(colours.ink), QColor(colours.ground)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), ground)
        area = QRectF(self.rect())
        stripe_px = look.px(STRIPE_PX)
        _PATTERNS[self.level](painter, area, ink, stripe_px)
        side = min(area.width(), area.height()) * 0.8
        place = QRectF(0.0, 0.0, side, side)
        place.moveCenter(area.center())
        # The sign has a field of its own, so that the pattern does not hide it.
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(ground)
        painter.drawRect(place)
        inner = place.adjusted(side * 0.2, side * 0.2, -side * 0.2, -side * 0.2)
        _SIGNS[self.level](painter, inner, ink)


def _stripes(painter: QPainter, area: QRectF, ink: QColor, stripe_px: int) -> None:
    painter.setPen(QPen(ink, stripe_px * 0.5))
    x = area.left() - area.height()
    while x < area.right():
        painter.drawLine(QPointF(x, area.bottom()), QPointF(x + area.height(), area.top()))
        x += 1.6 * stripe_px


def _crossed(painter: QPainter, area: QRectF, ink: QColor, stripe_px: int) -> None:
    _stripes(painter, area, ink, stripe_px)
    x = area.left() - area.height()
    while x < area.right():
        painter.drawLine(QPointF(x, area.top()), QPointF(x + area.height(), area.bottom()))
        x += 1.6 * stripe_px


def _plain(_painter: QPainter, _area: QRectF, _ink: QColor, _stripe_px: int) -> None:
    """Draw no pattern."""


def _triangle(painter: QPainter, place: QRectF, ink: QColor) -> None:
    right = QPointF(place.right(), place.center().y())
    painter.setBrush(ink)
    painter.drawPolygon(QPolygonF([place.topLeft(), right, place.bottomLeft()]))


def _bars(painter: QPainter, place: QRectF, ink: QColor) -> None:
    width = place.width() * 0.32
    painter.fillRect(QRectF(place.left(), place.top(), width, place.height()), ink)
    painter.fillRect(QRectF(place.right() - width, place.top(), width, place.height()), ink)


def _mark(painter: QPainter, place: QRectF, ink: QColor) -> None:
    width, height = place.width() * 0.3, place.height()
    left = place.center().x() - width / 2.0
    painter.fillRect(QRectF(left, place.top(), width, height * 0.62), ink)
    painter.fillRect(QRectF(left, place.bottom() - height * 0.24, width, height * 0.24), ink)


def _cross(painter: QPainter, place: QRectF, ink: QColor) -> None:
    painter.setPen(QPen(ink, place.width() * 0.25))
    painter.drawLine(place.topLeft(), place.bottomRight())
    painter.drawLine(place.topRight(), place.bottomLeft())


def _check(painter: QPainter, place: QRectF, ink: QColor) -> None:
    painter.setPen(QPen(ink, place.width() * 0.22))
    low = QPointF(place.left() + place.width() * 0.38, place.bottom() - place.height() * 0.1)
    painter.drawLine(QPointF(place.left(), place.center().y() + place.height() * 0.05), low)
    painter.drawLine(low, place.topRight())


def _square(painter: QPainter, place: QRectF, ink: QColor) -> None:
    painter.fillRect(place, ink)


_PATTERNS: Dict[JobLevel, Callable[[QPainter, QRectF, QColor, int], None]] = {
    JobLevel.WORKING: _plain,
    JobLevel.PAUSED: _stripes,
    JobLevel.ATTENTION: _stripes,
    JobLevel.FAULT: _crossed,
    JobLevel.DONE: _plain,
    JobLevel.REST: _plain,
}
_SIGNS: Dict[JobLevel, Callable[[QPainter, QRectF, QColor], None]] = {
    JobLevel.WORKING: _triangle,
    JobLevel.PAUSED: _bars,
    JobLevel.ATTENTION: _mark,
    JobLevel.FAULT: _cross,
    JobLevel.DONE: _check,
    JobLevel.REST: _square,
}

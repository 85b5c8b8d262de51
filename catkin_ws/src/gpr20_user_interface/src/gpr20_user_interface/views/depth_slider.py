"""The depth of the slice: a slider with ticks that a gloved finger can hit anywhere."""

from __future__ import annotations

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen
from PyQt5.QtWidgets import QSlider

from gpr20_user_interface.mid.radar_pictures import DEPTH_STEP_M
from gpr20_user_interface.mid.ticks import round_ticks
from gpr20_user_interface.views.look import look_of
from gpr20_user_interface.views.palette import Mark, TextColours

STEP_MM = DEPTH_STEP_M * 1000.0
TICK_PX = 8
HANDLE_PX = 16
FIRST_STEPS = 60


class DepthSlider(QSlider):
    """Steps of depth from the surface downwards; the handle jumps to the finger."""

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Vertical)
        self.setInvertedAppearance(True)
        self.setRange(0, FIRST_STEPS)
        self.setPageStep(1)

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: a finger touches the slider."""
        self.setValue(self._steps(event.localPos().y()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the finger moves."""
        self.setValue(self._steps(event.localPos().y()))

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        painter, look = QPainter(self), look_of(self)
        metrics = painter.fontMetrics()
        x = metrics.horizontalAdvance("0000")
        groove = QRectF(x, self._y(0), look.px(TICK_PX), self._y(self.maximum()) - self._y(0))
        painter.fillRect(groove, QColor(look.colour(Mark.BORDER)))
        painter.setPen(QColor(look.colour(Mark.INK)))
        most = int(groove.height() / (1.5 * metrics.height()))
        for depth_mm in round_ticks(0.0, max(1, self.maximum()) * STEP_MM, max(2, most)):
            y, text = self._y(depth_mm / STEP_MM), f"{depth_mm:g}"
            painter.drawLine(QPointF(x - 3, y), QPointF(groove.right() + look.px(TICK_PX), y))
            left = x - 5 - metrics.horizontalAdvance(text)
            painter.drawText(QPointF(left, y + metrics.ascent() / 2.0 - 1), text)
        if not self.isEnabled():
            return
        height = look.px(HANDLE_PX)
        y = self._y(self.value())
        handle = QRectF(x - 2, y - height / 2.0, self.width() - x, height)
        painter.setPen(QPen(QColor(look.colour(Mark.BORDER)), look.px(2)))
        painter.setBrush(QColor(look.text(TextColours.BUTTON).ground))
        painter.drawRoundedRect(handle, 4, 4)

    def _margin(self) -> float:
        return max(self.fontMetrics().height(), look_of(self).px(HANDLE_PX)) / 2.0 + 1

    def _y(self, steps: float) -> float:
        length = self.height() - 2 * self._margin()
        return self._margin() + length * steps / max(1, self.maximum())

    def _steps(self, y: float) -> int:
        length = max(1.0, self.height() - 2 * self._margin())
        part = min(max((y - self._margin()) / length, 0.0), 1.0)
        return round(part * self.maximum())

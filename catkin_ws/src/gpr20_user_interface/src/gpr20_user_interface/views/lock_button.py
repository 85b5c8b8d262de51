"""The button that locks the screen: a padlock."""

from __future__ import annotations

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QPainter, QPaintEvent, QPen
from PyQt5.QtWidgets import QPushButton

from gpr20_user_interface.views.look import look_of

SIGN_PX = 30


class LockButton(QPushButton):
    """A padlock, painted: not every robot's fonts have one."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Qt: the button, and the padlock on it."""
        super().paintEvent(event)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        side = look_of(self).px(SIGN_PX)
        middle = QRectF(self.rect()).center()
        ink = self.palette().buttonText().color()
        body = QRectF(middle - QPointF(side * 0.4, side * 0.05), middle + QPointF(side, side) * 0.4)
        body.setBottom(middle.y() + side * 0.5)
        painter.fillRect(body, ink)
        pen = QPen(ink, side * 0.12)
        painter.setPen(pen)
        bow = QRectF(-side * 0.24, -side * 0.5, side * 0.48, side * 0.6).translated(middle)
        painter.drawArc(bow, 0, 180 * 16)
        for x in (bow.left(), bow.right()):
            painter.drawLine(QPointF(x, bow.center().y()), QPointF(x, body.top()))

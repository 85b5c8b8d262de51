"""The button that locks the screen: a padlock."""

from __future__ import annotations

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QPainter, QPaintEvent, QPen
from PyQt5.QtWidgets import QPushButton

from gpr20_user_interface.views.look import look_of

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

"""A button with a gear wheel, which takes less room than a word."""

from __future__ import annotations

import math

from PyQt5.QtCore import QPointF
from PyQt5.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QPolygonF
from PyQt5.QtWidgets import QPushButton

from gpr20_user_interface.views.look import look_of
from gpr20_user_interface.views.palette import TextColours

TEETH = 8
# Radii, as parts of the height of the button, and half the width of a tooth [parts of a pitch].
TIP, ROOT, HOLE = 0.32, 0.24, 0.11
TOOTH_TIP, TOOTH_ROOT = 0.17, 0.27


class GearButton(QPushButton):
    """Opens settings."""

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Qt: draw the widget."""
        super().paintEvent(event)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(self.width() / 2.0, self.height() / 2.0)
        pair = look_of(self).text(TextColours.PRESSED if self.isDown() else TextColours.BUTTON)
        painter.fillPath(_gear(min(self.width(), self.height())), QColor(pair.ink))


def _gear(size_px: int) -> QPainterPath:
    pitch = 2.0 * math.pi / TEETH
    corners = ((-TOOTH_ROOT, ROOT), (-TOOTH_TIP, TIP), (TOOTH_TIP, TIP), (TOOTH_ROOT, ROOT))
    outline = QPolygonF()
    for tooth in range(TEETH):
        for part, radius in corners:
            angle = (tooth + part) * pitch
            reach = radius * size_px
            outline.append(QPointF(reach * math.cos(angle), reach * math.sin(angle)))
    path = QPainterPath()
    path.addPolygon(outline)
    path.closeSubpath()
    path.addEllipse(QPointF(0.0, 0.0), HOLE * size_px, HOLE * size_px)
    return path

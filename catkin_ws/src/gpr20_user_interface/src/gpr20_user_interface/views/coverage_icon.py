"""The small map of a survey's coverage in the list of surveys."""

from __future__ import annotations

from typing import Optional, Tuple

from PyQt5.QtCore import QRectF, Qt
from PyQt5.QtGui import QBrush, QColor, QIcon, QPainter, QPixmap

from gpr20_user_interface.views.look import Look
from gpr20_user_interface.views.palette import Mark

Coverage = Tuple[Tuple[int, ...], ...]


def coverage_icon(
    coverage: Optional[Coverage], width_mm: float, height_mm: float, size_px: int, look: Look
) -> QIcon:
    """Return the map: full where all is stored, hatched where a part is, empty where nothing is.

    Args:
        coverage: Stored share of each part [%], Y upwards; None: it is not known.
        width_mm: Of the area.
        height_mm: Of the area.
        size_px: Of the longer side.
        look: Colours.
    """
    picture = QPixmap(size_px, size_px)
    picture.fill(Qt.GlobalColor.transparent)
    if coverage is None or width_mm <= 0.0 or height_mm <= 0.0:
        return QIcon(picture)
    longer_mm = max(width_mm, height_mm)
    width_px, height_px = (size_px * one / longer_mm for one in (width_mm, height_mm))
    left_px, top_px = (size_px - width_px) / 2.0, (size_px - height_px) / 2.0
    rows, columns = len(coverage), len(coverage[0])
    painter = QPainter(picture)
    painter.fillRect(QRectF(left_px, top_px, width_px, height_px), QColor(look.colour(Mark.PAPER)))
    part = QBrush(QColor(look.colour(Mark.STOP_PARTLY)), Qt.BrushStyle.Dense4Pattern)
    whole = QBrush(QColor(look.colour(Mark.STOP_DONE)))
    for row, values in enumerate(coverage):
        for column, percent in enumerate(values):
            if percent:
                cell = QRectF(
                    left_px + width_px * column / columns,
                    top_px + height_px * (rows - 1 - row) / rows,
                    width_px / columns + 0.5,
                    height_px / rows + 0.5,
                )
                painter.fillRect(cell, whole if percent == 100 else part)
    painter.setPen(QColor(look.colour(Mark.BORDER)))
    painter.drawRect(QRectF(left_px, top_px, width_px - 1.0, height_px - 1.0))
    painter.end()
    # Chosen rows show it as it is, too.
    icon = QIcon()
    for mode in (QIcon.Mode.Normal, QIcon.Mode.Selected):
        icon.addPixmap(picture, mode)
    return icon

"""Painting what lies over the stops: candidates, markers, frames, the carriage."""

from __future__ import annotations

from typing import Tuple

from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QPainter, QPen, QPolygonF

from gpr20_operator.ground.geometry import Area, MapGeometry
from gpr20_user_interface.look.look import TEXT_PX, Look, Mark

RING_PX = 15.0
FAILED_RING_PX = 11.0
FLAG_PX = 26.0
SMALLEST_FRAME_PX = 14.0


class MarkPainter:
    """Paints marks, each with a rim in the colour of the paper, whatever is below it.

    Args:
        painter: Paints on the map.
        geometry: Where the places are.
        look: Colours and sizes.
    """

    def __init__(self, painter: QPainter, geometry: MapGeometry, look: Look) -> None:
        self._painter = painter
        self._geometry = geometry
        self._look = look
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def candidate(
        self, place_mm: Tuple[float, float], number: int, doubtful: bool, selected: bool
    ) -> None:
        """Paint a numbered ring; dashed: doubtful."""
        painter, centre = self._painter, self._at(place_mm)
        radius = self._px(RING_PX + (3 if selected else 0))
        colour = self._ink(Mark.SELECTED if selected else Mark.CANDIDATE)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self._ink(Mark.PAPER))
        painter.drawEllipse(centre, radius + self._px(2), radius + self._px(2))
        pen = QPen(colour, self._px(4 if selected else 3))
        if doubtful:
            pen.setDashPattern([2.0, 1.4])
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
        painter.setPen(pen)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(centre, radius, radius)
        painter.setPen(self._ink(Mark.INK))
        self._bold(TEXT_PX if number < 100 else TEXT_PX - 4)
        box = QRectF(centre.x() - 2 * radius, centre.y() - radius, 4 * radius, 2 * radius)
        painter.drawText(box, int(Qt.AlignmentFlag.AlignCenter), str(number))

    def marker(self, place_mm: Tuple[float, float], selected: bool) -> None:
        """Paint a flag whose pole has its foot at the place."""
        foot, size = self._at(place_mm), self._px(FLAG_PX)
        top = QPointF(foot.x(), foot.y() - size)
        flag = QPolygonF(
            [
                top,
                QPointF(top.x() + 0.75 * size, top.y() + 0.28 * size),
                QPointF(top.x(), top.y() + 0.56 * size),
            ]
        )
        colour = self._ink(Mark.SELECTED if selected else Mark.MARKER)
        painter = self._painter
        for ink, width in ((self._ink(Mark.PAPER), 7), (colour, 3)):
            pen = QPen(ink, self._px(width))
            pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
            painter.setPen(pen)
            painter.setBrush(ink)
            painter.drawLine(foot, top)
            painter.drawPolygon(flag)
        painter.drawEllipse(foot, self._px(2), self._px(2))

    def failed(self, place_mm: Tuple[float, float]) -> None:
        """Ring a stop that failed, so that one among thousands is seen."""
        centre, radius = self._at(place_mm), self._px(FAILED_RING_PX)
        for pen in self._rimmed(Mark.STOP_FAILED, 3):
            self._painter.setPen(pen)
            self._painter.drawEllipse(centre, radius, radius)

    def stop(
        self, place_mm: Tuple[float, float], spacing_mm: Tuple[float, float], mark: Mark
    ) -> None:
        """Frame a stop.

        Args:
            place_mm: Where it is.
            spacing_mm: Distance of two stops along X and Y.
            mark: Colour of the frame.
        """
        centre = self._at(place_mm)
        smallest = self._px(SMALLEST_FRAME_PX)
        width, height = (max(one * self._geometry.px_per_mm, smallest) for one in spacing_mm)
        frame = QRectF(centre.x() - width / 2.0, centre.y() - height / 2.0, width, height)
        for pen in self._rimmed(mark, 3):
            self._painter.setPen(pen)
            self._painter.drawRect(frame)

    def area(self, area: Area, mark: Mark, dashed: bool) -> None:
        """Frame an area of the ground."""
        left, top = self._geometry.to_screen(area.left_mm, area.high_mm)
        right, bottom = self._geometry.to_screen(area.right_mm, area.low_mm)
        for pen in self._rimmed(mark, 3):
            if dashed:
                pen.setDashPattern([4.0, 3.0])
            self._painter.setPen(pen)
            self._painter.drawRect(QRectF(left, top, right - left, bottom - top))

    def carriage(self, place_mm: Tuple[float, float]) -> None:
        """Paint a cross where the antennas are; at the edge, hollow, if they are off the area."""
        x_mm, y_mm, is_inside = self._geometry.clamped(*place_mm)
        centre, ring, arm = self._at((x_mm, y_mm)), self._px(7), self._px(13)
        for pen in self._rimmed(Mark.CARRIAGE, 2):
            self._painter.setPen(pen)
            self._painter.drawEllipse(centre, ring, ring)
            if is_inside:
                for across, down in ((arm, 0.0), (0.0, arm)):
                    step = QPointF(across, down)
                    self._painter.drawLine(centre - step, centre + step)

    def _rimmed(self, mark: Mark, width: float) -> Tuple[QPen, QPen]:
        self._painter.setBrush(Qt.BrushStyle.NoBrush)
        return (
            QPen(self._ink(Mark.PAPER), self._px(width) + 2 * self._px(1.5)),
            QPen(self._ink(mark), self._px(width)),
        )

    def _at(self, place_mm: Tuple[float, float]) -> QPointF:
        return QPointF(*self._geometry.to_screen(*place_mm))

    def _bold(self, design_px: int) -> None:
        font = QFont(self._painter.font())
        font.setPixelSize(self._look.px(design_px))
        font.setBold(True)
        self._painter.setFont(font)

    def _px(self, design_px: float) -> float:
        return float(self._look.px(design_px))

    def _ink(self, mark: Mark) -> QColor:
        return QColor(self._look.colour(mark))

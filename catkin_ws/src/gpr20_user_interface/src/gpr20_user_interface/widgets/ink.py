"""Painting on pictures of the ground: lines with a rim, rings, flags, numbers and notices."""

from __future__ import annotations

import math
from typing import Iterable, List, Tuple

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QFontMetrics, QPainter, QPen, QPolygonF

from gpr20_operator.ground.texts import GroundMark
from gpr20_operator.palette import NOTICE_GROUND, NOTICE_INK
from gpr20_user_interface.look.look import TEXT_PX, Look, Mark

RING_PX, FAR_PX, FLAG_PX = 14.0, 5.0, 26.0
LINE_PX, HALO_PX = 2.0, 5.0
SMALL_TEXT_PX, SMALLEST_TEXT_PX = 14, 8
PADDING_PX = 6
STEPS = (1.0, 2.0, 5.0, 10.0, 20.0)

# Numbers of an axis, and where they are on it.
Ticks = Iterable[Tuple[float, str]]


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """Return at most so many multiples of 1, 2 or 5 times a power of ten, from `low` to `high`."""
    if not (math.isfinite(high - low) and high > low):
        return np.zeros(0)
    power = 10.0 ** math.floor(math.log10((high - low) / (most + 1)))
    for step in (factor * power for factor in STEPS):
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        if last - first < most:
            return np.arange(first, last + 1) * step
    return np.zeros(0)


def rimmed(look: Look, mark: Mark, width: float) -> Tuple[QPen, QPen]:
    """Return the pens of a line with a rim in the colour of the paper: it is seen on any shade."""
    wide = QPen(QColor(look.colour(Mark.PAPER)), look.px(width) + look.px(HALO_PX - LINE_PX))
    return wide, QPen(QColor(look.colour(mark)), look.px(width))


def stroke(painter: QPainter, look: Look, mark: Mark, points: QPolygonF) -> None:
    """Draw a line that is seen on every shade of a picture."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in rimmed(look, mark, LINE_PX):
        painter.setPen(pen)
        painter.drawPolyline(points)


def paint_mark(painter: QPainter, look: Look, mark: GroundMark, place: QPointF) -> None:
    """Paint a ring around a pixel, or a flag whose foot it is."""
    own = Mark.MARKER if mark.is_flag else Mark.CANDIDATE
    own = Mark.SELECTED if mark.chosen else own if mark.measured else Mark.NOT_MEASURED
    if mark.is_flag:
        _paint_flag(painter, look, place, own, look.px(FLAG_PX if mark.near else FLAG_PX / 2))
        return
    # Filled where nothing is doubted, else open; dashed where it is weaker than a place to check.
    sure = mark.near and mark.measured and getattr(mark.about, "flags", None) == ()
    radius = look.px((RING_PX if mark.near else FAR_PX) + 3 * mark.chosen)
    wide, pen = rimmed(look, own, LINE_PX + 1)
    if mark.doubtful or not mark.measured:
        pen.setDashPattern([2.0, 1.4])
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    paper = QColor(look.colour(Mark.PAPER)) if mark.near else Qt.BrushStyle.NoBrush
    for one, brush in ((wide, paper), (pen, pen.color() if sure else Qt.BrushStyle.NoBrush)):
        painter.setPen(one)
        painter.setBrush(brush)
        painter.drawEllipse(place, radius, radius)
    if mark.near and mark.text:
        size_px = look.px(TEXT_PX if len(mark.text) < 3 else SMALL_TEXT_PX)
        box = QRectF(place.x() - radius, place.y() - radius, 2 * radius, 2 * radius)
        written = Mark.PAPER if sure else Mark.INK if mark.measured else Mark.NOT_MEASURED
        ink = QColor(look.colour(written))
        _paint_text(painter, _sized(painter.font(), size_px, bold=True), box, mark.text, ink)


def _paint_flag(painter: QPainter, look: Look, foot: QPointF, mark: Mark, size: float) -> None:
    top = QPointF(foot.x(), foot.y() - size)
    cloth = [top, top + QPointF(0.75 * size, 0.28 * size), top + QPointF(0.0, 0.56 * size)]
    for pen in rimmed(look, mark, LINE_PX + 1):
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.setPen(pen)
        painter.setBrush(pen.color())
        painter.drawLine(foot, top)
        painter.drawPolygon(QPolygonF(cloth))


def paint_axes(
    painter: QPainter,
    look: Look,
    room: QRectF,
    labels: Tuple[str, str],
    ticks: Tuple[Ticks, Ticks],
    beside: bool,
) -> None:
    """Write titles and numbers along the lower and the left edge, on a picture or beside it."""
    font = _sized(painter.font(), look.px(SMALL_TEXT_PX))
    metrics = QFontMetrics(font)
    line_px = metrics.height()
    inside = QRectF(painter.viewport()) if beside else room.adjusted(-0.5, -0.5, 0.5, 0.5)
    taken: List[Tuple[QRectF, str]] = []

    def put(text: str, x: float, y: float, part: float, always: bool = False) -> None:
        """Take room for a text that has a part of its width before x, if the room is free."""
        wide_px = metrics.horizontalAdvance(text) + 4
        box = QRectF(x - part * wide_px, y, wide_px, line_px)
        free = not any(one.adjusted(-2, 0, 2, 0).intersects(box) for one, _text in taken)
        if text and (always or (free and inside.contains(box))):
            taken.append((box, text))

    bottom_px, top_px = room.bottom() - line_px, room.top()
    if beside:
        bottom_px, top_px = room.bottom() + 3.0, room.top() - line_px - 1.0
    put(labels[0], inside.right() if beside else room.right(), bottom_px, 1.0, always=True)
    put(labels[1], room.left(), top_px, 0.0, always=True)
    for x, text in ticks[0]:
        put(text, x, bottom_px, 0.5)
    for y, text in ticks[1]:
        put(text, room.left() - 3.0 * beside, y - line_px / 2.0, float(beside))
    for box, text in taken:
        painter.fillRect(box, QColor(look.colour(Mark.PAPER)))
        _paint_text(painter, font, box, text, QColor(look.colour(Mark.INK)))


def paint_notice(painter: QPainter, look: Look, room: QRectF, notice: str) -> None:
    """Write a sentence over a picture, in smaller letters where it would be cut off."""
    padding = look.px(PADDING_PX)
    # Below the title of the axis.
    inside = room.adjusted(padding, 4 * padding, -padding, -padding)
    flags = int(Qt.AlignmentFlag.AlignHCenter | Qt.TextFlag.TextWordWrap)
    for size_px in range(look.px(TEXT_PX), SMALLEST_TEXT_PX - 1, -1):
        painter.setFont(_sized(painter.font(), size_px))
        box = QRectF(painter.boundingRect(inside, flags, notice))
        if box.height() <= inside.height() and box.width() <= inside.width():
            break
    painter.fillRect(box.adjusted(-padding, -padding, padding, padding), QColor(NOTICE_GROUND))
    painter.setPen(QColor(NOTICE_INK))
    painter.drawText(inside, flags, notice)


def _paint_text(painter: QPainter, font: QFont, box: QRectF, text: str, ink: QColor) -> None:
    painter.save()
    painter.setFont(font)
    painter.setPen(ink)
    painter.drawText(box, int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextDontClip), text)
    painter.restore()


def _sized(font: QFont, size_px: int, bold: bool = False) -> QFont:
    sized = QFont(font)
    sized.setPixelSize(size_px)
    sized.setBold(bold)
    return sized

"""Plots that a finger cannot drag away: a frame with two axes, and the A-scan."""

from __future__ import annotations

import math
from typing import List, Optional, Tuple, TypeVar

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PyQt5.QtWidgets import QSizePolicy, QWidget

from gpr20_operator.ground.records import Axis, Curve
from gpr20_user_interface.look.look import Look, Mark, look_of

STEPS = (1.0, 2.0, 5.0, 10.0, 20.0)


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """Return multiples of 1, 2 or 5 times a power of ten, from `low` to `high`.

    Args:
        low: First end of the axis.
        high: Other end, larger.
        most: How many there may be, at least one.
    """
    if not (math.isfinite(high - low) and high > low):
        return np.zeros(0)
    power = 10.0 ** math.floor(math.log10((high - low) / (most + 1)))
    for factor in STEPS:
        ticks = _multiples(low, high, factor * power)
        if len(ticks) <= most:
            return ticks
    return np.zeros(0)


def _multiples(low: float, high: float, step: float) -> np.ndarray:
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return np.arange(first, last + 1) * step


TICK_PX = 4
LINE_PX = 2
# A line over a picture has a border in the colour of the paper, so that it is seen on any shade.
HALO_PX = 4
# Half of the gap in the middle of the crosshair.
FREE_PX = 12
MIN_PLOT_PX = 40

# The place of a number on an axis, and the number.
Ticks = List[Tuple[float, str]]
# One place or many.
Places = TypeVar("Places", float, np.ndarray)


class FixedPlot(QWidget):
    """A frame with two axes; the second one may point down.

    A touch emits `touched` with the values of both axes, and while the finger moves, `dragged`.

    Attributes:
        has_numbers: Whether the axes have numbers; those of an empty plot would be made up.
        axis: What the second axis is.
        crosshair: Where the crosshair is on each axis; None: nowhere.
    """

    touched = pyqtSignal(float, float)
    dragged = pyqtSignal(float, float)

    def __init__(self) -> None:
        super().__init__()
        self._labels = ("", "")
        self._across, self._second = (0.0, 1.0), (0.0, 1.0)
        self.axis = Axis.DEPTH_MM
        self.has_numbers = False
        self.crosshair: Tuple[Optional[float], Optional[float]] = (None, None)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(MIN_PLOT_PX, MIN_PLOT_PX)

    def set_labels(self, bottom: str, left: str) -> None:
        """Write beside the axes."""
        if (bottom, left) != self._labels:
            self._labels = (bottom, left)
            self.update()

    def set_crosshair(self, across: Optional[float], second: Optional[float]) -> None:
        """Mark a place on each axis."""
        self.crosshair = (across, second)
        self.update()

    def area(self) -> QRectF:
        """Return the part of the widget where the data are."""
        line = self.fontMetrics().height()
        left = self.fontMetrics().horizontalAdvance("000") + TICK_PX + 3
        right = self.fontMetrics().horizontalAdvance("0")
        width, height = max(1, self.width() - left - right), max(1, self.height() - 2 * line - 4)
        return QRectF(left, line + 1, width, height)

    def to_screen(self, across: float, second: float) -> QPointF:
        """Return the pixel of a place."""
        return QPointF(*self._pixels(across, second))

    def polygon(self, across: np.ndarray, second: np.ndarray) -> QPolygonF:
        """Return the pixels of places."""
        xs, ys = self._pixels(across, second)
        return QPolygonF([QPointF(x, y) for x, y in zip(xs.tolist(), ys.tolist())])

    def _pixels(self, across: Places, second: Places) -> Tuple[Places, Places]:
        area = self.area()
        parts = (across - self._across[0]) / (self._across[1] - self._across[0])
        downs = (second - self._second[0]) / (self._second[1] - self._second[0])
        downs = downs if self.axis.downwards else 1.0 - downs
        return area.left() + parts * area.width(), area.top() + downs * area.height()

    def to_data(self, pixel: QPointF) -> Tuple[float, float]:
        """Return the place of a pixel; pixels outside of the data count as their edge."""
        area = self.area()
        part = min(max((pixel.x() - area.left()) / area.width(), 0.0), 1.0)
        down = min(max((pixel.y() - area.top()) / area.height(), 0.0), 1.0)
        down = down if self.axis.downwards else 1.0 - down
        across, second = self._across, self._second
        return (
            across[0] + part * (across[1] - across[0]),
            second[0] + down * (second[1] - second[0]),
        )

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: a finger touches the plot."""
        if self.has_numbers:
            self.touched.emit(*self.to_data(event.localPos()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the finger moves."""
        if self.has_numbers:
            self.dragged.emit(*self.to_data(event.localPos()))

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        painter, look = QPainter(self), look_of(self)
        painter.fillRect(self.rect(), QColor(look.colour(Mark.PAPER)))
        area = self.area()
        painter.save()
        painter.setClipRect(area)
        self._paint_data(painter, look)
        self._paint_lines(painter, look)
        painter.restore()
        painter.setPen(QPen(QColor(look.colour(Mark.BORDER)), 1))
        painter.drawRect(area)
        if self.has_numbers:
            painter.setPen(QColor(look.colour(Mark.INK)))
            self._paint_axes(painter)

    def _paint_data(self, painter: QPainter, look: Look) -> None:
        """Draw what the plot shows."""

    def _across_ticks(self, most: int) -> Ticks:
        return [(float(one), f"{one:g}") for one in round_ticks(*self._across, most)]

    def _set_axes(
        self, across: Tuple[float, float], second: Tuple[float, float], axis: Axis
    ) -> None:
        self._across, self._second = across, second
        self.axis = axis

    def _paint_lines(self, painter: QPainter, look: Look) -> None:
        area = self.area()
        if self.has_numbers and self.axis is Axis.DEPTH_MM:
            y = self.to_screen(self._across[0], 0.0).y()
            ends = QPolygonF([QPointF(area.left(), y), QPointF(area.right(), y)])
            stroke(painter, look, Mark.SURFACE, ends)
        if self.has_numbers:
            self._paint_crosshair(painter, look)

    def _paint_crosshair(self, painter: QPainter, look: Look) -> None:
        across, second = self.crosshair
        area = self.area()
        here = self.to_screen(
            self._across[0] if across is None else across,
            self._second[0] if second is None else second,
        )
        # What lies under the crosshair stays free.
        free = look.px(FREE_PX) if across is not None and second is not None else 0
        if across is not None:
            x = here.x()
            for ends in ((area.top(), here.y() - free), (here.y() + free, area.bottom())):
                line = QPolygonF([QPointF(x, one) for one in ends])
                stroke(painter, look, Mark.SELECTED, line)
        if second is not None:
            y = here.y()
            for ends in ((area.left(), here.x() - free), (here.x() + free, area.right())):
                line = QPolygonF([QPointF(one, y) for one in ends])
                stroke(painter, look, Mark.SELECTED, line)

    def _paint_axes(self, painter: QPainter) -> None:
        metrics, area = painter.fontMetrics(), self.area()
        bottom, left = self._labels
        base = area.bottom() + metrics.ascent() + 2
        painter.drawText(QPointF(1, metrics.ascent()), left)
        free_px = self.width()
        if bottom:
            wide = metrics.horizontalAdvance(bottom)
            free_px = min(free_px - wide, int(area.right()) + metrics.horizontalAdvance("00"))
            painter.drawText(QPointF(free_px, base), bottom)
        most = int(area.width() / (1.4 * metrics.horizontalAdvance("000")))
        for place, text in self._across_ticks(max(2, most)):
            x, half = self.to_screen(place, 0.0).x(), metrics.horizontalAdvance(text) / 2.0
            if x - half >= 0 and x + half < free_px - 4:
                painter.drawText(QPointF(x - half, base), text)
        most = int(area.height() / (1.6 * metrics.height()))
        for second in round_ticks(*self._second, max(2, most)):
            text, y = f"{second:g}", self.to_screen(0.0, second).y()
            x = area.left() - TICK_PX - 1
            painter.drawLine(QPointF(x + 1, y), QPointF(area.left(), y))
            middle = min(y + metrics.ascent() / 2.0 - 1, area.bottom())
            painter.drawText(QPointF(x - metrics.horizontalAdvance(text), middle), text)


class CurvePlot(FixedPlot):
    """An A-scan, from the top downwards, on the scale of the survey."""

    def __init__(self) -> None:
        super().__init__()
        self._curve: Optional[Curve] = None

    @property
    def points(self) -> Tuple[np.ndarray, np.ndarray]:
        """Shades and places that are drawn."""
        curve = self._curve
        if curve is None:
            return np.zeros(0), np.zeros(0)
        known = np.isfinite(curve.shades)
        return curve.shades[known], curve.places[known]

    def show_curve(self, curve: Optional[Curve]) -> None:
        """Draw a trace; None: nothing."""
        if curve is not None and not np.isfinite(curve.shades).any():
            curve = None
        self._curve = curve
        self.has_numbers = curve is not None
        if curve is not None:
            lowest = -1.0 if curve.signed else 0.0
            places = (float(curve.places[0]), float(curve.places[-1]))
            self._set_axes((lowest, 1.02), places, curve.axis)
        self.update()

    def _across_ticks(self, most: int) -> Ticks:
        if self._curve is None:
            return []
        scale = self._curve.scale
        levels = scale.ticks_db()
        every = max(1, -(-len(levels) // max(1, most)))
        return [(scale.shade_of(float(one)), f"{one:g}") for one in levels[::-every]]

    def _paint_data(self, painter: QPainter, look: Look) -> None:
        shades, places = self.points
        if self._curve is not None:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(QPen(QColor(look.colour(Mark.CURVE)), look.px(LINE_PX)))
            painter.drawPolyline(self.polygon(shades, places))


def stroke(painter: QPainter, look: Look, mark: Mark, points: QPolygonF) -> None:
    """Draw a line that is seen on every shade of a picture."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for colour, width in ((Mark.PAPER, HALO_PX), (mark, LINE_PX)):
        painter.setPen(QPen(QColor(look.colour(colour)), look.px(width)))
        painter.drawPolyline(points)

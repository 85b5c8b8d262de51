"""The drawing of the survey area."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QFontMetrics, QImage, QMouseEvent, QPainter, QPaintEvent, QPen
from PyQt5.QtWidgets import QSizePolicy

from gpr20_user_interface.mid.map_coverage import StopState
from gpr20_user_interface.mid.map_geometry import MapGeometry, fit
from gpr20_user_interface.mid.map_grid import Stop
from gpr20_user_interface.mid.map_model import MapModel
from gpr20_user_interface.views.look import look_of
from gpr20_user_interface.views.palette import Mark
from gpr20_user_interface.views.translation import TranslatedWidget

MARGIN_LEFT_PX, MARGIN_BOTTOM_PX, MARGIN_PX = 44, 22, 10
# Smaller stops are drawn without lines between them.
SMALLEST_WITH_LINES_PX = 7.0
SMALLEST_MARK_PX = 12.0
# Single stops that are not done must not be overlooked among thousands.
MAX_RINGS = 60
RING_PX = 9.0

STOP_MARKS: Dict[StopState, Mark] = {
    StopState.MISSING: Mark.STOP_MISSING,
    StopState.PARTLY: Mark.STOP_PARTLY,
    StopState.DONE: Mark.STOP_DONE,
    StopState.FAILED: Mark.STOP_FAILED,
}


class MapCanvas(TranslatedWidget):
    """Draws a MapModel to scale; a touch chooses the nearest stop."""

    # Carries the Stop.
    stop_touched = pyqtSignal(object)

    def __init__(self, model: MapModel) -> None:
        super().__init__()
        self._model = model
        self._carriage_mm: Optional[Tuple[float, float]] = None
        self._selected: Optional[Stop] = None
        self._picture: Optional[QImage] = None
        self._picture_of: Tuple[Optional[MapModel], int] = (None, -1)
        self.setMinimumSize(200, 200)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    @property
    def geometry_now(self) -> Optional[MapGeometry]:
        """How the area lies on the widget; None while it is not known."""
        grid = self._model.grid
        if grid is None:
            return None
        width = max(1, self.width() - MARGIN_LEFT_PX - MARGIN_PX)
        height = max(1, self.height() - MARGIN_BOTTOM_PX - MARGIN_PX)
        return fit(grid.xs_mm, grid.ys_mm, (MARGIN_LEFT_PX, MARGIN_PX, width, height))

    def set_model(self, model: MapModel) -> None:
        """Draw another survey."""
        self._model = model
        self.update()

    def set_carriage(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas are [mm]; None: not known."""
        if place_mm != self._carriage_mm:
            self._carriage_mm = place_mm
            self.update()

    def set_selected(self, stop: Optional[Stop]) -> None:
        """Mark the stop that the operator looks at."""
        self._selected = stop
        self.update()

    def retranslate(self) -> None:
        """Draw the texts in the language of the application."""
        self.update()

    def restyle(self) -> None:
        """Draw in the colours of the theme."""
        self._picture_of = (None, -1)
        self.update()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Choose the stop below the finger."""
        geometry, grid = self.geometry_now, self._model.grid
        if geometry is None or grid is None:
            return
        x_mm, y_mm = geometry.to_ground(event.localPos().x(), event.localPos().y())
        inside_x, inside_y, _is_inside = geometry.clamped(x_mm, y_mm)
        stop = grid.nearest_stop(inside_x, inside_y)
        if stop is not None:
            self.stop_touched.emit(stop)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw everything."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._ink(Mark.PAPER))
        geometry = self.geometry_now
        if geometry is None:
            painter.drawText(
                self.rect(),
                int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap),
                self.tr("No survey yet: the map appears when one starts."),
            )
            return
        self._draw_stops(painter, geometry)
        self._draw_axes(painter, geometry)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._draw_rings(painter, geometry)
        self._outline(painter, geometry, self._model.current, Mark.CURRENT, Mark.INK)
        self._outline(painter, geometry, self._selected, Mark.SELECTED, Mark.PAPER)
        self._draw_carriage(painter, geometry)

    def _draw_stops(self, painter: QPainter, geometry: MapGeometry) -> None:
        area = self._area(geometry)
        picture = self._stop_picture()
        if picture is None:
            painter.fillRect(area, self._ink(Mark.STOP_MISSING))
        else:
            painter.drawImage(area, picture)
        grid = self._model.grid
        if grid is None:
            return
        rows, columns = grid.shape
        cell_px = min(area.width() / columns, area.height() / rows)
        painter.setPen(QPen(self._ink(Mark.PAPER), 1))
        if cell_px >= SMALLEST_WITH_LINES_PX:
            for column in range(1, columns):
                x = area.left() + area.width() * column / columns
                painter.drawLine(QPointF(x, area.top()), QPointF(x, area.bottom()))
            for row in range(1, rows):
                y = area.top() + area.height() * row / rows
                painter.drawLine(QPointF(area.left(), y), QPointF(area.right(), y))
        painter.setPen(QPen(self._ink(Mark.BORDER), 1))
        painter.drawRect(area)

    def _stop_picture(self) -> Optional[QImage]:
        """Return one pixel per stop, the highest Y first; made again only after a change."""
        state = (self._model, self._model.revision)
        if self._picture_of != state:
            self._picture_of = state
            self._picture = self._new_picture()
        return self._picture

    def _new_picture(self) -> Optional[QImage]:
        states, grid = self._model.stop_states, self._model.grid
        if states is None or grid is None:
            return None
        upwards = grid.ys_mm[0] <= grid.ys_mm[-1]
        rightwards = grid.xs_mm[0] <= grid.xs_mm[-1]
        shown = states[:: -1 if upwards else 1, :: 1 if rightwards else -1]
        colours = np.array([self._ink(STOP_MARKS[state]).rgb() for state in StopState], np.uint32)
        pixels = np.ascontiguousarray(colours[shown])
        rows, columns = pixels.shape
        image = QImage(pixels.tobytes(), columns, rows, 4 * columns, QImage.Format.Format_RGB32)
        return image.copy()  # its own memory

    def _draw_axes(self, painter: QPainter, geometry: MapGeometry) -> None:
        grid = self._model.grid
        if grid is None:
            return
        area = self._area(geometry)
        metrics = QFontMetrics(painter.font())
        painter.setPen(self._ink(Mark.INK))
        for x_mm in (float(grid.xs_mm.min()), float(grid.xs_mm.max())):
            text = f"{x_mm:g}"
            x_px = geometry.to_screen(x_mm, 0.0)[0] - metrics.horizontalAdvance(text) / 2.0
            painter.drawText(QPointF(x_px, area.bottom() + metrics.ascent() + 2.0), text)
        for y_mm in (float(grid.ys_mm.min()), float(grid.ys_mm.max())):
            text = f"{y_mm:g}"
            y_px = geometry.to_screen(0.0, y_mm)[1] + metrics.ascent() / 2.0
            x_px = area.left() - metrics.horizontalAdvance(text) - 4.0
            painter.drawText(QPointF(x_px, y_px), text)
        middle = QPointF(area.center().x() - 20.0, area.bottom() + metrics.ascent() + 2.0)
        painter.drawText(middle, self.tr("X mm"))
        title = self.tr("Y mm")
        left = area.left() - metrics.horizontalAdvance(title) - 4.0
        painter.drawText(QPointF(left, area.center().y()), title)

    def _draw_rings(self, painter: QPainter, geometry: MapGeometry) -> None:
        """Ring the stops that failed, so that one among thousands is seen."""
        states, grid = self._model.stop_states, self._model.grid
        if states is None or grid is None:
            return
        rows, columns = np.nonzero(states == StopState.FAILED)
        painter.setPen(QPen(self._ink(Mark.STOP_FAILED), 2.5))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for row, column in list(zip(rows, columns))[:MAX_RINGS]:
            centre = geometry.to_screen(grid.xs_mm[column], grid.ys_mm[row])
            painter.drawEllipse(QPointF(*centre), RING_PX, RING_PX)

    def _outline(
        self,
        painter: QPainter,
        geometry: MapGeometry,
        stop: Optional[Stop],
        colour: Mark,
        border: Mark,
    ) -> None:
        grid = self._model.grid
        if stop is None or grid is None:
            return
        rows, columns = grid.shape
        x_px, y_px = geometry.to_screen(grid.xs_mm[stop.column], grid.ys_mm[stop.row])
        area = self._area(geometry)
        width = max(area.width() / columns, SMALLEST_MARK_PX)
        height = max(area.height() / rows, SMALLEST_MARK_PX)
        mark = QRectF(x_px - width / 2.0, y_px - height / 2.0, width, height)
        for pen in (QPen(self._ink(border), 5.0), QPen(self._ink(colour), 3.0)):
            painter.setPen(pen)
            painter.drawRect(mark)

    def _draw_carriage(self, painter: QPainter, geometry: MapGeometry) -> None:
        """Draw a cross where the antennas are; at the edge, hollow, if they are off the area."""
        if self._carriage_mm is None:
            return
        x_mm, y_mm, is_inside = geometry.clamped(*self._carriage_mm)
        x_px, y_px = geometry.to_screen(x_mm, y_mm)
        for pen in (QPen(self._ink(Mark.PAPER), 5.0), QPen(self._ink(Mark.CARRIAGE), 2.0)):
            painter.setPen(pen)
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawEllipse(QPointF(x_px, y_px), 7.0, 7.0)
            if is_inside:
                painter.drawLine(QPointF(x_px - 12.0, y_px), QPointF(x_px + 12.0, y_px))
                painter.drawLine(QPointF(x_px, y_px - 12.0), QPointF(x_px, y_px + 12.0))

    def _ink(self, mark: Mark) -> QColor:
        return QColor(look_of(self).colour(mark))

    @staticmethod
    def _area(geometry: MapGeometry) -> QRectF:
        width = geometry.width_mm * geometry.px_per_mm
        height = geometry.height_mm * geometry.px_per_mm
        return QRectF(geometry.left_px, geometry.bottom_px - height, width, height)

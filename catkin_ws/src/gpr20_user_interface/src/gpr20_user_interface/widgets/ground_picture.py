"""The ground from above, true to scale, and in a section: patterns, candidates and markers."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, QSizeF, Qt, pyqtSignal
from PyQt5.QtGui import QBrush, QColor, QImage, QPainter, QPolygonF

from gpr20_operator.ground.coverage import MapModel
from gpr20_operator.ground.grid import Area, Place, SurveyGrid
from gpr20_operator.ground.sources import Picture
from gpr20_operator.palette import Cell, hiding_cells, pattern, pattern_colours
from gpr20_survey.results.hiding_map import MM_PER_M, HidingMap
from gpr20_user_interface.look.look import Look, Mark, Theme
from gpr20_user_interface.widgets.ink import rimmed, stroke
from gpr20_user_interface.widgets.plot import Plot, extent_of, image_of

SMALLEST_FRAME_PX = 14.0
FAILED_RING_PX = 11.0
# Single stops that are not done must not be overlooked among thousands.
MAX_RINGS = 60
# Around a survey, as a part of its longer side: a ring at its edge is seen as a whole.
RIM = 0.04


def cells_image(cells: np.ndarray, room_px: float, theme: Theme, lined: bool = False) -> QImage:
    """Return a picture of cells (uint8, both axes ascending), about as large as its room."""
    return image_of(pattern(cells, room_px, lined), pattern_colours(theme))


class PatternLayer:
    """A picture of cells on a plot; it is made again only after a change."""

    def __init__(self, lined: bool = False) -> None:
        self._lined = lined
        self._cells: Optional[np.ndarray] = None
        self._area = QRectF()
        self._made: Tuple[object, QImage] = (None, QImage())

    def show_cells(self, cells: Optional[np.ndarray], area: QRectF) -> None:
        """Show cells (uint8, both axes ascending) in an area of the plot; None: none."""
        self._cells, self._area, self._made = cells, area, (None, QImage())

    def paint(self, painter: QPainter, look: Look, plot: Plot) -> None:
        """Paint the cells, if there are any."""
        if self._cells is None:
            return
        room = plot.pixels_of(self._area)
        state = look.theme, max(room.width(), room.height())
        if self._made[0] != state:
            self._made = state, cells_image(self._cells, state[1], look.theme, self._lined)
        painter.drawImage(room, self._made[1])


class GroundPicture(Plot):
    """Draws one image, the coverage below it and marks above it; a touch chooses a place or mark.

    Args:
        interactive: Whether it takes touches.
        beside: The numbers stand beside the picture, else on it.
    """

    # A place that was touched, X and Y in mm: no mark is near.
    place_touched = pyqtSignal(float, float)
    # What the mark that was touched is about.
    mark_touched = pyqtSignal(object)

    def __init__(self, interactive: bool = True, beside: bool = False) -> None:
        super().__init__(to_scale=True, interactive=interactive, beside=beside)
        self._grid: Optional[SurveyGrid] = None
        self._states, self._hatched = PatternLayer(lined=True), PatternLayer()
        self._hiding: Optional[HidingMap] = None
        self._shown: object = None
        self._current: Optional[Place] = None
        self._failed: Tuple[Place, ...] = ()
        self._carriage_mm: Optional[Tuple[float, float]] = None

    def show_picture(self, picture: Optional[Picture]) -> None:
        """Draw an image; without a coverage it is all that is shown."""
        super().show_picture(picture)
        if picture is not None and self._grid is None:
            self.set_extent(extent_of(picture))

    def show_coverage(self, model: MapModel, loading: Optional[np.ndarray] = None) -> None:
        """Draw the states of the stops.

        Args:
            model: The survey.
            loading: Which stops are stored but not here yet (bool, rows x columns); None: none.
        """
        grid, stop = model.grid, model.current
        if grid is not self._grid:
            self._grid = grid
            self.set_extent(None if grid is None else self._extent_for(grid.area))
        self._current = None if grid is None or stop is None else grid.place_of(stop)
        shown = (model, model.revision, None if loading is None else loading.tobytes())
        if shown != self._shown and grid is not None:
            self._failed = model.failed(MAX_RINGS)
            self._states.show_cells(model.cells(loading), _rect(grid.area))
        self._shown = shown
        self.update()

    def set_hiding(self, found: Optional[HidingMap]) -> None:
        """Hatch where a mine could hide, the more densely the shallower; None: nowhere."""
        if found is not self._hiding:
            self._hiding = found
            cells, area = (None, Area(0, 0, 0, 0)) if found is None else hiding_cells(found)
            if found is not None and cells is not None:
                # The image reaches half a stop further: its rim is like the place beside it.
                cells = np.pad(cells, 1, mode="edge")
                area = area.grown(*(MM_PER_M * one for one in found.cell_m))
            self._hatched.show_cells(cells, _rect(area))
            self.update()

    def set_carriage(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas are [mm]; None: not known."""
        if place_mm != self._carriage_mm:
            self._carriage_mm = place_mm
            self.update()

    @property
    def _frame(self) -> QRectF:
        return self.area if self._grid is None else self.pixels_of(_rect(self._grid.area))

    def _extent_for(self, area: Area) -> QRectF:
        rim_mm = 0.0 if self._beside else RIM * max(area.width_mm, area.height_mm)
        return _rect(area.grown(rim_mm, rim_mm))

    def _touch(self, place: QPointF) -> None:
        """Choose marks that lie close together one after the other, and then the place."""
        near = self.marks_near(place)
        chosen = next((number for number, one in enumerate(near) if one.chosen), -1)
        if chosen + 1 < len(near):
            self.mark_touched.emit(near[chosen + 1].about)
        else:
            self.place_touched.emit(*self.to_data(place))

    def _paint_below(self, painter: QPainter, look: Look) -> None:
        if self._grid is None:
            return
        self._states.paint(painter, look, self)
        painter.setPen(QColor(look.colour(Mark.BORDER)))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(self._frame)

    def _paint_above(self, painter: QPainter, look: Look) -> None:
        painter.save()
        painter.setClipRect(self._frame)
        self._hatched.paint(painter, look, self)
        painter.restore()
        painter.setBrush(Qt.BrushStyle.NoBrush)
        radius = look.px(FAILED_RING_PX)
        for pen in rimmed(look, Mark.STOP_FAILED, 3):
            painter.setPen(pen)
            for place in self._failed:
                painter.drawEllipse(self.to_screen(*place), radius, radius)
        self._paint_stop(painter, look)
        # Below the marks: it must not hide a candidate.
        self._paint_carriage(painter, look)

    def _paint_stop(self, painter: QPainter, look: Look) -> None:
        """Paint a frame around the stop that is visited."""
        if self._current is None or self._grid is None:
            return
        share = QRectF(0.0, 0.0, *self._grid.spacing_mm)
        share.moveCenter(QPointF(*self._current))
        frame, least_px = self.pixels_of(share), look.px(SMALLEST_FRAME_PX)
        centre = frame.center()
        frame.setSize(frame.size().expandedTo(QSizeF(least_px, least_px)))
        frame.moveCenter(centre)
        for pen in rimmed(look, Mark.CURRENT, 3):
            painter.setPen(pen)
            painter.drawRect(frame)

    def _paint_carriage(self, painter: QPainter, look: Look) -> None:
        """Paint a cross where the antennas are; at the edge, hollow, if they are off the area."""
        if self._carriage_mm is None or self.extent is None:
            return
        x_mm, y_mm = self._carriage_mm
        x = min(max(x_mm, self.extent.left()), self.extent.right())
        y = min(max(y_mm, self.extent.top()), self.extent.bottom())
        centre, ring, arm = self.to_screen(x, y), look.px(7), look.px(13)
        for pen in rimmed(look, Mark.CARRIAGE, 2):
            painter.setPen(pen)
            painter.drawEllipse(centre, ring, ring)
            if (x, y) == (x_mm, y_mm):
                painter.drawLine(centre - QPointF(arm, 0.0), centre + QPointF(arm, 0.0))
                painter.drawLine(centre - QPointF(0.0, arm), centre + QPointF(0.0, arm))


class SectionPlot(Plot):
    """A B-scan, which fills its room; what is not there is hatched."""

    def __init__(self) -> None:
        super().__init__(downwards=True, scrubs=True)
        self._loading = PatternLayer()

    def show_section(self, picture: Optional[Picture], loading: np.ndarray) -> None:
        """Draw a section, of which some traces (bool) are not here yet; None: nothing."""
        extent = None if picture is None else extent_of(picture)
        self.set_extent(extent)
        cells = None
        if extent is not None and loading.any():
            cells = np.where(loading, Cell.LOADING, Cell.BLANK).astype(np.uint8)
            cells = np.repeat(cells[None], max(1, len(loading) // 2), axis=0)
        self._loading.show_cells(cells, extent or QRectF())
        self.show_picture(picture)

    def _paint_below(self, painter: QPainter, look: Look) -> None:
        if self.extent is not None:
            ink = QColor(look.colour(Mark.NOT_MEASURED))
            painter.fillRect(self.rect(), QBrush(ink, Qt.BrushStyle.Dense6Pattern))
            self._loading.paint(painter, look, self)

    def _paint_above(self, painter: QPainter, look: Look) -> None:
        y, width = self.to_screen(0.0, 0.0).y(), self.width()
        stroke(painter, look, Mark.SURFACE, QPolygonF([QPointF(0, y), QPointF(width, y)]))


def _rect(area: Area) -> QRectF:
    return QRectF(area.left_mm, area.low_mm, area.width_mm, area.height_mm)


class AreaPicture(Plot):
    """An area within the reach of the robot, true to scale."""

    def __init__(self) -> None:
        super().__init__(to_scale=True, interactive=False, beside=True)
        self._area_mm = QRectF()
        self.labels = ("X mm", "Y mm")

    def show_area(self, area_mm: QRectF, reach_mm: QRectF) -> None:
        """Show an area, an empty one if it is not known, and how far the robot reaches [mm]."""
        self._area_mm = area_mm
        self.set_extent(reach_mm)
        self.update()

    def _paint_below(self, painter: QPainter, look: Look) -> None:
        painter.fillRect(self.pixels_of(self._area_mm), QColor(look.colour(Mark.STOP_DONE)))
        painter.setPen(QColor(look.colour(Mark.BORDER)))
        painter.drawRect(self.area)

"""The ground from above, true to scale, with the states of stops, candidates and markers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Optional, Sequence, Tuple

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, QSizeF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QPainter

from gpr20_operator.ground.cells import Cell, hiding_cells
from gpr20_operator.ground.coverage import MapModel, StopState
from gpr20_operator.ground.geometry import Area, share_mm, shown_area, survey_area
from gpr20_operator.ground.grid import Stop, SurveyGrid
from gpr20_operator.ground.records import Colours, Picture, Place
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.widgets.cells import Lattice
from gpr20_user_interface.widgets.ink import rimmed
from gpr20_user_interface.widgets.plot import Plot, extent_of

SMALLEST_FRAME_PX = 14.0
FAILED_RING_PX = 11.0
# Single stops that are not done must not be overlooked among thousands.
MAX_RINGS = 60


@dataclass(frozen=True)
class Frame:
    """A frame around another survey, or around one that is planned."""

    area: Area
    planned: bool = False


class GroundPicture(Plot):
    """Draws one image, the coverage below it and marks above it; a touch chooses a place or mark.

    Args:
        interactive: Whether it takes touches.
    """

    # A place that was touched, X and Y in mm: no mark is near.
    place_touched = pyqtSignal(float, float)
    # What the mark that was touched is about.
    mark_touched = pyqtSignal(object)

    def __init__(self, interactive: bool = True) -> None:
        super().__init__(to_scale=True, interactive=interactive)
        self._grid: Optional[SurveyGrid] = None
        self._cells: Optional[np.ndarray] = None
        self._cells_of: object = None
        self._current: Optional[Place] = None
        self._failed: Tuple[Place, ...] = ()
        self._frames: Tuple[Frame, ...] = ()
        self._carriage_mm: Optional[Tuple[float, float]] = None
        self._loading: Optional[np.ndarray] = None
        self._hiding: Optional[HidingMap] = None
        self._patterns: Dict[str, Tuple[object, QImage]] = {}
        self._lattices: Dict[str, Tuple[object, Lattice]] = {}

    def show_picture(self, picture: Optional[Picture], colours: Colours) -> None:
        """Draw an image; without a coverage it is all that is shown."""
        super().show_picture(picture, colours)
        if picture is not None and self._grid is None:
            self.set_extent(extent_of(picture))

    def show_coverage(
        self, model: MapModel, loading: Optional[np.ndarray] = None, states: bool = True
    ) -> None:
        """Draw the states of the stops.

        Args:
            model: The survey.
            loading: Which stops are stored but not here yet (bool, rows x columns); None: none.
            states: Whether states are shown; else only what is not there.
        """
        grid, stop = model.grid, model.current
        if grid is not self._grid:
            self._grid = grid
            self._fit()
        self._current = None if grid is None or stop is None else grid.place_of(stop)
        self._loading = None
        if grid is not None and loading is not None:
            waiting = np.where(loading, Cell.LOADING, Cell.BLANK)
            self._loading = waiting[grid.ascending].astype(np.uint8)
        shown = (model, model.revision, states)
        if shown != self._cells_of:
            self._cells_of = shown
            self._take_states(model, states)
        self.scene().update()

    def _take_states(self, model: MapModel, states: bool) -> None:
        grid, found = model.grid, model.stop_states
        self._cells, self._failed = None, ()
        self.resetCachedContent()
        if grid is None or found is None:
            return
        cells = found if states else np.where(found == StopState.DONE, Cell.BLANK, found)
        self._cells = cells[grid.ascending].astype(np.uint8)
        if states:
            rings = np.argwhere(found == StopState.FAILED)[:MAX_RINGS].tolist()
            self._failed = tuple(grid.place_of(Stop(*one)) for one in rings)

    def set_frames(self, frames: Sequence[Frame]) -> None:
        """Frame other surveys and those that are planned."""
        if tuple(frames) != self._frames:
            self._frames = tuple(frames)
            self._fit()

    def set_hiding(self, found: Optional[HidingMap]) -> None:
        """Hatch where a mine could hide; None: nowhere."""
        if found is not self._hiding:
            self._hiding = found
            self.scene().update()

    def set_carriage(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas are [mm]; None: not known."""
        if place_mm != self._carriage_mm:
            self._carriage_mm = place_mm
            self.scene().update()

    def _fit(self) -> None:
        """Show the survey, with the others around it."""
        if self._grid is not None:
            around = [one.area for one in self._frames if not one.planned]
            area = shown_area(survey_area(self._grid.xs_mm, self._grid.ys_mm), around)
            self.set_extent(QRectF(area.left_mm, area.low_mm, area.width_mm, area.height_mm))
        elif self.numbers is None:
            self.set_extent(None)

    def _touch(self, place: QPointF) -> None:
        """Choose marks that lie close together one after the other, and then the place."""
        near = self.marks_near(place)
        chosen = next((number for number, one in enumerate(near) if one.chosen), -1)
        if chosen + 1 < len(near):
            self.mark_touched.emit(near[chosen + 1].about)
        else:
            self.place_touched.emit(*self.to_data(place))

    def _paint_below(self, painter: QPainter, look: Look) -> None:
        if self._grid is None or self._cells is None:
            return
        area = survey_area(self._grid.xs_mm, self._grid.ys_mm)
        lattice = self._lattice("states", self._cells.shape, area)
        painter.drawImage(0, 0, lattice.image(self._cells, look, lines=True))
        painter.setPen(QColor(look.colour(Mark.BORDER)))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(self._pixels_of(area))

    def _paint_above(self, painter: QPainter, look: Look) -> None:
        # What is loading, and where a mine could hide, the more densely the shallower.
        if self._loading is not None and self._grid is not None:
            area = survey_area(self._grid.xs_mm, self._grid.ys_mm)
            self._paint_over(painter, look, "loading", self._loading, area)
        if self._hiding is not None:
            self._paint_over(painter, look, "hiding", *hiding_cells(self._hiding))
        for one in self._frames:
            for pen in rimmed(look, Mark.CURRENT if one.planned else Mark.INK, 3):
                if one.planned:
                    pen.setDashPattern([4.0, 3.0])
                painter.setPen(pen)
                painter.drawRect(self._pixels_of(one.area))
        radius = look.px(FAILED_RING_PX)
        for pen in rimmed(look, Mark.STOP_FAILED, 3):
            painter.setPen(pen)
            for place in self._failed:
                painter.drawEllipse(self.to_screen(place.x_mm, place.y_mm), radius, radius)
        self._paint_stop(painter, look)
        # Below the marks: it must not hide a candidate.
        self._paint_carriage(painter, look)

    def _paint_over(
        self, painter: QPainter, look: Look, name: str, cells: np.ndarray, area: Area
    ) -> None:
        """Paint patterns over the image; they are made again only after a change."""
        state = (cells.tobytes(), area, self._map, self.size(), look)
        known = self._patterns.get(name)
        if known is None or known[0] != state:
            known = state, self._lattice(name, cells.shape, area).image(cells, look, lines=False)
            self._patterns[name] = known
        painter.drawImage(0, 0, known[1])

    def _lattice(self, name: str, shape: Tuple[int, ...], area: Area) -> Lattice:
        """Return where cells are; worked out again only after the view has moved."""
        state, known = (self._map, self.size(), shape, area), self._lattices.get(name)
        if known is None or known[0] != state:
            known = state, Lattice(self, (shape[0], shape[1]), area)
            self._lattices[name] = known
        return known[1]

    def _paint_stop(self, painter: QPainter, look: Look) -> None:
        """Paint a frame around the stop that is visited."""
        grid, place = self._grid, self._current
        if place is None or grid is None:
            return
        share = QRectF(0.0, 0.0, share_mm(grid.xs_mm, grid.ys_mm), share_mm(grid.ys_mm, grid.xs_mm))
        share.moveCenter(QPointF(place.x_mm, place.y_mm))
        frame, least_px = self._map.mapRect(share), look.px(SMALLEST_FRAME_PX)
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
                for step in (QPointF(arm, 0.0), QPointF(0.0, arm)):
                    painter.drawLine(centre - step, centre + step)

    def _pixels_of(self, area: Area) -> QRectF:
        return self._map.mapRect(QRectF(area.left_mm, area.low_mm, area.width_mm, area.height_mm))

"""The drawing of the survey area."""

from __future__ import annotations

from typing import Optional, Tuple, Union

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import (
    QBrush,
    QColor,
    QFontMetrics,
    QImage,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
)
from PyQt5.QtWidgets import QSizePolicy

from gpr20_operator.ground.additions import AdditionsPresenter, NoAdditions
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.finer_plan import FinerPlan
from gpr20_operator.ground.geometry import Area, MapGeometry, fit, share_mm
from gpr20_operator.ground.map_model import MapModel
from gpr20_user_interface.look.look import Look, Mark, look_of
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.pages.ground.hidden_areas import hidden_areas
from gpr20_user_interface.pages.ground.map_marks import MarkPainter
from gpr20_user_interface.pages.ground.map_patterns import Ink, StopPattern
from gpr20_user_interface.pages.ground.map_selection import Selection

GAP_PX = 6
# Of the depths that were tried: what is missed above that is hatched densely.
DENSE_SHARE = 0.5
# How far from a ring or a flag a finger may be.
REACH_PX = 24
# Single stops that are not done must not be overlooked among thousands.
MAX_RINGS = 60

INKS = {
    Ink.PAPER: Mark.PAPER,
    Ink.GRID: Mark.GRID,
    Ink.MISSING: Mark.STOP_MISSING,
    Ink.PARTLY: Mark.STOP_PARTLY,
    Ink.DONE: Mark.STOP_DONE,
    Ink.FAILED: Mark.STOP_FAILED,
}


def stops_image(pattern: StopPattern, states: np.ndarray, look: Look) -> QImage:
    """Return a drawing of stops.

    Args:
        pattern: Shape and size of the drawing.
        states: StopState of each stop, the uppermost row first.
        look: The colours.
    """
    colours = np.array([QColor(look.colour(INKS[ink])).rgb() for ink in Ink], np.uint32)
    pixels = colours.take(pattern.inks(states))
    height, width = pixels.shape
    image = QImage(pixels.tobytes(), width, height, 4 * width, QImage.Format.Format_RGB32)
    return image.copy()  # its own memory


class MapCanvas(TranslatedWidget):
    """Draws a MapModel to scale, with what belongs to the survey; a touch chooses a place."""

    # A place that was touched, X and Y, and how far from it a mark may be: all in mm.
    touched = pyqtSignal(float, float, float)

    def __init__(self, model: MapModel, additions: Union[AdditionsPresenter, NoAdditions]) -> None:
        super().__init__()
        self._model = model
        self._additions = additions
        self._carriage_mm: Optional[Tuple[float, float]] = None
        self._selected: Optional[Selection] = None
        self._pattern: Optional[StopPattern] = None
        self._pattern_of: object = None
        self._picture: Optional[QImage] = None
        self._picture_of: object = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    @property
    def geometry_now(self) -> Optional[MapGeometry]:
        """How the area lies on the widget; None while it is not known."""
        grid = self._model.grid
        if grid is None:
            return None
        metrics = QFontMetrics(self.font())
        gap = look_of(self).px(GAP_PX)
        left = metrics.horizontalAdvance("0000") + 2 * gap
        bottom = metrics.height() * (2 if self._shows_candidates else 1) + 2 * gap
        width = max(1, self.width() - left - metrics.horizontalAdvance("00"))
        height = max(1, self.height() - bottom - gap)
        around = [one.area for one in self._additions.related]
        return fit(grid.xs_mm, grid.ys_mm, (left, gap, width, height), around)

    def set_model(self, model: MapModel) -> None:
        """Draw another survey."""
        self._model = model
        self.update()

    def set_carriage(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas are [mm]; None: not known."""
        if place_mm != self._carriage_mm:
            self._carriage_mm = place_mm
            self.update()

    def set_selected(self, selected: Optional[Selection]) -> None:
        """Mark the place that the operator looks at."""
        self._selected = selected
        self.update()

    def retranslate(self) -> None:
        """Draw the texts in the language of the application."""
        self.update()

    def restyle(self) -> None:
        """Draw in the colours of the theme."""
        self.update()

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Choose the place below the finger."""
        geometry = self.geometry_now
        if geometry is None:
            return
        x_mm, y_mm = geometry.to_ground(event.localPos().x(), event.localPos().y())
        self.touched.emit(x_mm, y_mm, look_of(self).px(REACH_PX) / geometry.px_per_mm)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw everything."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._ink(Mark.PAPER))
        geometry = self.geometry_now
        painter.setPen(self._ink(Mark.INK))
        if geometry is None:
            painter.drawText(
                self.rect(),
                int(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap),
                self.tr("No survey yet: the map appears when one starts."),
            )
            return
        self._draw_stops(painter, _pixels_of(geometry, geometry.area))
        self._draw_hiding(painter, geometry)
        shown = _pixels_of(geometry, geometry.shown)
        self._draw_axes(painter, geometry, shown)
        # The frame of a larger survey ends where the axes begin.
        painter.setClipRect(shown)
        self._draw_frames(MarkPainter(painter, geometry, look_of(self)))
        painter.setClipping(False)
        self._draw_marks(MarkPainter(painter, geometry, look_of(self)))

    def _draw_stops(self, painter: QPainter, area: QRectF) -> None:
        size = max(1, round(area.width())), max(1, round(area.height()))
        picture = self._stop_picture(size)
        if picture is not None:
            painter.drawImage(QPointF(round(area.left()), round(area.top())), picture)
        painter.setPen(QPen(self._ink(Mark.BORDER), 1))
        painter.drawRect(round(area.left()), round(area.top()), *size)

    def _draw_hiding(self, painter: QPainter, geometry: MapGeometry) -> None:
        """Hatch where a mine could hide, the more densely the shallower."""
        found = self._additions.hiding
        if found is None:
            return
        painter.setPen(Qt.PenStyle.NoPen)
        for area, share in hidden_areas(found):
            dense = share < DENSE_SHARE
            style = Qt.BrushStyle.Dense5Pattern if dense else Qt.BrushStyle.Dense6Pattern
            painter.setBrush(QBrush(self._ink(Mark.PAPER), style))
            painter.drawRect(_pixels_of(geometry, area))
        painter.setBrush(Qt.BrushStyle.NoBrush)

    def _stop_picture(self, size_px: Tuple[int, int]) -> Optional[QImage]:
        """Return the stops; drawn again only after a change."""
        model, look = self._model, look_of(self)
        states, grid = model.stop_states, model.grid
        if states is None or grid is None:
            return None
        if self._pattern is None or self._pattern_of != (grid.shape, size_px):
            self._pattern_of = (grid.shape, size_px)
            self._pattern = StopPattern(grid.shape, size_px)
            self._picture = None
        if self._picture is None or self._picture_of != (model, model.revision, look):
            self._picture_of = (model, model.revision, look)
            upwards = grid.ys_mm[0] <= grid.ys_mm[-1]
            rightwards = grid.xs_mm[0] <= grid.xs_mm[-1]
            shown = states[:: -1 if upwards else 1, :: 1 if rightwards else -1]
            self._picture = stops_image(self._pattern, shown, look)
        return self._picture

    def _draw_axes(self, painter: QPainter, geometry: MapGeometry, shown: QRectF) -> None:
        grid = self._model.grid
        if grid is None:
            return
        metrics = QFontMetrics(painter.font())
        gap = look_of(self).px(GAP_PX) / 2.0
        below = shown.bottom() + metrics.ascent() + gap
        painter.setPen(self._ink(Mark.INK))
        ends = (float(grid.xs_mm.min()), float(grid.xs_mm.max()))
        for x_mm in ends:
            text = f"{x_mm:.5g}"
            x_px = geometry.to_screen(x_mm, 0.0)[0] - metrics.horizontalAdvance(text) / 2.0
            painter.drawText(QPointF(min(x_px, self.width() - metrics.horizontalAdvance(text)),
                                     below), text)  # fmt: skip
        title = self.tr("X mm")
        middle = (
            geometry.to_screen(float(np.mean(ends)), 0.0)[0]
            - metrics.horizontalAdvance(title) / 2.0
        )
        painter.drawText(QPointF(middle, below), title)
        names = [(float(one), f"{one:.5g}") for one in (grid.ys_mm.min(), grid.ys_mm.max())]
        title = self.tr("Y mm")
        names.append((float(np.mean([y for y, _text in names])), title))
        if len(grid.ys_mm) == 1:
            y_mm, text = names[0]
            names = [(y_mm, f"{title} {text}")]
        for y_mm, text in names:
            y_px = geometry.to_screen(0.0, y_mm)[1] + metrics.ascent() / 2.0
            x_px = shown.left() - metrics.horizontalAdvance(text) - gap
            painter.drawText(QPointF(max(x_px, 0.0), y_px), text)
        if self._shows_candidates:
            rest = QRectF(0.0, below + metrics.descent(), self.width(), metrics.height())
            place = int(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop)
            sentence = self.tr("No echo does not mean no mine.")
            if self._additions.hiding is not None:
                sentence = self.tr("Hatched: a mine could hide here.")
            painter.drawText(rest, place, sentence)

    def _draw_frames(self, marks: MarkPainter) -> None:
        """Frame the surveys that belong to this one, and the one that is planned."""
        for one in self._additions.related:
            marks.area(one.area, Mark.INK, dashed=False)
        grid, plan = self._model.grid, self._additions.plan
        if plan is not None and grid is not None and plan.refines == grid.survey_id:
            marks.area(_area_of(plan), Mark.CURRENT, dashed=True)

    def _draw_marks(self, marks: MarkPainter) -> None:
        grid, states = self._model.grid, self._model.stop_states
        if grid is None:
            return
        spacing_mm = (
            share_mm(grid.xs_mm, grid.ys_mm),
            share_mm(grid.ys_mm, grid.xs_mm),
        )
        if states is not None:
            failed = np.argwhere(states == StopState.FAILED)[:MAX_RINGS]
            for row, column in failed:
                marks.failed((grid.xs_mm[column], grid.ys_mm[row]))
        current = self._model.current
        if current is not None:
            place_mm = grid.xs_mm[current.column], grid.ys_mm[current.row]
            marks.stop(place_mm, spacing_mm, Mark.CURRENT)
        if self._selected is not None and self._selected.mark is None:
            place_mm = self._selected.x_mm, self._selected.y_mm
            marks.stop(place_mm, spacing_mm, Mark.SELECTED)
        self._draw_found(marks)
        if self._carriage_mm is not None:
            marks.carriage(self._carriage_mm)

    def _draw_found(self, marks: MarkPainter) -> None:
        """Draw candidates and markers, those that are selected last."""
        chosen = None if self._selected is None else self._selected.mark
        # The brightest candidates are the first ones, and lie on top.
        for candidate in sorted(
            self._additions.candidates, key=lambda one: (one == chosen, -one.number)
        ):
            place_mm = candidate.x_mm, candidate.y_mm
            marks.candidate(place_mm, candidate.number, candidate.is_doubtful, candidate == chosen)
        for marker in sorted(self._additions.markers, key=lambda one: one == chosen):
            marks.marker((marker.x_mm, marker.y_mm), marker == chosen)

    @property
    def _shows_candidates(self) -> bool:
        return self._additions.image is not None or self._additions.hiding is not None

    def _ink(self, mark: Mark) -> QColor:
        return QColor(look_of(self).colour(mark))


def _pixels_of(geometry: MapGeometry, area: Area) -> QRectF:
    left, top = geometry.to_screen(area.left_mm, area.high_mm)
    right, bottom = geometry.to_screen(area.right_mm, area.low_mm)
    return QRectF(left, top, right - left, bottom - top)


def _area_of(plan: FinerPlan) -> Area:
    return Area(*plan.x_range_mm, *plan.y_range_mm)

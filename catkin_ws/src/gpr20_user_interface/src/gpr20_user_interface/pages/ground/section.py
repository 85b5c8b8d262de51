"""The ground below a line: the section, and the trace at the crosshair beside it."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QBrush, QColor, QPainter, QPen, QPolygonF

from gpr20_operator.ground.cells import TILE_PX, Cell
from gpr20_operator.ground.records import Axis, Colours, Curve, Picture
from gpr20_user_interface.look.look import Look, Mark, look_of
from gpr20_user_interface.look.translation import shown_number
from gpr20_user_interface.widgets.cells import pattern_image
from gpr20_user_interface.widgets.ink import LINE_PX, Ticks, stroke
from gpr20_user_interface.widgets.plot import Plot, extent_of

GRIP_PX = 9
# Room of a level below the trace.
LEVEL_PX = 36
# A finger nearer to the apex of the hyperbola than this moves it, another one bends the flank.
GRIP_RADIUS_PX = 45
# A trace has a little room beside its strongest echo.
LARGEST_SHADE = 1.02


class SectionPlot(Plot):
    """A B-scan; what is not there is hatched.

    Attributes:
        axis: What the second axis is.
        grip: Where the hyperbola can be gripped; None: none is fitted.
        grips_apex: Whether the finger that touches it now drags the apex; else the flank.
    """

    def __init__(self) -> None:
        super().__init__(downwards=True, scrubs=True)
        self.axis = Axis.DEPTH_MM
        self._curve: Optional[Tuple[np.ndarray, np.ndarray]] = None
        self.grip: Optional[Tuple[float, float]] = None
        self.grips_apex = False
        self._loading = np.zeros(0, bool)

    def show_section(
        self, picture: Optional[Picture], colours: Colours, loading: np.ndarray
    ) -> None:
        """Draw a section, of which some traces (bool) are not here yet; None: nothing."""
        self._loading = loading
        self.resetCachedContent()
        self.axis = self.axis if picture is None else picture.axis
        self.set_extent(None if picture is None else extent_of(picture))
        self.show_picture(picture, colours)

    def set_hyperbola(self, curve: Optional[Tuple[np.ndarray, np.ndarray]]) -> None:
        """Draw a curve, by its places on both axes, with a grip at its apex; None: without."""
        self._curve, self.grip = curve, None
        if curve is not None:
            apex = int(curve[1].argmin())
            self.grip = float(curve[0][apex]), float(curve[1][apex])
        self.scene().update()

    def _begin_drag(self, place: QPointF) -> None:
        self.grips_apex = False
        if self.grip is not None:
            away = place - self.to_screen(*self.grip)
            self.grips_apex = away.manhattanLength() <= look_of(self).px(GRIP_RADIUS_PX)

    def _paint_below(self, painter: QPainter, look: Look) -> None:
        if self.extent is None:
            return
        ink = QColor(look.colour(Mark.NOT_MEASURED))
        painter.fillRect(self.viewport().rect(), QBrush(ink, Qt.BrushStyle.Dense6Pattern))
        dashes = QBrush(pattern_image(Cell.LOADING, TILE_PX, look, framed=False))
        wide = self.extent.width() / max(1, len(self._loading))
        for number in np.flatnonzero(self._loading).tolist():
            left = self.to_screen(self.extent.left() + number * wide, 0.0).x()
            right = self.to_screen(self.extent.left() + (number + 1) * wide, 0.0).x()
            column = QRectF(left, 0.0, right - left, self.viewport().height())
            for brush in (QColor(look.colour(Mark.PAPER)), dashes):
                painter.fillRect(column, brush)

    def _paint_above(self, painter: QPainter, look: Look) -> None:
        if self.axis is Axis.DEPTH_MM:
            y, width = self.to_screen(0.0, 0.0).y(), self.viewport().width()
            stroke(painter, look, Mark.SURFACE, QPolygonF([QPointF(0, y), QPointF(width, y)]))
        if self._curve is not None:
            stroke(painter, look, Mark.CANDIDATE, self.polygon(*self._curve))
        if self.grip is not None:
            painter.setPen(QPen(QColor(look.colour(Mark.PAPER)), look.px(LINE_PX)))
            painter.setBrush(QColor(look.colour(Mark.CANDIDATE)))
            size = look.px(GRIP_PX)
            painter.drawEllipse(self.to_screen(*self.grip), size, size)


class TracePlot(Plot):
    """An A-scan from the top downwards, beside a section whose depths it has."""

    def __init__(self, section: SectionPlot) -> None:
        super().__init__(downwards=True, scrubs=True)
        self._section = section
        self.show_curve(None)
        section.moved.connect(self._follow)

    def show_curve(self, curve: Optional[Curve]) -> None:
        """Draw a trace; None: nothing."""
        self._curve: Optional[Curve] = None
        # Shades and places that are drawn.
        self.points = np.zeros(0), np.zeros(0)
        if curve is not None:
            known = np.isfinite(curve.shades)
            self._curve = curve if known.any() else None
            self.points = curve.shades[known], curve.places[known]
        self._follow()

    def _follow(self) -> None:
        """Show the same depths as the section."""
        section, curve = self._section, self._curve
        if section.extent is None or curve is None:
            self.set_extent(None)
            return
        height = section.viewport().height()
        top, bottom = (section.to_data(QPointF(0.0, y))[1] for y in (0.0, height))
        lowest = -1.0 if curve.signed else 0.0
        self.set_extent(QRectF(lowest, top, LARGEST_SHADE - lowest, bottom - top))
        self.scene().update()

    def _ticks_state(self) -> object:
        return None if self._curve is None else self._curve.scale

    def _ticks(self, look: Look) -> Tuple[Ticks, Ticks]:
        # The depths are those of the section.
        if self._curve is None:
            return (), ()
        scale, levels = self._curve.scale, self._curve.scale.ticks_db()
        every = max(1, -(-len(levels) // max(1, self.width() // look.px(LEVEL_PX))))
        places = [(scale.shade_of(float(one)), shown_number(one)) for one in levels[::-every]]
        return [(self.to_screen(shade, 0.0).x(), text) for shade, text in places], ()

    def _paint_above(self, painter: QPainter, look: Look) -> None:
        painter.setPen(QPen(QColor(look.colour(Mark.CURVE)), look.px(LINE_PX)))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawPolyline(self.polygon(*self.points))

"""The pictures of the GROUND page: how they share the room, and what their colours mean."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

from PyQt5.QtCore import QPointF, QRect, QRectF
from PyQt5.QtGui import QColor, QImage, QPainter, QPaintEvent, QPen, QResizeEvent
from PyQt5.QtWidgets import QSizePolicy, QWidget

from gpr20_operator.ground.geometry import divided
from gpr20_operator.ground.level_scale import LevelScale
from gpr20_operator.ground.records import Colours
from gpr20_operator.ground.shade_colours import LAST_SHADE, colour_table
from gpr20_user_interface.look.look import Mark, look_of
from gpr20_user_interface.look.translation import shown_number
from gpr20_user_interface.pages.ground.section import SectionPlot, TracePlot
from gpr20_user_interface.widgets.ground_picture import GroundPicture
from gpr20_user_interface.widgets.plot import UNIT, Plot

GAP_PX = 2
# The trace takes this part of a section's room, within limits.
TRACE_PART, LEAST_TRACE_PX, MOST_TRACE_PX = 0.22, 66, 150
# A room that is at least so large has a section along X and one along Y.
LARGE_PX = (1000, 500)


class ColourBar(QWidget):
    """Shows what the shades mean, the strongest at the top; with a sign, zero is in the middle."""

    def __init__(self) -> None:
        super().__init__()
        self._shown: Tuple[Optional[LevelScale], Colours] = (None, Colours.ENVELOPE)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)

    def show_scale(self, scale: Optional[LevelScale], colours: Colours) -> None:
        """Show a scale; None: nothing."""
        if (scale, colours) != self._shown:
            self._shown = scale, colours
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        scale, colours = self._shown
        if scale is None:
            return
        painter, look = QPainter(self), look_of(self)
        metrics = painter.fontMetrics()
        line_px = metrics.height()
        painter.setPen(QColor(look.colour(Mark.INK)))
        painter.drawText(0, metrics.ascent(), "dB")
        bar = QRectF(0, line_px, self.width() * 0.36, self.height() - 1.5 * line_px)
        table = colour_table(colours)[LAST_SHADE::-1]
        image = QImage(table.tobytes(), 1, len(table), 4, QImage.Format.Format_RGBA8888)
        painter.drawImage(bar, image)
        painter.setPen(QPen(QColor(look.colour(Mark.BORDER)), 1))
        painter.drawRect(bar)
        painter.setPen(QColor(look.colour(Mark.INK)))
        last_px = -1.0
        for level_db in scale.ticks_db()[::-1]:
            shade = scale.shade_of(float(level_db))
            part = (shade + 1.0) / 2.0 if colours.signed else shade
            y = bar.bottom() - part * bar.height() + metrics.ascent() / 2.0 - 1
            # Numbers that would touch their neighbours are left out.
            if last_px < 0 or y - last_px >= line_px:
                painter.drawText(QPointF(bar.right() + 4, y), shown_number(level_db))
                last_px = y


class Pictures(QWidget):
    """Shares its room among the pictures so that the survey leaves as little as possible unused.

    Attributes:
        above: The survey from above.
        sections: The section along the chosen axis, and, in a large room, along the other one.
        trace: The trace at the crosshair.
        plots: All of these.
        enlarged: The picture that has the whole room; None: none has.
    """

    def __init__(self) -> None:
        super().__init__()
        self.above = GroundPicture()
        self.sections = (SectionPlot(), SectionPlot())
        self.trace = TracePlot(self.sections[0])
        self.enlarged: Optional[Plot] = None
        self.plots: Tuple[Plot, ...] = (self.above, *self.sections, self.trace)
        for one in self.plots:
            one.setParent(self)
        self.setMinimumSize(1, 1)

    def enlarge(self, plot: Optional[Plot]) -> None:
        """Give one picture the whole room; None: share it."""
        if self.enlarged is not None:
            self.enlarged.show_all()
        self.enlarged = plot
        self.arrange()
        if plot is not None:
            plot.fill()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: there is more or less room."""
        super().resizeEvent(event)
        self.arrange()

    def arrange(self) -> None:
        """Place the pictures."""
        places = self._places()
        for one in self.plots:
            one.setVisible(one in places)
            if one in places:
                one.setGeometry(places[one])

    def _places(self) -> Dict[Plot, QRect]:
        room, gap = self.rect(), look_of(self).px(GAP_PX)
        if self.enlarged is not None:
            return {self.enlarged: room}
        extent = self.above.extent or UNIT
        beside, px = divided(extent.width(), extent.height(), room.width(), room.height())
        above, rest = _cut(room, beside, px, gap)
        parts = [rest]
        if room.width() >= LARGE_PX[0] and room.height() >= LARGE_PX[1]:
            length = rest.width() if not beside else rest.height()
            parts = [*_cut(rest, not beside, (length - gap) // 2, gap)]
        look, wide = look_of(self), round(TRACE_PART * parts[0].width())
        wide = min(max(wide, look.px(LEAST_TRACE_PX)), look.px(MOST_TRACE_PX))
        section, trace = _cut(parts[0], True, max(1, parts[0].width() - wide - gap), gap)
        sections = dict(zip(self.sections, (section, *parts[1:])))
        return {self.above: above, self.trace: trace, **sections}


def _cut(room: QRect, beside: bool, first_px: int, gap: int) -> Tuple[QRect, QRect]:
    """Return both parts of a room, beside or below each other; the first one has a given size."""
    first, rest = QRect(room), QRect(room)
    if beside:
        first.setWidth(first_px)
        rest.setLeft(first.right() + 1 + gap)
    else:
        first.setHeight(first_px)
        rest.setTop(first.bottom() + 1 + gap)
    return first, rest

"""The depth of the slice: a slider with ticks that a gloved finger can hit anywhere."""

from __future__ import annotations

from typing import Optional

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPen
from PyQt5.QtWidgets import QSlider

from gpr20_operator.ground.level_scale import LevelScale
from gpr20_operator.ground.pictures import DEPTH_STEP_M
from gpr20_operator.ground.records import Colours
from gpr20_user_interface.look.look import Mark, TextColours, look_of
from gpr20_user_interface.look.shade_colours import LAST_SHADE, shade_colours
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.pages.ground.plots import round_ticks

WIDTH_PX = 230
BAR_PX = 18
UNIT = "dB"


class ColourBar(TranslatedWidget):
    """Shows a LevelScale; with a sign, the wave's zero is in its middle."""

    def __init__(self) -> None:
        super().__init__()
        self._scale: Optional[LevelScale] = None
        self._colours = Colours.ENVELOPE
        self._has_caption = True
        self._of_clutter = False
        self.restyle()

    def show_scale(
        self, scale: Optional[LevelScale], colours: Colours, of_clutter: bool = False
    ) -> None:
        """Show a scale; None: nothing.

        Args:
            scale: The scale.
            colours: The colours of its shades.
            of_clutter: Its levels are above the clutter, as those of a focused image.
        """
        shown = (scale, colours, of_clutter)
        if shown != (self._scale, self._colours, self._of_clutter):
            self._scale, self._colours, self._of_clutter = shown
            self.update()

    def show_caption(self, shown: bool) -> None:
        """Write below the numbers what they are; else their unit is beside them."""
        if shown != self._has_caption:
            self._has_caption = shown
            self.restyle()
            self.update()

    def retranslate(self) -> None:
        """Draw the texts in the language of the application."""
        self.update()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        self.setFixedWidth(look.px(WIDTH_PX))
        lines = 2 if self._has_caption else 1
        self.setMinimumHeight(look.px(BAR_PX) + lines * self.fontMetrics().height() + 2)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        if self._scale is None:
            return
        painter, look = QPainter(self), look_of(self)
        metrics = painter.fontMetrics()
        edge = metrics.horizontalAdvance("0")
        bar = QRectF(edge, 0, self.width() - 2 * edge, look.px(BAR_PX))
        numbers = np.arange(LAST_SHADE + 1, dtype=np.uint8)
        image = QImage(numbers.tobytes(), len(numbers), 1, len(numbers), QImage.Format_Indexed8)
        image.setColorTable(shade_colours(self._colours))
        painter.drawImage(bar, image)
        painter.setPen(QPen(QColor(look.colour(Mark.BORDER)), 1))
        painter.drawRect(bar)
        painter.setPen(QColor(look.colour(Mark.INK)))
        base = bar.bottom() + metrics.ascent() + 1
        last = self.width()
        if self._has_caption:
            of_noise, of_clutter = self.tr("dB above noise"), self.tr("dB above clutter")
            caption = of_clutter if self._of_clutter else of_noise
            middle = (self.width() - metrics.horizontalAdvance(caption)) / 2.0
            painter.drawText(QPointF(middle, base + metrics.lineSpacing() - 2), caption)
        else:
            last -= metrics.horizontalAdvance(UNIT)
            painter.drawText(QPointF(last, base), UNIT)
        for level_db in self._scale.ticks_db()[::-1]:
            part = self._scale.shade_of(float(level_db))
            if self._colours.signed:
                part = (part + 1.0) / 2.0
            text = f"{level_db:g}"
            x = bar.left() + part * bar.width() - metrics.horizontalAdvance(text) / 2.0
            # Numbers that would touch their neighbours are left out.
            if x >= 0 and x + metrics.horizontalAdvance(text) + edge / 2 <= last:
                painter.drawText(QPointF(x, base), text)
                last = int(x) - 2


STEP_MM = DEPTH_STEP_M * 1000.0
TICK_PX = 8
HANDLE_PX = 16
FIRST_STEPS = 60


class DepthSlider(QSlider):
    """Steps of depth from the surface downwards; the handle jumps to the finger."""

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Vertical)
        self.setInvertedAppearance(True)
        self.setRange(0, FIRST_STEPS)
        self.setPageStep(1)

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: a finger touches the slider."""
        self.setValue(self._steps(event.localPos().y()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: the finger moves."""
        self.setValue(self._steps(event.localPos().y()))

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        painter, look = QPainter(self), look_of(self)
        metrics = painter.fontMetrics()
        x = metrics.horizontalAdvance("0000")
        groove = QRectF(x, self._y(0), look.px(TICK_PX), self._y(self.maximum()) - self._y(0))
        painter.fillRect(groove, QColor(look.colour(Mark.BORDER)))
        painter.setPen(QColor(look.colour(Mark.INK)))
        most = int(groove.height() / (1.5 * metrics.height()))
        for depth_mm in round_ticks(0.0, max(1, self.maximum()) * STEP_MM, max(2, most)):
            y, text = self._y(depth_mm / STEP_MM), f"{depth_mm:g}"
            painter.drawLine(QPointF(x - 3, y), QPointF(groove.right() + look.px(TICK_PX), y))
            left = x - 5 - metrics.horizontalAdvance(text)
            painter.drawText(QPointF(left, y + metrics.ascent() / 2.0 - 1), text)
        if not self.isEnabled():
            return
        height = look.px(HANDLE_PX)
        y = self._y(self.value())
        handle = QRectF(x - 2, y - height / 2.0, self.width() - x, height)
        painter.setPen(QPen(QColor(look.colour(Mark.BORDER)), look.px(2)))
        painter.setBrush(QColor(look.text(TextColours.BUTTON).ground))
        painter.drawRoundedRect(handle, 4, 4)

    def _margin(self) -> float:
        return max(self.fontMetrics().height(), look_of(self).px(HANDLE_PX)) / 2.0 + 1

    def _y(self, steps: float) -> float:
        length = self.height() - 2 * self._margin()
        return self._margin() + length * steps / max(1, self.maximum())

    def _steps(self, y: float) -> int:
        length = max(1.0, self.height() - 2 * self._margin())
        part = min(max((y - self._margin()) / length, 0.0), 1.0)
        return round(part * self.maximum())

"""A large button that shows values, or what is wrong with them; and one with an area on it."""

from __future__ import annotations

from typing import List

from PyQt5.QtCore import QEvent, QPointF, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QFont, QPainter, QPaintEvent, QTransform
from PyQt5.QtWidgets import QPushButton, QSizePolicy, QVBoxLayout

from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, Mark, look_of
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.widgets import set_look

# Above and below: so much is left for four lines of a sentence.
EDGE_PX = 2
# The numbers of an area.
LIMITS_PX = 14


class TileButton(QPushButton):
    """A title, and below it lines or one sentence; a touch opens their sheet."""

    def __init__(self, name: str = "tile", lines: int = 2) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._level = ""
        self.title = ElidedLabel()
        self.title.setObjectName("tile_title")
        self.lines: List[ElidedLabel] = [ElidedLabel() for _ in range(lines)]
        self.sentence = LinesLabel()
        self._layout = QVBoxLayout(self)
        self._layout.setSpacing(0)
        for label in (self.title, *self.lines):
            self._layout.addWidget(label)
        self._layout.addWidget(self.sentence, 1)
        self._labels = (self.title, *self.lines, self.sentence)
        for label in self._labels:
            # The touch is for the button.
            label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.pressed.connect(self._show_level)
        self.released.connect(self._show_level)

    def sizeHint(self) -> QSize:  # noqa: N802
        """Qt: it fills the place that it gets."""
        size_px = look_of(self).px(TOUCH_PX)
        return QSize(size_px, size_px)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it fills the place that it gets."""
        return self.sizeHint()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange:
            look = look_of(self)
            gap_px, edge_px = look.px(GAP_PX), look.px(EDGE_PX)
            self._layout.setContentsMargins(gap_px, edge_px, gap_px, edge_px)
        elif event.type() == QEvent.Type.EnabledChange:
            self._show_level()

    def show_texts(self, title: str, *lines: str, sentence: str = "", level: str = "") -> None:
        """Show a title and what is below it.

        Args:
            title: The title.
            lines: Lines below it.
            sentence: What is shown instead of the lines; empty: the lines. One that says what is
                wrong takes the place of the title too.
            level: How good the values are: "wrong", "doubtful", or empty.
        """
        self.title.show_text(title)
        self.title.setVisible(not (sentence and level == "wrong"))
        for label, text in zip(self.lines, (*lines, *("",) * len(self.lines))):
            label.show_text(text)
            label.setVisible(not sentence)
        self.sentence.show_text(sentence)
        self.sentence.setVisible(bool(sentence))
        self.setToolTip(sentence)
        self._level = level
        self._show_level()

    def _show_level(self) -> None:
        level = self._level
        if not self.isEnabled():
            level = "locked"
        elif self.isDown():
            level = "pressed"
        if self.property("level") != level:
            set_look(self, "level", level)
            # Their colours depend on the property of the tile.
            for label in self._labels:
                self.style().unpolish(label)
                self.style().polish(label)


class AreaTile(TileButton):
    """A tile with a picture of an area within the reach of the robot, true to scale."""

    def __init__(self) -> None:
        super().__init__()
        self._area_mm, self._reach_mm = QRectF(), QRectF()
        self._layout.addStretch(2)

    def show_area(self, area_mm: QRectF, reach_mm: QRectF) -> None:
        """Show an area, an empty one if it is not known, and how far the robot reaches [mm]."""
        self._area_mm, self._reach_mm = area_mm, reach_mm
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        """Qt: paint the reach of the robot with its limits, and the area in it; Y upwards."""
        super().paintEvent(event)
        look, reach = look_of(self), self._reach_mm
        lowest = max(one.geometry().bottom() for one in self._labels if not one.isHidden())
        gap, limits = look.px(GAP_PX), look.px(LIMITS_PX)
        room = QRectF(self.rect()).adjusted(4 * gap, lowest + gap, -4 * gap, -gap - limits)
        if reach.isEmpty() or min(room.width(), room.height()) < limits:
            return
        scale = min(room.width() / reach.width(), room.height() / reach.height())
        to_px = QTransform()
        to_px.translate(room.center().x(), room.center().y())
        to_px.scale(scale, -scale)
        to_px.translate(-reach.center().x(), -reach.center().y())
        frame, area = to_px.mapRect(reach), to_px.mapRect(self._area_mm)
        painter, font = QPainter(self), QFont(self.font())
        font.setPixelSize(limits)
        painter.setFont(font)
        painter.fillRect(frame, QColor(look.colour(Mark.PAPER)))
        painter.fillRect(area, QColor(look.colour(Mark.STOP_DONE)))
        painter.setPen(QColor(look.colour(Mark.BORDER)))
        painter.drawRect(frame)
        painter.setPen(self.title.palette().color(self.title.foregroundRole()))
        right = int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        number = QRectF(0.0, 0.0, 4 * gap - EDGE_PX, limits)
        for y_mm, y in ((reach.top(), frame.bottom()), (reach.bottom(), frame.top() + limits)):
            number.moveBottomRight(QPointF(frame.left() - EDGE_PX, y))
            painter.drawText(number, right, f"{y_mm:g}")
        number.setWidth(8 * gap)
        ends = (reach.left(), frame.left(), ""), (reach.right(), frame.right(), " mm")
        for x_mm, x, unit in ends:
            number.moveTopLeft(QPointF(x - 4 * gap, frame.bottom()))
            painter.drawText(number, int(Qt.AlignmentFlag.AlignCenter), f"{x_mm:g}{unit}")

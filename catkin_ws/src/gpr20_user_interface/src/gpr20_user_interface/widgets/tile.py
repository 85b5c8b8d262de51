"""Labels that end with dots where there is no room; and tiles, which show values by them."""

from __future__ import annotations

from typing import List, Optional

from PyQt5.QtCore import QEvent, QSize, Qt
from PyQt5.QtGui import QPainter, QPaintEvent, QTextLayout, QTextOption
from PyQt5.QtWidgets import QLabel, QPushButton, QSizePolicy, QWidget

from gpr20_common.message import Message
from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.widgets import column, set_look, spaced

# Above and below: so much is left for four lines of a sentence.
EDGE_PX = 2


class LinesLabel(QLabel):
    """As many lines as there is room for; the last one ends with … where text is left out."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it may be as narrow as it must."""
        return QSize(0, self.fontMetrics().height())

    def sizeHint(self) -> QSize:  # noqa: N802
        """Qt: it takes what it gets."""
        return self.minimumSizeHint()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw the lines."""
        painter = QPainter(self)
        # The background of the style sheet.
        self.drawFrame(painter)
        painter.setPen(self.palette().color(self.foregroundRole()))
        lines, room = self.shown_lines(), self.contentsRect()
        step_px = self.fontMetrics().lineSpacing()
        top_px = room.top() + max(0, (room.height() - step_px * len(lines)) // 2)
        for number, line in enumerate(lines):
            baseline_px = top_px + number * step_px + self.fontMetrics().ascent()
            painter.drawText(room.left(), baseline_px, line)

    def shown_lines(self) -> List[str]:
        """Return the lines as they are drawn."""
        metrics, room = self.fontMetrics(), self.contentsRect()
        width_px, most = max(1, room.width()), max(1, room.height() // metrics.lineSpacing())
        text = " ".join(self.text().split())
        layout = QTextLayout(text, self.font())
        option = QTextOption()
        option.setWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
        layout.setTextOption(option)
        layout.beginLayout()
        lines: List[str] = []
        while len(lines) < most:
            line = layout.createLine()
            if not line.isValid():
                break
            line.setLineWidth(width_px)
            start = line.textStart()
            lines.append(text[start : start + line.textLength()])
            if len(lines) == most and start + line.textLength() < len(text):
                rest = text[start:]
                lines[-1] = metrics.elidedText(rest, Qt.TextElideMode.ElideRight, width_px)
        layout.endLayout()
        return lines


class ElidedLabel(LinesLabel):
    """One line that ends with … where there is no room."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)


class SurveyBand(ElidedLabel):
    """Says which survey is shown, if it is not the one of the robot."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("shown_band")
        self.hide()

    def show_band(self, band: Optional[Message]) -> None:
        """Show it; None: nothing."""
        self.setVisible(band is not None)
        if band is not None:
            self.setText(shown_text(band))


class TileButton(QPushButton):
    """A title, and below it lines or one sentence, and a picture; a touch opens their sheet."""

    def __init__(
        self, name: str = "tile", lines: int = 2, picture: Optional[QWidget] = None
    ) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._level = ""
        self.title = ElidedLabel()
        self.title.setObjectName("tile_title")
        self.lines: List[ElidedLabel] = [ElidedLabel() for _ in range(lines)]
        self.sentence = LinesLabel()
        self._labels = (self.title, *self.lines, self.sentence)
        shown = () if picture is None else ((picture, 4),)
        parts = (self.title, *self.lines, (self.sentence, 1), *shown)
        self.setLayout(spaced(column(*parts), GAP_PX, gap=0, edge=EDGE_PX))
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
        if event.type() == QEvent.Type.EnabledChange:
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
        self.title.setText(title)
        self.title.setVisible(bool(title) and not (sentence and level == "wrong"))
        for label, text in zip(self.lines, (*lines, *("",) * len(self.lines))):
            label.setText(text)
            label.setVisible(not sentence)
        self.sentence.setText(sentence)
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

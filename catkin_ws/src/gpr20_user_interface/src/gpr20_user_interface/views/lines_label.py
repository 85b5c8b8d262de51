"""Text in a few lines that may be too long for its place."""

from __future__ import annotations

from typing import List

from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QPainter, QPaintEvent, QTextLayout, QTextOption
from PyQt5.QtWidgets import QLabel, QSizePolicy


class LinesLabel(QLabel):
    """As many lines as there is room for; the last one ends with … where text is left out."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)

    @property
    def whole(self) -> str:
        """The text without anything left out."""
        return self.text()

    def show_text(self, text: str) -> None:
        """Show as much of a text as fits."""
        if text != self.text():
            self.setText(text)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it may be as small as it must."""
        return QSize(0, self.fontMetrics().height())

    def sizeHint(self) -> QSize:  # noqa: N802
        """Qt: it takes what it gets."""
        return self.minimumSizeHint()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw the lines."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        lines = self._lines()
        step_px = self.fontMetrics().lineSpacing()
        top_px = max(0, (self.height() - step_px * len(lines)) // 2)
        for number, line in enumerate(lines):
            baseline_px = top_px + number * step_px + self.fontMetrics().ascent()
            painter.drawText(0, baseline_px, line)

    def _lines(self) -> List[str]:
        metrics, width_px = self.fontMetrics(), max(1, self.width())
        most = max(1, self.height() // metrics.lineSpacing())
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

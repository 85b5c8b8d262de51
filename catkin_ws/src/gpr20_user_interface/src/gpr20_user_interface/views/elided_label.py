"""A line of text that may be too long for its place."""

from __future__ import annotations

from PyQt5.QtCore import QEvent, QSize, Qt
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QLabel, QSizePolicy


class ElidedLabel(QLabel):
    """One line that ends with … where there is no room; the tool tip shows the whole text."""

    def __init__(self) -> None:
        super().__init__()
        self._whole = ""
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)

    @property
    def whole(self) -> str:
        """The text without anything left out."""
        return self._whole

    @property
    def is_cut(self) -> bool:
        """Whether some of the text has no room."""
        return self.text() != _one_line(self._whole)

    def show_text(self, text: str) -> None:
        """Show as much of a text as fits."""
        if text == self._whole:
            return
        self._whole = text
        self.setToolTip(text)
        self._elide()

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it may be as narrow as it must."""
        return QSize(0, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Qt: there is more or less room."""
        super().resizeEvent(event)
        self._elide()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._elide()

    def _elide(self) -> None:
        metrics = self.fontMetrics()
        room_px = self.width() - 2
        text = metrics.elidedText(_one_line(self._whole), Qt.TextElideMode.ElideRight, room_px)
        self.setText(text)


def _one_line(text: str) -> str:
    return " ".join(text.split())

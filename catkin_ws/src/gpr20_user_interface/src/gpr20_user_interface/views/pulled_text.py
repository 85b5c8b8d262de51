"""A text of several lines that a finger pulls up where there is no room for all of it."""

from __future__ import annotations

from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QFrame, QLabel, QScrollArea


class PulledText(QScrollArea):
    """Shows a text without a scroll bar, which would be as wide as a finger."""

    def __init__(self) -> None:
        super().__init__()
        self._label = QLabel()
        self._label.setWordWrap(True)
        self._label.setTextFormat(Qt.TextFormat.PlainText)
        self._label.setAlignment(Qt.AlignmentFlag.AlignTop)
        # A touch of the text is one of this widget.
        self._label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._finger_px = 0.0
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setWidget(self._label)

    def text(self) -> str:
        """Return the text."""
        return str(self._label.text())

    def setText(self, text: str) -> None:  # noqa: N802 (as QLabel names it)
        """Show a text from its beginning; the same one stays where it was pulled."""
        if text != self._label.text():
            self._label.setText(text)
            self.verticalScrollBar().setValue(0)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it may be as small as it must, since it can be pulled."""
        return QSize(0, self.fontMetrics().lineSpacing())

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger touches the text."""
        self._finger_px = event.localPos().y()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: the finger pulls it."""
        bar = self.verticalScrollBar()
        bar.setValue(bar.value() + round(self._finger_px - event.localPos().y()))
        self._finger_px = event.localPos().y()

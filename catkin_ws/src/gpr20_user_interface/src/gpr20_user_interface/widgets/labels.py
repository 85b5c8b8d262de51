"""Labels whose text may be longer than their place: it ends with dots, or it is pulled."""

from __future__ import annotations

from typing import Callable, List, Optional

from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QPainter, QPaintEvent, QTextLayout, QTextOption
from PyQt5.QtWidgets import QLabel, QSizePolicy, QTextEdit, QWidget

from gpr20_common.message import Message
from gpr20_user_interface.look.look import GAP_PX, TextColours, look_of, sign
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.widgets import column, new_button, new_label, row


class LinesLabel(QLabel):
    """As many lines as there is room for; the last one ends with … where text is left out."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)

    @property
    def is_cut(self) -> bool:
        """Whether some of the text has no room."""
        return "".join("".join(self.shown_lines()).split()) != "".join(self.text().split())

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


class PulledText(QTextEdit):
    """A text of several lines that a finger pulls up where there is no room for all of it."""

    def __init__(self, name: str = "") -> None:
        super().__init__()
        self.setObjectName(name)
        self.setReadOnly(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def text(self) -> str:
        """Return the text."""
        return str(self.toPlainText())

    def setText(self, text: str) -> None:  # noqa: N802 (as QLabel names it)
        """Show a text from its beginning; the same one stays where it was pulled."""
        if text != self.text():
            self.setPlainText(text)


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


SIGN_PX = 64


class EmptyState(QWidget):
    """A sign, one sentence and at most one button; its page writes the texts.

    Attributes:
        sentence: What is missing.
        button: What to do.
    """

    def __init__(self) -> None:
        super().__init__()
        self._sign, self.sentence = QLabel(), new_label(wraps=True)
        self._act: Callable[[], None] = lambda: None
        self.button = new_button(lambda: self._act())
        for label in (self._sign, self.sentence):
            label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        button = row(self.button)
        button.setAlignment(self.button, Qt.AlignmentFlag.AlignHCenter)
        layout = column(self._sign, self.sentence, button, gap=2 * GAP_PX)
        layout.insertStretch(0)
        layout.addStretch()
        self.setLayout(layout)

    def show_state(
        self, name: str, sentence: str, button: str = "", act: Optional[Callable[[], None]] = None
    ) -> None:
        """Show what is missing.

        Args:
            name: Of the sign, as `icon` knows it.
            sentence: What is missing.
            button: What to do; empty: there is no button.
            act: Does it.
        """
        look = look_of(self)
        self._sign.setPixmap(sign(name, look.text(TextColours.QUIET).ink, look.px(SIGN_PX)))
        self.sentence.setText(sentence)
        self.button.setText(button)
        self.button.setVisible(act is not None)
        self._act = act or self._act

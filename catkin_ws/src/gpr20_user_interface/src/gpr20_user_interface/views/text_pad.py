"""A keyboard on the screen with the letters of English and Spanish."""

from __future__ import annotations

from typing import Callable, List

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QPlainTextEdit, QPushButton, QWidget

from gpr20_user_interface.views.pad import Judge, Pad

# The same keys without and with shift.
PLAIN = ("1234567890", "qwertyuiop", "asdfghjklñ", "zxcvbnm,.-", "áéíóúü¿?¡!")
SHIFTED = ('"#$%&/()=+', "QWERTYUIOP", "ASDFGHJKLÑ", "ZXCVBNM;:_", "ÁÉÍÓÚÜ'*@°")
LINES_SHOWN = 2


class PadEdit(QPlainTextEdit):
    """A text in which RETURN ends the entry, unless it may have several lines."""

    returned = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("entry")
        self.several_lines = False
        self.setTabChangesFocus(True)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        """Qt: a key of a real keyboard."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and not self.several_lines:
            self.returned.emit()
        else:
            super().keyPressEvent(event)


class TextPad(Pad):
    """A text, keys that write it, and what is allowed, while it is written."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.edit = PadEdit()
        self.edit.textChanged.connect(self._on_text)
        self.edit.returned.connect(self._accept)
        self.keys: List[QPushButton] = [
            self._key(row, column) for row in range(len(PLAIN)) for column in range(len(PLAIN[row]))
        ]
        self.shift = self._button("⇧", self._show_keys)
        self.shift.setCheckable(True)
        self.space = self._button("␣", lambda: self._insert(" "))
        self.line = self._button("↵", lambda: self._insert("\n"))
        self.erase = self._button("⌫", lambda: self.edit.textCursor().deletePreviousChar())
        self.erase.setAutoRepeat(True)
        self._lay_out()

    def ask(
        self,
        deliver: Callable[[str], None],
        title: str,
        hint: str,
        text: str,
        judge: Judge,
        several_lines: bool,
    ) -> None:
        """Open with a text, the cursor at its end.

        Args:
            deliver: Called with the text when it is accepted.
            title: What is asked for.
            hint: What is allowed.
            text: The text at first.
            judge: Returns what is allowed instead of a wrong text, while it is written.
            several_lines: Whether the text may have several lines.
        """
        self._begin(deliver, title, hint, judge)
        self.edit.several_lines = several_lines
        self.line.setEnabled(several_lines)
        self.shift.setChecked(not text)
        self._show_keys()
        self.edit.setPlainText(text)
        cursor = self.edit.textCursor()
        cursor.movePosition(cursor.MoveOperation.End)
        self.edit.setTextCursor(cursor)
        self._on_text()
        self.retranslate()
        self.open()
        self.edit.setFocus()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.cancel.setText(self.tr("Cancel"))
        self.accept_button.setText(self.tr("OK"))

    def press(self, text: str) -> None:
        """Press the keys of a text, with shift where it is needed."""
        for character in text:
            if character in (" ", "\n"):
                (self.space if character == " " else self.line).click()
                continue
            self.shift.setChecked(any(character in row for row in SHIFTED))
            self._show_keys()
            next(key for key in self.keys if key.property("character") == character).click()

    def _written(self) -> str:
        return str(self.edit.toPlainText())

    def _on_text(self) -> None:
        self._check(strict=True)

    def _insert(self, character: str) -> None:
        self.edit.insertPlainText(character)
        self.edit.ensureCursorVisible()

    def _type(self, key: QPushButton) -> None:
        self._insert(key.property("character"))
        # Shift is for one letter.
        self.shift.setChecked(False)
        self._show_keys()

    def _show_keys(self) -> None:
        rows = SHIFTED if self.shift.isChecked() else PLAIN
        for key, character in zip(self.keys, "".join(rows)):
            key.setProperty("character", character)
            # One ampersand alone would underline the next letter.
            key.setText("&&" if character == "&" else character)

    def _key(self, row: int, column: int) -> QPushButton:
        key = self._button(PLAIN[row][column], lambda: self._type(key))
        key.setObjectName("key")
        return key

    def _lay_out(self) -> None:
        top = QHBoxLayout()
        top.addWidget(self.title)
        top.addWidget(self.hint, 1)
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 4, 8, 4)
        grid.setSpacing(4)
        width = len(PLAIN[0])
        grid.addLayout(top, 0, 0, 1, width)
        grid.addWidget(self.edit, 1, 0, 1, width)
        keys = iter(self.keys)
        for row, characters in enumerate(PLAIN, 2):
            for column in range(len(characters)):
                grid.addWidget(next(keys), row, column)
            grid.setRowStretch(row, 1)
        last = QHBoxLayout()
        last.setSpacing(4)
        for button, share in (
            (self.shift, 1),
            (self.space, 3),
            (self.line, 1),
            (self.erase, 1),
            (self.cancel, 2),
            (self.accept_button, 2),
        ):
            last.addWidget(button, share)
        grid.addLayout(last, len(PLAIN) + 2, 0, 1, width)

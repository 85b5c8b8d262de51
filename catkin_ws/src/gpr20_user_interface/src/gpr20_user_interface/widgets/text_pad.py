"""A keyboard on the screen with the letters of English and Spanish."""

from __future__ import annotations

from typing import Callable, List

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QPlainTextEdit,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.widgets.keys import Judge, Pad

# The same keys: small letters, capital letters, and what is needed less often.
PLAIN = ("1234567890", "qwertyuiop", "asdfghjklñ", "zxcvbnm,.-")
SHIFTED = ("1234567890", "QWERTYUIOP", "ASDFGHJKLÑ", "ZXCVBNM;:_")
OTHERS = ("áéíóúü¿?¡!", "ÁÉÍÓÚÜ'*@°", '"#$%&/()=+', "[]{}<>|~^€")
PAGES = (PLAIN, SHIFTED, OTHERS)
MARGIN_PX = 4
# What five rows of keys leave.
TEXT_ROW_PX = 54
TITLE_WIDTH_PX = 290


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

    problem_replaces_title = True

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.edit = PadEdit()
        self.edit.textChanged.connect(self._on_text)
        self.edit.returned.connect(self._accept)
        self.keys: List[QPushButton] = [
            self._key(row, column) for row in range(len(PLAIN)) for column in range(len(PLAIN[row]))
        ]
        self.shift = self._button("⇧", self._on_shift)
        self.shift.setCheckable(True)
        self.others = self._button("á#", self._on_others)
        self.others.setCheckable(True)
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
        self._begin(deliver, title, hint, text, judge)
        self.edit.several_lines = several_lines
        self.line.setEnabled(several_lines)
        self.shift.setChecked(not text)
        self.others.setChecked(False)
        self._show_keys()
        self.edit.setPlainText(text)
        cursor = self.edit.textCursor()
        cursor.movePosition(cursor.MoveOperation.End)
        self.edit.setTextCursor(cursor)
        self._on_text()
        self.open()
        self.edit.setFocus()

    def press(self, text: str) -> None:
        """Press the keys of a text, on the page where they are."""
        for character in text:
            if character in (" ", "\n"):
                (self.space if character == " " else self.line).click()
                continue
            page = next(page for page in PAGES if any(character in row for row in page))
            self.shift.setChecked(page is SHIFTED)
            self.others.setChecked(page is OTHERS)
            self._show_keys()
            next(key for key in self.keys if key.property("character") == character).click()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        gap_px, margin_px = look.px(GAP_PX), look.px(MARGIN_PX)
        for layout in (self._rows, self._top, self._grid, self._last):
            layout.setSpacing(gap_px)
        self._rows.setContentsMargins(margin_px, margin_px // 2, margin_px, margin_px // 2)
        self._words.setFixedSize(look.px(TITLE_WIDTH_PX), look.px(TEXT_ROW_PX))
        self.edit.setFixedHeight(look.px(TEXT_ROW_PX))

    def _written(self) -> str:
        return str(self.edit.toPlainText())

    def _on_text(self) -> None:
        self._check(strict=True)

    def _insert(self, character: str) -> None:
        self.edit.insertPlainText(character)
        self.edit.ensureCursorVisible()

    def _type(self, key: QPushButton) -> None:
        self._insert(key.property("character"))
        # Shift is for one letter, and so are the accents.
        self.shift.setChecked(False)
        self.others.setChecked(False)
        self._show_keys()

    def _on_shift(self) -> None:
        self.others.setChecked(False)
        self._show_keys()

    def _on_others(self) -> None:
        self.shift.setChecked(False)
        self._show_keys()

    def _show_keys(self) -> None:
        rows = SHIFTED if self.shift.isChecked() else PLAIN
        rows = OTHERS if self.others.isChecked() else rows
        for key, character in zip(self.keys, "".join(rows)):
            key.setProperty("character", character)
            # One ampersand alone would underline the next letter.
            key.setText("&&" if character == "&" else character)

    def _key(self, row: int, column: int) -> QPushButton:
        key = self._button(PLAIN[row][column], lambda: self._type(key))
        key.setObjectName("key")
        key.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        return key

    def _lay_out(self) -> None:
        self._words = QWidget()
        words = QVBoxLayout(self._words)
        words.setContentsMargins(0, 0, 0, 0)
        words.setSpacing(0)
        self.title.setWordWrap(True)
        words.addWidget(self.title)
        words.addWidget(self.hint, 1)
        self._top = QHBoxLayout()
        self._top.addWidget(self._words)
        self._top.addWidget(self.edit, 1)
        self._grid = QGridLayout()
        keys = iter(self.keys)
        for row, characters in enumerate(PLAIN):
            for column in range(len(characters)):
                self._grid.addWidget(next(keys), row, column)
                self._grid.setColumnStretch(column, 1)
            self._grid.setRowStretch(row, 1)
        self._last = QHBoxLayout()
        for button, share in (
            (self.shift, 1),
            (self.others, 1),
            (self.space, 2),
            (self.line, 1),
            (self.erase, 1),
            (self.cancel, 2),
            (self.accept_button, 2),
        ):
            self._last.addWidget(button, share)
        self._rows = QVBoxLayout(self)
        self._rows.addLayout(self._top)
        self._rows.addLayout(self._grid, 1)
        self._rows.addLayout(self._last)

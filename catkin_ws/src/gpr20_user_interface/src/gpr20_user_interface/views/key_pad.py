"""Keys on the screen: digits for a parameter, letters for a name."""

from __future__ import annotations

from typing import Callable, Sequence

from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLineEdit, QPushButton, QWidget

from gpr20_user_interface.views.pad import Judge, Pad
from gpr20_user_interface.views.widgets import set_look

DIGITS = ("789", "456", "123", "-0.", ", ")
LETTERS = ("1234567890", "qwertyuiop", "asdfghjkl-", "zxcvbnm_ ")
MAX_LENGTH = 40


class KeyPad(Pad):
    """A text, keys that write it, and what is allowed, while it is written."""

    def __init__(self, window: QWidget, rows: Sequence[str]) -> None:
        super().__init__(window)
        self._strict = True
        self.edit = QLineEdit()
        self.edit.setMaxLength(MAX_LENGTH)
        self.edit.textChanged.connect(self._on_text)
        self.edit.returnPressed.connect(self._accept)
        self.erase = self._button("⌫", self.edit.backspace)
        self.erase.setAutoRepeat(True)
        self.clear = self._button("", self.edit.clear)
        self.keys = [self._key(character) for row in rows for character in row]
        self._lay_out(rows)

    def ask(
        self,
        deliver: Callable[[str], None],
        title: str,
        hint: str,
        text: str,
        judge: Judge,
        strict: bool,
    ) -> None:
        """Open with a text, all of it selected: the first key replaces it.

        Args:
            deliver: Called with the text when it is accepted.
            title: What is asked for.
            hint: What is allowed.
            text: The text at first.
            judge: Returns what is allowed instead of a wrong text, while it is written.
            strict: Whether a wrong text cannot be accepted.
        """
        self._begin(deliver, title, hint, judge)
        self._strict = strict
        self.clear.setText(self.tr("Clear"))
        self.cancel.setText(self.tr("Cancel"))
        self.accept_button.setText(self.tr("OK"))
        self.edit.setText(text)
        self.edit.selectAll()
        self._on_text()
        self.open()
        self.edit.setFocus()

    def press(self, character: str) -> None:
        """Press one of the keys."""
        next(key for key in self.keys if key.property("character") == character).click()

    def _written(self) -> str:
        return str(self.edit.text())

    def _on_text(self) -> None:
        set_look(self.edit, "wrong", bool(self._check(self._strict)))

    def _key(self, character: str) -> QPushButton:
        key = self._button(
            "␣" if character == " " else character, lambda: self.edit.insert(character)
        )
        key.setObjectName("key")
        key.setProperty("character", character)
        return key

    def _lay_out(self, rows: Sequence[str]) -> None:
        top = QHBoxLayout()
        top.addWidget(self.title)
        top.addWidget(self.hint, 1)
        line = QHBoxLayout()
        line.addWidget(self.edit, 1)
        line.addWidget(self.erase)
        line.addWidget(self.clear)
        grid = QGridLayout(self)
        grid.setContentsMargins(12, 8, 12, 8)
        grid.setSpacing(6)
        width = max(len(row) for row in rows)
        grid.addLayout(top, 0, 0, 1, width)
        grid.addLayout(line, 1, 0, 1, width)
        keys = iter(self.keys)
        for row, characters in enumerate(rows, 2):
            for column in range(len(characters)):
                grid.addWidget(next(keys), row, column)
            grid.setRowStretch(row, 1)
        last = QHBoxLayout()
        last.addWidget(self.cancel)
        last.addWidget(self.accept_button)
        grid.addLayout(last, len(rows) + 2, 0, 1, width)

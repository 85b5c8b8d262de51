"""Keys on the screen for a number, over everything below the top bar."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from gpr20_user_interface.views.key_block import CLEAR, SIGNED, KeyBlock
from gpr20_user_interface.views.look import GAP_PX, look_of
from gpr20_user_interface.views.pad import Judge, Pad
from gpr20_user_interface.views.touch_edit import TouchEdit
from gpr20_user_interface.views.widgets import set_look

KEYS_PX = 300


class KeyPad(Pad):
    """A number, keys that write it, and what is allowed, while it is written."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._strict = True
        self.edit = TouchEdit("entry")
        self.edit.textChanged.connect(lambda _text: self._on_text())
        self.edit.returnPressed.connect(self._accept)
        self.keys = KeyBlock()
        self.keys.use(SIGNED)
        self.keys.written.connect(self.edit.insert)
        self.keys.commanded.connect(self._on_command)
        self._lay_out()

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
        self._begin(deliver, title, hint, text, judge)
        self._strict = strict
        self.edit.setText(text)
        self._on_text()
        self.open()
        self.edit.setFocus()
        self.edit.select_all()

    def press(self, character: str) -> None:
        """Press one of the keys."""
        self.keys.press(character)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        gap_px = look.px(GAP_PX)
        for layout in (self._both, self._left, self._last):
            layout.setSpacing(gap_px)
        self._both.setContentsMargins(2 * gap_px, gap_px, 2 * gap_px, gap_px)
        self.keys.setFixedWidth(look.px(KEYS_PX))

    def _written(self) -> str:
        return str(self.edit.text())

    def _on_text(self) -> None:
        set_look(self.edit, "wrong", bool(self._check(self._strict)))

    def _on_command(self, command: str) -> None:
        if command == CLEAR:
            self.edit.clear()
        else:
            self.edit.backspace()

    def _lay_out(self) -> None:
        self._last = QHBoxLayout()
        self._last.addWidget(self.cancel, 1)
        self._last.addWidget(self.accept_button, 1)
        self._left = QVBoxLayout()
        self._left.addLayout(self._last)
        for widget in (self.title, self.edit, self.hint):
            self._left.addWidget(widget)
        self._left.addStretch(1)
        self._both = QHBoxLayout(self)
        self._both.addLayout(self._left, 1)
        self._both.addWidget(self.keys)

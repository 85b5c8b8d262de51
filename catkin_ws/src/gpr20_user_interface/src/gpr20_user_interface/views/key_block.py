"""Sixteen keys for numbers, addresses and lists."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QPushButton

from gpr20_user_interface.views.look import GAP_PX, look_of
from gpr20_user_interface.views.translation import TranslatedWidget
from gpr20_user_interface.views.widgets import new_button, set_look

# What these keys do is not the text on them.
UP, DOWN, STEP, CLEAR, ERASE = "▲", "▼", "±", "C", "⌫"
COMMANDS = (UP, DOWN, STEP, CLEAR, ERASE)
NONE = ""
ROWS = ("789", "456", "123")
REPEAT_DELAY_MS = 400
REPEAT_MS = 120


@dataclass(frozen=True)
class KeySet:
    """The keys beside and below the digits 1 to 9; empty: there is no key.

    Attributes:
        side: At the right of the digits, from the top.
        left: At the left of 0.
        right: At the right of 0.
    """

    side: Tuple[str, str, str]
    left: str
    right: str


NUMBER = KeySet((UP, DOWN, STEP), ".", CLEAR)
WHOLE = KeySet((UP, DOWN, STEP), NONE, CLEAR)
CHOICE = KeySet((UP, DOWN, "-"), ".", CLEAR)
ADDRESS = KeySet(("192.168.", "10.", "172."), ".", CLEAR)
LIST = KeySet((",", "-", CLEAR), ".", ";")
SIGNED = KeySet((",", "-", CLEAR), ".", NONE)


class KeyBlock(TranslatedWidget):
    """Reports which key was touched."""

    # Carries the text that a key writes.
    written = pyqtSignal(str)
    # Carries one of COMMANDS.
    commanded = pyqtSignal(str)

    def __init__(self) -> None:
        super().__init__()
        self._step = 1
        self._keys: List[QPushButton] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        for row in range(4):
            self._grid.setRowStretch(row, 1)
            for column in range(4):
                self._grid.setColumnStretch(column, 1)
                key = self._key()
                self._keys.append(key)
                self._grid.addWidget(key, row, column)
        self.use(NUMBER)

    @property
    def keys(self) -> List[QPushButton]:
        """All keys."""
        return self._keys

    def use(self, keys: KeySet, step: int = 1) -> None:
        """Show other keys.

        Args:
            keys: Those beside and below the digits.
            step: By how much an arrow changes a number.
        """
        self._step = step
        texts = [character for row, side in zip(ROWS, keys.side) for character in (*row, side)]
        texts += [keys.left, "0", keys.right, ERASE]
        for key, text in zip(self._keys, texts):
            key.setProperty("character", text)
            key.setText(self._shown(text))
            set_look(key, "long", len(text) > 1 or (text == STEP and step > 9))
            key.setEnabled(text != NONE)
            key.setAutoRepeat(text in (UP, DOWN, ERASE))

    def press(self, text: str) -> None:
        """Touch the key of a text."""
        self._by_text()[text].click()

    def retranslate(self) -> None:
        """Nothing to do: the keys are the same in every language."""

    def restyle(self) -> None:
        """Take the sizes of the look."""
        self._grid.setSpacing(look_of(self).px(GAP_PX))

    def _shown(self, text: str) -> str:
        if text == STEP:
            return f"±{self._step}"
        # The beginning of an address is long.
        return text.replace(".", ".\n", 1) if text.count(".") > 1 else text

    def _by_text(self) -> Dict[str, QPushButton]:
        return {key.property("character"): key for key in self._keys}

    def _key(self) -> QPushButton:
        key = new_button(lambda: self._on_key(key.property("character")))
        key.setObjectName("key")
        # The focus, and with it cursor and selection, stays in the text.
        key.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        key.setAutoRepeatDelay(REPEAT_DELAY_MS)
        key.setAutoRepeatInterval(REPEAT_MS)
        policy = key.sizePolicy()
        policy.setVerticalPolicy(policy.Policy.Expanding)
        policy.setHorizontalPolicy(policy.Policy.Ignored)
        key.setSizePolicy(policy)
        return key

    def _on_key(self, text: str) -> None:
        if text in COMMANDS:
            self.commanded.emit(text)
        else:
            self.written.emit(text)

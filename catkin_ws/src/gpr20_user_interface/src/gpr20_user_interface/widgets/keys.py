"""Keys on the screen for a number, over everything below the top bar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict, List, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget
from gpr20_user_interface.widgets.edits import TouchEdit
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button, set_look

# Returns what is allowed instead of a wrong text; empty if the text is right.
Judge = Callable[[str], str]


class Pad(Overlay):
    """A title, what is allowed, and buttons that deliver a text or drop it.

    Attributes:
        problem_replaces_title: Whether there is room for only one of them.
    """

    problem_replaces_title = False

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._judge: Judge = lambda _text: ""
        self._hint = ""
        self._first = ""
        self._deliver: Callable[[str], None] = lambda _text: None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.hint = QLabel()
        self.hint.setWordWrap(True)
        self.cancel = self._button("", self.hide)
        self.accept_button = self._button("", self._accept)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.cancel.setText(self.tr("Cancel"))
        self.accept_button.setText(self.tr("OK"))

    def _begin(
        self, deliver: Callable[[str], None], title: str, hint: str, text: str, judge: Judge
    ) -> None:
        """Note what is asked for; the arguments are those of `ask`."""
        self._deliver = deliver
        self._judge = judge
        self._hint = hint
        self._first = text
        self.title.setText(title)
        self.retranslate()

    def _written(self) -> str:
        """Return the text as it is now."""
        raise NotImplementedError

    def _accept(self) -> None:
        if self.accept_button.isEnabled():
            self.hide()
            self._deliver(self._written())

    def _check(self, strict: bool) -> str:
        """Show what is wrong with the text, and return it; a strict pad does not deliver it.

        A text that was not changed yet is not shown as wrong.
        """
        problem = self._judge(self._written())
        self.accept_button.setEnabled(not (problem and strict))
        shown = "" if self._written() == self._first else problem
        self.hint.setText(shown or self._hint)
        self.title.setVisible(not (shown and self.problem_replaces_title))
        set_look(self.hint, "level", "wrong" if shown else "")
        return shown

    def _button(self, text: str, act: Callable[[], None]) -> QPushButton:
        button = new_button(act, text)
        # The focus, and with it cursor and selection, stays in the text.
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        return button


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

"""Keys on the screen: for numbers beside a field, and a pad with a text over everything."""

from __future__ import annotations

from typing import Callable, List, Mapping, NamedTuple, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtWidgets import QPlainTextEdit, QPushButton, QSizePolicy, QWidget

from gpr20_common.message import Message
from gpr20_operator.plan.fields import Keys
from gpr20_user_interface.widgets.widgets import (
    Overlay,
    column,
    grid,
    holding,
    new_button,
    new_label,
    row,
    say,
    set_look,
)

# What these keys do is not the text on them.
CLEAR, ERASE = "C", "⌫"
COMMANDS = (CLEAR, ERASE)
NONE = ""
DIGITS = ("789", "456", "123")
REPEAT_DELAY_MS = 400
REPEAT_MS = 120


class Side(NamedTuple):
    """The keys beside and below the digits 1 to 9; empty: there is no key."""

    right: Tuple[str, str, str]
    before_0: str
    after_0: str


SIDES: Mapping[Keys, Side] = {
    Keys.NUMBER: Side((CLEAR, "-", NONE), ".", NONE),
    Keys.WHOLE: Side((CLEAR, NONE, NONE), NONE, NONE),
    Keys.ADDRESS: Side(("192.168.", "10.", "172."), ".", CLEAR),
    Keys.LIST: Side((",", "-", CLEAR), ".", ";"),
}


class _Block(QWidget):
    """Rows of keys, which report what was touched.

    Attributes:
        keys: The keys, row by row; their property "character" is what they write.
    """

    # Carries the text that a key writes.
    written = pyqtSignal(str)

    def __init__(self, rows: int, columns: int) -> None:
        super().__init__()
        layout = grid()
        self.setLayout(layout)
        self.keys: List[QPushButton] = []
        for place in range(rows * columns):
            row_number, column_number = divmod(place, columns)
            layout.setRowStretch(row_number, 1)
            layout.setColumnStretch(column_number, 1)
            layout.addWidget(self._key(), row_number, column_number)

    def _on_key(self, text: str) -> None:
        self.written.emit(text)

    def _key(self) -> QPushButton:
        key = _key(lambda: self._on_key(key.property("character")))
        key.setObjectName("key")
        key.setAutoRepeatDelay(REPEAT_DELAY_MS)
        key.setAutoRepeatInterval(REPEAT_MS)
        key.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        self.keys.append(key)
        return key


def _key(act: Callable[[], None], text: str = "") -> QPushButton:
    """Return a key; the focus, and with it cursor and selection, stays in the text."""
    key = new_button(act, text)
    key.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    return key


class KeyBlock(_Block):
    """Digits, and what belongs to them."""

    # Carries one of COMMANDS.
    commanded = pyqtSignal(str)

    def __init__(self) -> None:
        super().__init__(4, 4)
        self.use(Keys.NUMBER)

    def use(self, keys: Keys) -> None:
        """Show the keys of what is written."""
        side = SIDES[keys]
        texts = [one for row, beside in zip(DIGITS, side.right) for one in (*row, beside)]
        for key, text in zip(self.keys, [*texts, side.before_0, "0", side.after_0, ERASE]):
            key.setProperty("character", text)
            # The beginning of an address is long.
            shown = text.replace(".", ".\n", 1) if text.count(".") > 1 else text
            key.setText(shown)
            set_look(key, "long", len(text) > 1)
            key.setEnabled(text != NONE)
            key.setAutoRepeat(text == ERASE)

    def _on_key(self, text: str) -> None:
        (self.commanded if text in COMMANDS else self.written).emit(text)


# The same keys: small letters, capital letters, and what is needed less often.
PLAIN = ("1234567890", "qwertyuiop", "asdfghjklñ", "zxcvbnm,.-")
SHIFTED = ("1234567890", "QWERTYUIOP", "ASDFGHJKLÑ", "ZXCVBNM;:_")
OTHERS = ("áéíóúü¿?¡!", "ÁÉÍÓÚÜ'*@°", '"#$%&/()=+', "[]{}<>|~^€")


class LetterBlock(_Block):
    """The letters of English and Spanish."""

    def __init__(self) -> None:
        super().__init__(len(PLAIN), len(PLAIN[0]))
        self.shift, self.others = (self._page_key(text) for text in ("⇧", "á#"))
        self.show_page(PLAIN)

    def show_page(self, page: Tuple[str, ...]) -> None:
        """Show PLAIN, SHIFTED or OTHERS."""
        self.shift.setChecked(page is SHIFTED)
        self.others.setChecked(page is OTHERS)
        for key, character in zip(self.keys, "".join(page)):
            key.setProperty("character", character)
            # One ampersand alone would underline the next letter.
            key.setText("&&" if character == "&" else character)

    def _page_key(self, text: str) -> QPushButton:
        key = _key(lambda: self._change(key), text)
        key.setCheckable(True)
        return key

    def _change(self, key: QPushButton) -> None:
        page = SHIFTED if key is self.shift else OTHERS
        self.show_page(page if key.isChecked() else PLAIN)

    def _on_key(self, text: str) -> None:
        super()._on_key(text)
        # Shift is for one letter, and so are the accents.
        self.show_page(PLAIN)


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


# Returns what is allowed instead of a wrong text; empty if the text is right.
Judge = Callable[[str], str]
MARGIN_PX = 4


class Pad(Overlay):
    """A text, what is allowed while it is written, and keys: digits or letters."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._judge: Judge = lambda _text: ""
        self._hint, self._first = "", ""
        self._deliver: Callable[[str], None] = lambda _text: None
        self.title, self.hint = new_label("title", wraps=True), new_label(wraps=True)
        self.edit = PadEdit()
        self.edit.textChanged.connect(self._check)
        self.edit.returned.connect(self._accept)
        self.digits, self.letters = KeyBlock(), LetterBlock()
        for block in (self.digits, self.letters):
            block.written.connect(self._insert)
        self.digits.commanded.connect(self._on_command)
        self.space = _key(lambda: self._insert(" "), "␣")
        self.line = _key(lambda: self._insert("\n"), "↵")
        self.erase = _key(lambda: self._on_command(ERASE), ERASE)
        self.erase.setAutoRepeat(True)
        self.cancel, self.accept_button = _key(self.hide), _key(self._accept)
        say(self.cancel, Message("Cancel"))
        say(self.accept_button, Message("OK"))
        self.accept_button.setObjectName("primary")
        self._lay_out()

    def ask(
        self,
        deliver: Callable[[str], None],
        title: str,
        hint: str,
        text: str,
        judge: Judge,
        keys: Keys,
    ) -> None:
        """Open with a text. The first digit replaces it; letters are written at its end.

        Args:
            deliver: Called with the text when it is accepted.
            title: What is asked for.
            hint: What is allowed.
            text: The text at first.
            judge: Returns what is allowed instead of a wrong text, while it is written.
            keys: Which keys write it.
        """
        self._deliver, self._judge = deliver, judge
        self._hint, self._first = hint, text
        self.title.setText(title)
        with_letters = keys in (Keys.LETTERS, Keys.LINES)
        self.edit.several_lines = keys is Keys.LINES
        self.line.setEnabled(keys is Keys.LINES)
        for widget in (self.letters, self.letters.shift, self.letters.others):
            widget.setVisible(with_letters)
        for widget in (self.space, self.line, self.erase):
            widget.setVisible(with_letters)
        self.digits.setVisible(not with_letters)
        if with_letters:
            self.letters.show_page(PLAIN if text else SHIFTED)
        else:
            self.digits.use(Keys.LIST)
        self.edit.setPlainText(text)
        cursor = self.edit.textCursor()
        cursor.movePosition(cursor.MoveOperation.End)
        if not with_letters:
            cursor.select(cursor.SelectionType.Document)
        self.edit.setTextCursor(cursor)
        self._check()
        self.open()
        self.edit.setFocus()

    def _accept(self) -> None:
        if self.accept_button.isEnabled():
            self.hide()
            self._deliver(self.edit.toPlainText())

    def _check(self) -> None:
        """Show what is wrong; a text that was not changed yet is not shown as wrong."""
        text = self.edit.toPlainText()
        problem = self._judge(text)
        self.accept_button.setEnabled(not problem)
        shown = "" if text == self._first else problem
        self.hint.setText(shown or self._hint)
        # There is room for only one of them.
        self.title.setVisible(not shown)
        set_look(self.hint, "level", "wrong" if shown else "")

    def _insert(self, text: str) -> None:
        self.edit.insertPlainText(text)
        self.edit.ensureCursorVisible()

    def _on_command(self, command: str) -> None:
        if command == CLEAR:
            self.edit.clear()
        elif command == ERASE:
            self.edit.textCursor().deletePreviousChar()

    def _lay_out(self) -> None:
        words = holding(column(self.title, (self.hint, 1), gap=0), "pad_words")
        commands = (self.letters.shift, self.letters.others, self.space, self.line, self.erase)
        last = row()
        for button in (*commands, self.cancel, self.accept_button):
            wide = button in (self.space, self.cancel, self.accept_button)
            last.addWidget(button, 2 if wide else 1)
        top = row(words, (self.edit, 1))
        blocks = ((self.digits, 1), (self.letters, 1))
        self.setLayout(column(top, *blocks, last, margin=MARGIN_PX))

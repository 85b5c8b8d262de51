"""What the keyboards on the screen have in common."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel, QPushButton, QWidget

from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.widgets import new_button, set_look

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

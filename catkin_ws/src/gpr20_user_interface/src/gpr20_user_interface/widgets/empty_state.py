"""What a page shows that has nothing to show yet: what is missing, and what to do."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel, QWidget

from gpr20_user_interface.look.icons import sign
from gpr20_user_interface.look.look import GAP_PX, TextColours, look_of
from gpr20_user_interface.widgets.widgets import column, new_button, new_label, row

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

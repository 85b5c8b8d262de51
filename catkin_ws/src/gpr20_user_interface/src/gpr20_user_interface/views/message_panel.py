"""What main_control does, in its own words."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel, QPlainTextEdit, QVBoxLayout, QWidget

from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.views.robot_text import robot_text
from gpr20_user_interface.views.state_text import state_title
from gpr20_user_interface.views.translation import TranslatedWidget

UNKNOWN = "—"


class MessagePanel(TranslatedWidget):
    """A title for the state and the message below it, however long."""

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self._shown: Optional[ControlState] = None
        self._title = QLabel(UNKNOWN)
        self._title.setObjectName("title")
        self._message = QPlainTextEdit()
        self._message.setObjectName("status_message")
        self._message.setReadOnly(True)
        self._message.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        layout.addWidget(self._title)
        layout.addWidget(self._message)

    @property
    def title(self) -> str:
        """The title that is shown."""
        return self._title.text()

    @property
    def message(self) -> str:
        """The message that is shown."""
        return self._message.toPlainText()

    def show_state(self, state: Optional[ControlState]) -> None:
        """Show what main_control said last; nothing if it never spoke."""
        # Written only when it changes, so that whoever reads keeps the place.
        if state != self._shown:
            self._shown = state
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        message = "" if self._shown is None else robot_text(self._shown.message)
        if message != self._message.toPlainText():
            self._message.setPlainText(message)
        self._title.setText(UNKNOWN if self._shown is None else state_title(self._shown.code))

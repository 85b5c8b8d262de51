"""What main_control does, in its own words."""

from __future__ import annotations

from typing import Dict, Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel, QPlainTextEdit, QVBoxLayout, QWidget

from gpr20_main_control.mid.survey_state import SurveyState
from gpr20_user_interface.mid.survey_state import ControlState


class StatusPanel(QWidget):
    """A title for the code and the message below it, however long."""

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self._shown: Optional[ControlState] = None
        self._title = QLabel("—")
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
        if state == self._shown:
            return
        self._shown = state
        self._title.setText("—" if state is None else self._titles()[state.code])
        self._message.setPlainText("" if state is None else state.message)

    def _titles(self) -> Dict[SurveyState, str]:
        return {
            SurveyState.IDLE: self.tr("IDLE"),
            SurveyState.CONFIGURED: self.tr("CONFIGURED"),
            SurveyState.CHECKING: self.tr("CHECKING"),
            SurveyState.HOMING: self.tr("HOMING"),
            SurveyState.SURVEYING: self.tr("SURVEYING"),
            SurveyState.PAUSED: self.tr("PAUSED"),
            SurveyState.PAUSING: self.tr("PAUSING"),
            SurveyState.STOPPING: self.tr("STOPPING"),
            SurveyState.FINISHED: self.tr("FINISHED"),
            SurveyState.STOPPED: self.tr("STOPPED"),
            SurveyState.FAILED: self.tr("FAILED"),
        }

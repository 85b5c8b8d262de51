"""What was refused or has failed: the reason and the next step."""

from __future__ import annotations

import enum
from typing import Dict, Optional, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QLabel, QPlainTextEdit, QVBoxLayout, QWidget

from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.robot_text import robot_text
from gpr20_user_interface.views.style import new_button


class NoticeKind(enum.Enum):
    """What did not succeed: a Request to main_control, or the use of a profile."""

    START = "start"
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    PROFILE = "profile"


class Notice(Overlay):
    """A dialog over the tabs, closed by a touch."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._shown: Optional[Tuple[NoticeKind, str]] = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.title.setWordWrap(True)
        self.reason = QPlainTextEdit()
        self.reason.setReadOnly(True)
        self.reason.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.next_step = QLabel()
        self.next_step.setWordWrap(True)
        self.close_button = new_button(self.hide)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(24, 16, 24, 16)
        layout.setSpacing(12)
        layout.addWidget(self.title)
        layout.addWidget(self.reason, 1)
        layout.addWidget(self.next_step)
        layout.addWidget(self.close_button)

    def show_notice(self, kind: NoticeKind, reason: str) -> None:
        """Say why something did not succeed."""
        self._shown = kind, reason
        self.retranslate()
        self.open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.close_button.setText(self.tr("CLOSE"))
        if self._shown is None:
            return
        kind, reason = self._shown
        title, next_step = self._texts()[kind]
        self.title.setText(title)
        self.reason.setPlainText(robot_text(reason))
        self.next_step.setText(next_step)

    def _texts(self) -> Dict[NoticeKind, Tuple[str, str]]:
        return {
            NoticeKind.START: (
                self.tr("The survey was not started."),
                self.tr("Next: remove the cause named above, look at STATUS, then START again."),
            ),
            NoticeKind.STOP: (
                self.tr("STOP was not accepted."),
                self.tr(
                    "Next: look at STATUS. If the robot moves, press STOP again or switch "
                    "its power off."
                ),
            ),
            NoticeKind.PAUSE: (
                self.tr("The survey was not paused."),
                self.tr(
                    "Next: look at STATUS. STOP ends the survey at once, and it can be resumed."
                ),
            ),
            NoticeKind.RESUME: (
                self.tr("The survey was not resumed."),
                self.tr("Next: remove the cause named above, look at STATUS, then RESUME again."),
            ),
            NoticeKind.PROFILE: (
                self.tr("The profile cannot be used."),
                self.tr("Next: remove the cause named above, or use another profile."),
            ),
        }

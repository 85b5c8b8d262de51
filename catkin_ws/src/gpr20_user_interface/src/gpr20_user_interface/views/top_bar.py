"""The top of the window, visible from every tab: state, alarms, STOP."""

from __future__ import annotations

import math
from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.look import GAP_PX, TOP_BAR_PX, look_of
from gpr20_user_interface.views.replay_bar import ReplayBar
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text

ALARM_LINES = 1.7
UNKNOWN = "—"


class TopBar(TranslatedWidget):
    """Shows the state of the robot, and stops it; during a replay, a bar that says so instead."""

    def __init__(self) -> None:
        super().__init__()
        self._snapshot: Optional[Snapshot] = None
        self._robot = QWidget()
        self.replay = ReplayBar()
        self.replay.hide()
        self.title = QLabel(UNKNOWN)
        self.title.setObjectName("title")
        self.message = ElidedLabel()
        self.alarm = QLabel()
        self.alarm.setObjectName("alarm")
        self.alarm.setWordWrap(True)
        self.alarm.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.alarm.hide()
        self.simulated = QLabel()
        self.simulated.setObjectName("simulated")
        self.simulated.hide()
        self.stop = QPushButton()
        self.stop.setObjectName("stop")
        # A key that is pressed by accident must not reach it; a finger always does.
        self.stop.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.stop.setEnabled(False)
        self._lay_out()
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.stop.setText(self.tr("STOP"))
        self.simulated.setText(self.tr("SIMULATED"))
        if self._snapshot is not None:
            self.refresh(self._snapshot)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        self.setFixedHeight(look.px(TOP_BAR_PX))
        self.stop.setFixedHeight(look.px(TOP_BAR_PX) - look.px(GAP_PX))

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._snapshot = snapshot
        self.title.setText(self._title(snapshot))
        self.message.show_text("" if snapshot.state is None else shown_text(snapshot.state.message))
        self.simulated.setVisible(snapshot.simulated)
        self.alarm.setVisible(snapshot.alarm is not None)
        self.message.setVisible(snapshot.alarm is None)
        if snapshot.alarm is not None:
            self._show_alarm(shown_text(snapshot.alarm.message))
        self.stop.setEnabled(snapshot.can_stop)
        self.replay.refresh(snapshot)
        self._robot.setVisible(snapshot.replay is None)
        self.replay.setVisible(snapshot.replay is not None)

    def _title(self, snapshot: Snapshot) -> str:
        if snapshot.state is None:
            return UNKNOWN
        title = shown_text(snapshot.state.code.label)
        if not snapshot.running or snapshot.progress is None:
            return title
        # Rounded down: only a complete survey is shown as 100 %.
        percent = math.floor(snapshot.progress.completion_percent * 10.0) / 10.0
        return f"{title}  {percent:.1f} %"

    def _show_alarm(self, text: str) -> None:
        # Two lines, less what a line break may waste; STATUS shows the whole text.
        room_px = int(ALARM_LINES * self.alarm.width())
        metrics = self.alarm.fontMetrics()
        self.alarm.setText(metrics.elidedText(text, Qt.TextElideMode.ElideRight, room_px))
        self.alarm.setToolTip(text)

    def _lay_out(self) -> None:
        words = QVBoxLayout()
        words.setSpacing(0)
        for widget in (self.title, self.message, self.alarm):
            words.addWidget(widget)
        layout = QHBoxLayout(self._robot)
        layout.setContentsMargins(8, 2, 4, 2)
        layout.addLayout(words, 1)
        layout.addWidget(self.simulated)
        layout.addWidget(self.stop)
        both = QHBoxLayout(self)
        both.setContentsMargins(0, 0, 0, 0)
        both.setSpacing(0)
        both.addWidget(self._robot)
        both.addWidget(self.replay)

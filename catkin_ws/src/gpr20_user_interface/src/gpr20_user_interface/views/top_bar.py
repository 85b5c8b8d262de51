"""The top of the window, visible from every tab: state, alarms, STOP."""

from __future__ import annotations

import math
from typing import Optional

from PyQt5.QtCore import QSize, Qt
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout

from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text

HEIGHT_PX = 64
ALARM_LINES = 1.7
UNKNOWN = "—"


class TopBar(TranslatedWidget):
    """Shows the state of the robot, and stops it."""

    def __init__(self) -> None:
        super().__init__()
        self._snapshot: Optional[Snapshot] = None
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
        self.stop.setFixedHeight(HEIGHT_PX - 4)
        # A key that is pressed by accident must not reach it; a finger always does.
        self.stop.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.stop.setEnabled(False)
        self._lay_out()
        self.setFixedHeight(HEIGHT_PX)
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.stop.setText(self.tr("STOP"))
        self.simulated.setText(self.tr("SIMULATED"))
        if self._snapshot is not None:
            self.refresh(self._snapshot)

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
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 2, 4, 2)
        layout.addLayout(words, 1)
        layout.addWidget(self.simulated)
        layout.addWidget(self.stop)


class ElidedLabel(QLabel):
    """One line that ends with … where there is no room; the tool tip shows the whole text."""

    def __init__(self) -> None:
        super().__init__()
        self._whole = ""
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)

    @property
    def whole(self) -> str:
        """The text without anything left out."""
        return self._whole

    @property
    def is_cut(self) -> bool:
        """Whether some of the text has no room."""
        return self.text() != _one_line(self._whole)

    def show_text(self, text: str) -> None:
        """Show as much of a text as fits."""
        self._whole = text
        self.setToolTip(text)
        self._elide()

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it may be as narrow as it must."""
        return QSize(0, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Qt: there is more or less room."""
        super().resizeEvent(event)
        self._elide()

    def _elide(self) -> None:
        metrics = self.fontMetrics()
        room_px = self.width() - 2
        text = metrics.elidedText(_one_line(self._whole), Qt.TextElideMode.ElideRight, room_px)
        self.setText(text)


def _one_line(text: str) -> str:
    return " ".join(text.split())

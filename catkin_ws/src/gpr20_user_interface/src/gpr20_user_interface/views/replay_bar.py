"""The top of the window during a replay: which survey it shows; pause and continue."""

from __future__ import annotations

import math
from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout

from gpr20_user_interface.mid.replay import ReplayView
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text


class ReplayBar(TranslatedWidget):
    """A blue bar; a robot never has it."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("replay")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._replay: Optional[ReplayView] = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.message = ElidedLabel()
        self.pause = QPushButton()
        self.pause.setObjectName("replay_pause")
        self.pause.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.simulated = QLabel()
        self.simulated.setObjectName("simulated")
        words = QVBoxLayout()
        words.setSpacing(0)
        words.addWidget(self.title)
        words.addWidget(self.message)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 2, 4, 2)
        layout.addLayout(words, 1)
        layout.addWidget(self.simulated)
        layout.addWidget(self.pause)
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.simulated.setText(self.tr("SIMULATED"))
        paused = self._replay is not None and self._replay.paused
        self.pause.setText(self.tr("CONTINUE") if paused else self.tr("PAUSE"))

    def refresh(self, snapshot: Snapshot) -> None:
        """Show the replay, if the snapshot is one."""
        self._replay = snapshot.replay
        if self._replay is None:
            return
        title = shown_text(self._replay.title)
        if snapshot.progress is not None and snapshot.progress.total_points:
            # Rounded down: only a complete survey is shown as 100 %.
            percent = math.floor(snapshot.progress.completion_percent * 10.0) / 10.0
            title = f"{title}  {percent:.1f} %"
        self.title.setText(title)
        self.message.show_text(shown_text(self._replay.message))
        self.simulated.setVisible(snapshot.simulated)
        self.pause.setVisible(self._replay.can_pause)
        self.retranslate()

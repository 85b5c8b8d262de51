"""The top of the window, visible from every tab: state, PAUSE or RESUME, STOP."""

from __future__ import annotations

import math
from typing import Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from gpr20_common.message import Message
from gpr20_operator.robot.job import Job, band_of
from gpr20_operator.robot.replay import ReplayView
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_user_interface.look.look import GAP_PX, TOP_BAR_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.state_band import StateBand, StateSign


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


class TopBar(TranslatedWidget):
    """Shows the state of the robot, and stops it; during a replay, a bar that says so instead.

    STOP is never disabled: whatever is known of the robot, it may move. Only a replay, which is
    shown where there is no robot, has nothing to stop.
    """

    pause_pressed = pyqtSignal()
    # Resuming moves the robot: the receiver asks first.
    resume_pressed = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self._snapshot: Optional[Snapshot] = None
        self._robot = QWidget()
        self.band = StateBand()
        self.replay = ReplayBar()
        self.replay.hide()
        self.sign = StateSign()
        self.title = QLabel()
        self.title.setObjectName("title")
        # Its name, where several robots share a master.
        self._name = ""
        self.message = LinesLabel()
        self.simulated = QLabel()
        self.simulated.setObjectName("simulated")
        self.simulated.hide()
        self.pause = QPushButton()
        self.pause.setObjectName("pause")
        self.stop = QPushButton()
        self.stop.setObjectName("stop")
        # A key that is pressed by accident must not reach them; a finger always does.
        for button in (self.pause, self.stop):
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.pause.setEnabled(False)
        self.pause.hide()
        self.pause.clicked.connect(self._on_pause)
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
        for button in (self.pause, self.stop):
            button.setFixedHeight(look.px(TOP_BAR_PX) - look.px(GAP_PX))
        self._layout.setSpacing(look.px(GAP_PX))
        self._layout.setContentsMargins(0, 0, look.px(4), 0)
        self._band_layout.setSpacing(look.px(GAP_PX))
        self._band_layout.setContentsMargins(0, look.px(2), look.px(4), look.px(2))

    def show_robot(self, name: str) -> None:
        """Name the robot that STOP stops, from the next refresh on; empty: there is only one."""
        self._name = name

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._snapshot = snapshot
        job = band_of(snapshot)
        self.band.show_level(job.level)
        self.sign.show_level(job.level)
        self.title.setText(title_text(job))
        message = sentence_text(short_message(job))
        self.message.show_text(f"{self._name}: {message}" if self._name else message)
        self.simulated.setVisible(snapshot.simulated)
        paused = snapshot.paused
        self.pause.setText(self.tr("RESUME") if paused else self.tr("PAUSE"))
        self.pause.setVisible(snapshot.running)
        self.pause.setEnabled(snapshot.can_resume if paused else snapshot.can_pause)
        self.replay.refresh(snapshot)
        self._robot.setVisible(snapshot.replay is None)
        self.replay.setVisible(snapshot.replay is not None)

    def _on_pause(self) -> None:
        if self._snapshot is not None and self._snapshot.paused:
            self.resume_pressed.emit()
        else:
            self.pause_pressed.emit()

    def _lay_out(self) -> None:
        first = QHBoxLayout()
        first.setSpacing(0)
        first.addWidget(self.title)
        first.addStretch(1)
        first.addWidget(self.simulated)
        words = QVBoxLayout()
        words.setSpacing(0)
        words.setContentsMargins(0, 0, 0, 0)
        words.addLayout(first)
        words.addWidget(self.message, 1)
        inside = QHBoxLayout(self.band)
        inside.addWidget(self.sign)
        inside.addLayout(words, 1)
        self._band_layout = inside
        layout = QHBoxLayout(self._robot)
        layout.addWidget(self.band, 1)
        layout.addWidget(self.pause)
        layout.addWidget(self.stop)
        self._layout = layout
        both = QHBoxLayout(self)
        both.setContentsMargins(0, 0, 0, 0)
        both.setSpacing(0)
        for widget in (self._robot, self.replay):
            both.addWidget(widget)


def title_text(job: Job) -> str:
    """Return the state, with the percentage if there is one."""
    title = shown_text(job.title)
    return title if job.percent is None else f"{title} {job.percent} %"


def short_message(job: Job) -> Message:
    """Return how long it still takes, or what the operator must read instead."""
    return job.message if job.left is None else job.left

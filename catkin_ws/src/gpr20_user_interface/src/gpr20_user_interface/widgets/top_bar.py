"""The top of the window, visible from every page: the state, PAUSE or RESUME, STOP."""

from __future__ import annotations

from typing import Dict, Optional

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QVBoxLayout

from gpr20_operator.robot.condition import Condition, JobLevel, condition_of, left_of
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.icons import sign
from gpr20_user_interface.look.look import GAP_PX, LEVEL_COLOURS, TOP_BAR_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.widgets import set_look

SIGN_PX = 36
# Above and below a title with one line.
SHORT_ABOVE_PX = 8
# Levels are known without their colours.
SIGNS: Dict[JobLevel, str] = {
    JobLevel.WORKING: "resume",
    JobLevel.PAUSED: "pause",
    JobLevel.ATTENTION: "warning",
    JobLevel.FAULT: "fault",
    JobLevel.DONE: "check",
    JobLevel.REST: "rest",
    JobLevel.REPLAY: "replay",
}


class StateBand(QFrame):
    """The state, what the robot does, and what to do first; a touch opens all of it."""

    touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("band")
        self.level = JobLevel.REST
        self.sign = QLabel()
        self.title = ElidedLabel()
        self.title.setObjectName("title")
        self.message = LinesLabel()
        self.message.setObjectName("band_message")
        self.simulated, self.more = QLabel(), QLabel()
        self.simulated.setObjectName("simulated")
        self.more.setObjectName("what_to_do")
        self._words, chips = QVBoxLayout(), QVBoxLayout()
        self._words.setSpacing(0)
        self._words.addWidget(self.title)
        self._words.addWidget(self.message, 1)
        for chip in (self.simulated, self.more):
            chip.setAlignment(Qt.AlignmentFlag.AlignCenter)
            chips.addWidget(chip)
        self._layout = QHBoxLayout(self)
        self._layout.addWidget(self.sign)
        self._layout.addLayout(self._words, 1)
        self._layout.addLayout(chips)

    def show_condition(self, condition: Condition, left: str, robot: str) -> None:
        """Show how it is.

        Args:
            condition: The gravest that is known.
            left: How long the survey still takes, in place of the message; empty: not known.
            robot: Its name, where there are several; else empty.
        """
        self.level = condition.level
        for widget in (self, self.sign, self.title, self.message, self.more):
            set_look(widget, "job", condition.level.value)
        self.restyle()
        self.title.show_text(shown_text(condition.title))
        remedy = condition.asked
        words = left or sentence_text(condition.message)
        if remedy is not None:
            words = f"{words.rstrip('.')}. {shown_text(remedy)}"
        self.message.show_text(f"{robot}: {words}" if robot else words)
        self.more.setVisible(remedy is not None)
        # Two short lines stand in the middle of the band.
        message = self.message
        short = message.fontMetrics().horizontalAdvance(message.text()) <= message.width()
        above_px = look_of(self).px(SHORT_ABOVE_PX) if short else 0
        self._words.setContentsMargins(0, above_px, 0, above_px)

    def restyle(self) -> None:
        """Take the sizes and colours of the look."""
        look = look_of(self)
        gap_px, edge_px = look.px(GAP_PX), look.px(1)
        self._layout.setSpacing(gap_px)
        self._layout.setContentsMargins(gap_px, edge_px, gap_px, edge_px)
        ink = look.text(LEVEL_COLOURS[self.level]).ink
        self.sign.setPixmap(sign(SIGNS[self.level], ink, look.px(SIGN_PX)))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger leaves the band, or what is written on it."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.touched.emit()


class TopBar(TranslatedWidget):
    """Shows the state of the robot, and stops it.

    STOP is never disabled: whatever is known of the robot, it may move. Only a replay, which is
    shown where there is no robot, has nothing to stop.
    """

    pause_pressed = pyqtSignal()
    # Resuming moves the robot: the receiver asks first.
    resume_pressed = pyqtSignal()
    # A replay is to pause, or to continue.
    replay_pressed = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self._snapshot: Optional[Snapshot] = None
        # The name of the robot, where several share a master.
        self._name = ""
        self.band = StateBand()
        # That somebody elsewhere may start the robot, and how long.
        self.remote = QLabel()
        self.remote.setObjectName("remote")
        self.remote.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.remote.hide()
        self.pause, self.stop = QPushButton(), QPushButton()
        self.pause.setObjectName("pause")
        self.stop.setObjectName("stop")
        # A key that is pressed by accident must not reach them; a finger always does.
        for button in (self.pause, self.stop):
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.pause.hide()
        self.pause.clicked.connect(self._on_pause)
        self._layout = QHBoxLayout(self)
        self._layout.addWidget(self.band, 1)
        self._layout.addWidget(self.remote)
        self._layout.addWidget(self.pause)
        self._layout.addWidget(self.stop)
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.stop.setText(self.tr("STOP"))
        self.band.simulated.setText(self.tr("SIMULATED"))
        self.band.more.setText(self.tr("WHAT TO DO"))
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
        self.band.restyle()

    def show_robot(self, name: str) -> None:
        """Name the robot that STOP stops, from the next refresh on; empty: there is only one."""
        self._name = name

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._snapshot = snapshot
        condition, left = condition_of(snapshot), left_of(snapshot)
        text = ""
        if left is not None and condition.level in (JobLevel.WORKING, JobLevel.PAUSED):
            text = sentence_text(left)
        self.band.show_condition(condition, text, self._name)
        self.band.simulated.setVisible(snapshot.simulated)
        replay, paused = snapshot.replay, snapshot.paused
        self.stop.setVisible(replay is None)
        if replay is not None:
            self.pause.setText(self.tr("CONTINUE") if replay.paused else self.tr("PAUSE"))
            self.pause.setVisible(replay.can_pause)
            self.pause.setEnabled(True)
            return
        self.pause.setText(self.tr("RESUME") if paused else self.tr("PAUSE"))
        self.pause.setVisible(snapshot.running)
        self.pause.setEnabled(snapshot.can_resume if paused else snapshot.can_pause)

    def _on_pause(self) -> None:
        if self._snapshot is None:
            return
        if self._snapshot.replay is not None:
            self.replay_pressed.emit()
        elif self._snapshot.paused:
            self.resume_pressed.emit()
        else:
            self.pause_pressed.emit()

"""What frames every page: the state, PAUSE or RESUME and STOP above it; the rail beside it."""

from __future__ import annotations

import enum
from typing import Any, Dict, Optional

from PyQt5.QtCore import QSize, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import (
    QButtonGroup,
    QFrame,
    QLabel,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from gpr20_common.message import Message, verbatim
from gpr20_operator.robot.condition import Condition, JobLevel, condition_of, left_of
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import (
    GAP_PX,
    LEVEL_COLOURS,
    TextColours,
    icon,
    look_of,
    sign,
)
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.widgets.tile import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.widgets import column, new_button, new_label, row, say, set_look

SIGN_PX = 36
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
# Of the name of a robot; the band has no room for more.
LONGEST_NAME = 16
# In these a plan may be right that the robot does not know yet.
PLANNED = (SurveyState.IDLE, SurveyState.CONFIGURED)


class StateBand(QFrame):
    """The state, what the robot does, and what to do first; a touch opens all of it."""

    touched = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("band")
        self.level = JobLevel.REST
        self.sign, self.title, self.message = QLabel(), ElidedLabel(), LinesLabel()
        self.title.setObjectName("title")
        self.message.setObjectName("band_message")
        self.simulated = new_label("simulated", text=Message("SIMULATED"))
        self.more = new_label("what_to_do", text=Message("WHAT TO DO"))
        for chip in (self.simulated, self.more):
            chip.setAlignment(Qt.AlignmentFlag.AlignCenter)
        words = column(self.title, (self.message, 1), gap=0)
        chips = column(self.simulated, self.more, gap=GAP_PX // 2)
        chips.insertStretch(0)
        chips.addStretch()
        self.setLayout(row(self.sign, (words, 1), chips, margin=GAP_PX // 2))

    def show_condition(
        self, condition: Condition, title: Message, message: Message, robot: str = ""
    ) -> None:
        """Show how it is.

        Args:
            condition: The gravest that is known.
            title: The state in a word or two.
            message: What the robot does, or how long it still takes.
            robot: Its name; empty: it has none.
        """
        self.level = condition.level
        for widget in (self, self.sign, self.title, self.message, self.simulated, self.more):
            set_look(widget, "job", condition.level.value)
        self.show_again()
        self.title.setText(shown_text(title))
        words, remedy = sentence_text(message), condition.asked
        if remedy is not None:
            words = f"{words.rstrip('.')}. {shown_text(remedy)}"
        words = f"{robot}: {words}" if robot else words
        self.message.setText(words)
        # A title alone stands in the middle of the band.
        self.message.setVisible(bool(words))
        self.more.setVisible(remedy is not None)

    def show_again(self) -> None:
        """Paint the sign in the colours and the size of the look."""
        look = look_of(self)
        ink = look.text(LEVEL_COLOURS[self.level]).ink
        self.sign.setPixmap(sign(SIGNS[self.level], ink, look.px(SIGN_PX)))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger leaves the band, or what is written on it."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.touched.emit()


class TopBar(QWidget):
    """Shows the state of the robot, and stops it.

    STOP is never disabled: whatever is known of the robot, it may move. Only a replay, which is
    shown where there is no robot, has nothing to stop.
    """

    pause_pressed = pyqtSignal()
    # Resuming moves the robot: the receiver asks first.
    resume_pressed = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self._snapshot: Optional[Snapshot] = None
        # The name of the robot, which may share a master with others.
        self._name = ""
        self.band = StateBand()
        # That somebody elsewhere may start the robot, and how long.
        self.remote = new_label("remote")
        self.remote.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.remote.hide()
        self.pause, self.stop = new_button(self._on_pause), QPushButton()
        self.pause.setObjectName("pause")
        self.stop.setObjectName("stop")
        say(self.stop, Message("STOP"))
        # A key that is pressed by accident must not reach them; a finger always does.
        for button in (self.pause, self.stop):
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.pause.hide()
        self.setObjectName("top_bar")
        self.setLayout(row((self.band, 1), self.remote, self.pause, self.stop))

    def show_robot(self, name: str) -> None:
        """Name the robot that STOP stops, from the next refresh on; empty: it has no name."""
        # The end of names differs most often.
        self._name = name if len(name) <= LONGEST_NAME else f"…{name[1 - LONGEST_NAME :]}"

    def show_state(self, snapshot: Snapshot, ready: bool, figures: bool) -> None:
        """Show what is known now.

        Args:
            snapshot: What is known.
            ready: Whether START would start a survey.
            figures: Whether the page in front shows how far the survey is.
        """
        self._snapshot = snapshot
        condition, left = condition_of(snapshot), left_of(snapshot)
        title: Any = condition.title
        message = condition.message
        if ready and condition.level is JobLevel.REST and snapshot.code in PLANNED:
            title, message = Message("READY"), verbatim("")
        elif figures and "percent" in title.values:
            title = title.values["state"]
        elif left is not None and condition.level in (JobLevel.WORKING, JobLevel.PAUSED):
            message = left
        self.band.show_condition(condition, title, message, self._name)
        self.band.simulated.setVisible(snapshot.simulated)
        is_robot, paused = not snapshot.replay, snapshot.paused
        self.stop.setVisible(is_robot)
        self.pause.setText(self.tr("RESUME") if paused else self.tr("PAUSE"))
        self.pause.setVisible(is_robot and snapshot.running)
        self.pause.setEnabled(snapshot.can_resume if paused else snapshot.can_pause)

    def _on_pause(self) -> None:
        if self._snapshot is None:
            return
        if self._snapshot.paused:
            self.resume_pressed.emit()
        else:
            self.pause_pressed.emit()


ICON_PX = 32


class TabName(enum.Enum):
    """The tabs, in their order; the values are the names of their signs."""

    SURVEY = "survey"
    GROUND = "ground"
    SURVEYS = "surveys"
    ROBOT = "robot"


TITLES = {
    TabName.SURVEY: Message("Survey"),
    TabName.GROUND: Message("Ground"),
    TabName.SURVEYS: Message("Surveys"),
    TabName.ROBOT: Message("Robot"),
}


class Rail(QWidget):
    """Shows which tab is in front, and lets the operator choose another one.

    Attributes:
        tabs: The button of each tab.
        settings: Opens the settings.
        lock: Locks the screen.
    """

    # A TabName.
    chosen = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self.tabs = {name: _button() for name in TabName}
        self.settings, self.lock = _button(), _button()
        # They do not belong to the survey.
        for button in (self.settings, self.lock):
            button.setProperty("foot", True)
        self.setObjectName("rail_column")
        group = QButtonGroup(self)
        for name, button in self.tabs.items():
            say(button, TITLES[name])
            button.setCheckable(True)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)
            group.addButton(button)
            button.clicked.connect(lambda _checked, name=name: self.chosen.emit(name))
        tabs = [(button, 1) for button in self.tabs.values()]
        self.setLayout(column(*tabs, self.settings, self.lock, gap=0))

    def show_chosen(self, name: TabName) -> None:
        """Show which tab is in front."""
        self.tabs[name].setChecked(True)
        self.show_again()

    def show_again(self) -> None:
        """Take sizes and colours of the look."""
        look = look_of(self)
        signs: Dict[QToolButton, str] = {one: name.value for name, one in self.tabs.items()}
        for button, name in {**signs, self.settings: "settings", self.lock: "lock"}.items():
            colours = TextColours.CHOSEN if button.isChecked() else TextColours.ARROW
            button.setIcon(icon(name, look.text(colours).ink, look.px(ICON_PX)))
            button.setIconSize(QSize(look.px(ICON_PX), look.px(ICON_PX)))


def _button() -> QToolButton:
    """Return a sign, as high as the rail has room for."""
    button = QToolButton()
    button.setObjectName("rail")
    button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
    return button

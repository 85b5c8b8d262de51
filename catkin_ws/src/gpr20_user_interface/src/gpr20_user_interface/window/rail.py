"""Which page is in front: the rail with a button for each tab, and the screens of SURVEY."""

from __future__ import annotations

import enum
from typing import Dict

from PyQt5.QtCore import QSize, Qt, pyqtSignal
from PyQt5.QtWidgets import QButtonGroup, QSizePolicy, QToolButton, QWidget

from gpr20_common.message import Message
from gpr20_user_interface.look.look import TextColours, icon, look_of
from gpr20_user_interface.widgets.widgets import column, say

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
    TabName.SURVEYS: Message("Archive"),
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
        for button, sign in {**signs, self.settings: "settings", self.lock: "lock"}.items():
            colours = TextColours.CHOSEN if button.isChecked() else TextColours.ARROW
            button.setIcon(icon(sign, look.text(colours).ink, look.px(ICON_PX)))
            button.setIconSize(QSize(look.px(ICON_PX), look.px(ICON_PX)))


def _button() -> QToolButton:
    """Return a sign, as high as the rail has room for."""
    button = QToolButton()
    button.setObjectName("rail")
    button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
    return button

"""The rail at the left of the window: one button for each tab, the settings and the lock."""

from __future__ import annotations

import enum
from typing import Dict

from PyQt5.QtCore import QSize, Qt, pyqtSignal
from PyQt5.QtWidgets import QButtonGroup, QSizePolicy, QToolButton, QVBoxLayout

from gpr20_user_interface.look.icons import icon
from gpr20_user_interface.look.look import GAP_PX, Look, TextColours, look_of
from gpr20_user_interface.look.translation import TranslatedWidget

RAIL_PX = 84
ICON_PX = 32
# What does not belong to the survey: settings and lock.
FOOT_PX = 52


class TabName(enum.Enum):
    """The tabs, in their order; the values are the names of their signs."""

    SURVEY = "survey"
    GROUND = "ground"
    SURVEYS = "surveys"
    ROBOT = "robot"


class RailButton(QToolButton):
    """A sign with a word below it, as high as the rail has room for."""

    def __init__(self, sign: str) -> None:
        super().__init__()
        self._sign = sign
        self.setObjectName("rail")
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextUnderIcon)

    def restyle(self, look: Look) -> None:
        """Take sizes and colours of the look."""
        colours = TextColours.CHOSEN if self.isChecked() else TextColours.ARROW
        size_px = look.px(ICON_PX)
        self.setIcon(icon(self._sign, look.text(colours).ink, size_px))
        self.setIconSize(QSize(size_px, size_px))


class Rail(TranslatedWidget):
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
        self.setObjectName("rail")
        self.tabs: Dict[TabName, RailButton] = {name: RailButton(name.value) for name in TabName}
        self.settings, self.lock = RailButton("settings"), RailButton("lock")
        group = QButtonGroup(self)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        for name, button in self.tabs.items():
            button.setCheckable(True)
            group.addButton(button)
            layout.addWidget(button, 1)
            button.clicked.connect(lambda _checked, name=name: self.chosen.emit(name))
            button.toggled.connect(lambda _checked: self.restyle())
        for button in (self.settings, self.lock):
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
            layout.addWidget(button)
        self.retranslate()

    def show_chosen(self, name: TabName) -> None:
        """Show which tab is in front."""
        self.tabs[name].setChecked(True)

    def restyle(self) -> None:
        """Take sizes and colours of the look."""
        look = look_of(self)
        self.setFixedWidth(look.px(RAIL_PX))
        for button in (*self.tabs.values(), self.settings, self.lock):
            button.restyle(look)
        for button in (self.settings, self.lock):
            button.setFixedHeight(look.px(FOOT_PX))
        self.layout().setContentsMargins(0, 0, 0, look.px(GAP_PX) // 2)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        titles = {
            TabName.SURVEY: self.tr("Survey"),
            TabName.GROUND: self.tr("Ground"),
            TabName.SURVEYS: self.tr("Archive"),
            TabName.ROBOT: self.tr("Robot"),
        }
        for name, title in titles.items():
            self.tabs[name].setText(title)

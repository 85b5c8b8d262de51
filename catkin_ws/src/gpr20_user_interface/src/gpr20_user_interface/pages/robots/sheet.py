"""The sheet on which the operator chooses the robot that the window shows."""

from __future__ import annotations

from functools import partial
from typing import List, Tuple

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QLabel, QPushButton, QWidget

from gpr20_operator.robot.robots import ListedRobot
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button

MARGIN_PX = 24
ROWS, COLUMNS = 4, 2
PER_PAGE = ROWS * COLUMNS
LONGEST_NAME = 14


class RobotsSheet(Overlay):
    """Lists the robots of the ROS master; a touch of one shows it in this window."""

    robot_chosen = pyqtSignal(str)
    closed = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._robots: Tuple[ListedRobot, ...] = ()
        self._page = 0
        self._free = True
        self.title = QLabel()
        self.title.setObjectName("title")
        self.hint = QLabel()
        self.hint.setObjectName("quiet")
        self.hint.setWordWrap(True)
        self.buttons: List[QPushButton] = [
            new_button(partial(self._choose, number)) for number in range(PER_PAGE)
        ]
        self.next_page = new_button(self._show_next_page)
        self.close_button = new_button(self._close)
        self._lay_out()
        self.retranslate()
        self.restyle()

    def show_robots(self, robots: Tuple[ListedRobot, ...], free: bool) -> None:
        """List the robots.

        Args:
            robots: What is known of each.
            free: Whether the window may leave its robot now; not while a STOP is not answered.
        """
        if (robots, free) != (self._robots, self._free):
            self._robots, self._free = robots, free
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(self.tr("Which robot does this window show?"))
        self.hint.setText(
            self.tr("STOP stops the robot that is shown, and no other. Surveys continue.")
        )
        self.next_page.setText(self.tr("MORE"))
        self.close_button.setText(self.tr("CLOSE"))
        pages = -(-len(self._robots) // PER_PAGE)
        self._page = self._page % pages if pages else 0
        self.next_page.setVisible(pages > 1)
        first = self._page * PER_PAGE
        listed = self._robots[first : first + PER_PAGE]
        for button, robot in zip(self.buttons, listed):
            button.setText(f"{robot.short_name(LONGEST_NAME)}\n{shown_text(robot.activity)}")
            button.setEnabled(self._free and not robot.is_shown)
        for number, button in enumerate(self.buttons):
            button.setVisible(number < len(listed))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        margin, gap = look.px(MARGIN_PX), look.px(GAP_PX)
        self._layout.setContentsMargins(margin, gap, margin, gap)
        self._layout.setSpacing(gap)

    def _choose(self, number: int) -> None:
        self.robot_chosen.emit(self._robots[self._page * PER_PAGE + number].namespace)

    def _show_next_page(self) -> None:
        self._page += 1
        self.retranslate()

    def _close(self) -> None:
        self.hide()
        self.closed.emit()

    def _lay_out(self) -> None:
        layout = self._layout = QGridLayout(self)
        layout.addWidget(self.title, 0, 0, 1, COLUMNS)
        for number, button in enumerate(self.buttons):
            layout.addWidget(button, 1 + number // COLUMNS, number % COLUMNS)
        layout.addWidget(self.hint, 1 + ROWS, 0, 1, COLUMNS)
        layout.addWidget(self.next_page, 2 + ROWS, 0)
        layout.addWidget(self.close_button, 2 + ROWS, 1)
        layout.setRowStretch(1 + ROWS, 1)
        for column in range(COLUMNS):
            layout.setColumnStretch(column, 1)

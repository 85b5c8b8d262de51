"""The robots of the ROS master: their names where there are several, and the choice of one."""

from __future__ import annotations

from functools import partial
from typing import Callable, List, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QGridLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from gpr20_common.low.clock import Clock
from gpr20_operator.robot.events import Request
from gpr20_operator.robot.robots import ListedRobot, Robots
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.widgets import fill, new_button, scroll_area

MARGIN_PX = 24
COLUMNS = 2
LONGEST_NAME = 14
# In the top bar.
LONGEST_IN_BAR = 16


class RobotsPage(Overlay, Page):
    """Lists the robots of the ROS master; a touch of one shows it in this window."""

    def __init__(
        self,
        window: QWidget,
        robots: Robots,
        open_button: QPushButton,
        show_name: Callable[[str], None],
        clock: Clock,
    ) -> None:
        super().__init__(window)
        self._robots = robots
        self._open_button = open_button
        self._show_name = show_name
        self._clock = clock
        self._opened_s = clock.now_s()
        self._control_seen = False
        self._proposed = False
        self._listed: Tuple[ListedRobot, ...] = ()
        # Whether the window may leave its robot now.
        self._free = True
        self.title, self.hint = QLabel(), QLabel()
        self.title.setObjectName("title")
        self.hint.setObjectName("quiet")
        self.hint.setWordWrap(True)
        self.buttons: List[QPushButton] = []
        self.close_button = new_button(self._close)
        open_button.clicked.connect(lambda: self._open())
        self._lay_out()
        self.retranslate()
        self.restyle()

    def on_event(self, event: object) -> None:
        """Follow the robots of the master."""
        self._robots.take(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now; propose a choice once if the window has no robot."""
        robots = self._robots
        self._control_seen = self._control_seen or snapshot.control_alive
        self._open_button.setVisible(robots.can_choose)
        several = robots.are_several and snapshot.replay is None
        self._show_name(robots.shown.short_name(LONGEST_IN_BAR) if several else "")
        open_s = self._clock.now_s() - self._opened_s
        if not self._proposed and robots.must_choose(self._control_seen, open_s):
            self._proposed = True
            self._open()
        if self.isVisible():
            # Not while a STOP is not answered.
            self._list(Request.STOP not in snapshot.pending)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(self.tr("Which robot does this window show?"))
        self.hint.setText(
            self.tr("STOP stops the robot that is shown, and no other. Surveys continue.")
        )
        self.close_button.setText(self.tr("CLOSE"))
        while len(self.buttons) < len(self._listed):
            number = len(self.buttons)
            self.buttons.append(new_button(partial(self._choose, number)))
            self._grid.addWidget(self.buttons[-1], *divmod(number, COLUMNS))
        for button, robot in zip(self.buttons, self._listed):
            button.setText(f"{robot.short_name(LONGEST_NAME)}\n{shown_text(robot.activity)}")
            button.setEnabled(self._free and not robot.is_shown)
        for number, button in enumerate(self.buttons):
            button.setVisible(number < len(self._listed))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        margin, gap = look.px(MARGIN_PX), look.px(GAP_PX)
        self._layout.setContentsMargins(margin, gap, margin, gap)
        for layout in (self._layout, self._grid):
            layout.setSpacing(gap)

    def _list(self, free: bool) -> None:
        if (self._robots.listed, free) != (self._listed, self._free):
            self._listed, self._free = self._robots.listed, free
            self.retranslate()

    def _open(self) -> None:
        self._robots.watch(True)
        self._list(True)
        self.open()

    def _choose(self, number: int) -> None:
        self._robots.show(self._listed[number].namespace)

    def _close(self) -> None:
        self.hide()
        self._robots.watch(False)

    def _lay_out(self) -> None:
        content = QWidget()
        self._grid = QGridLayout(content)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setAlignment(Qt.Alignment() | Qt.AlignmentFlag.AlignTop)
        for column in range(COLUMNS):
            self._grid.setColumnStretch(column, 1)
        self._layout = QVBoxLayout(self)
        fill(self._layout, self.title, (scroll_area(content), 1), self.hint, self.close_button)

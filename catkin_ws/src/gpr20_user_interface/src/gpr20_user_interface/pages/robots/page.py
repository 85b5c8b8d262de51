"""The robots of the ROS master: their names where there are several, and the choice of one."""

from __future__ import annotations

from functools import partial
from typing import Callable, List, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QPushButton, QWidget

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_operator.robot.events import Request
from gpr20_operator.robot.robots import ListedRobot, Robots
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.widgets import (
    column,
    grid,
    new_button,
    new_label,
    scroll_area,
)

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
        self._robots, self._open_button, self._show_name = robots, open_button, show_name
        self._clock, self._opened_s = clock, clock.now_s()
        self._control_seen = self._proposed = False
        self._listed: Tuple[ListedRobot, ...] = ()
        title = new_label("title", text=Message("Which robot does this window show?"))
        only = Message("STOP stops the robot that is shown, and no other. Surveys continue.")
        hint = new_label("quiet", wraps=True, text=only)
        self.buttons: List[QPushButton] = []
        self.close_button = new_button(self._close, Message("CLOSE"))
        open_button.clicked.connect(self._open)
        content = QWidget()
        self._grid = grid()
        self._grid.setAlignment(Qt.Alignment() | Qt.AlignmentFlag.AlignTop)
        content.setLayout(self._grid)
        parts = (title, (scroll_area(content), 1), hint, self.close_button)
        self.setLayout(column(*parts, margin=2 * GAP_PX))

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

    def _list(self, free: bool) -> None:
        self._listed = self._robots.listed
        while len(self.buttons) < len(self._listed):
            number = len(self.buttons)
            self.buttons.append(new_button(partial(self._choose, number)))
            self._grid.addWidget(self.buttons[-1], *divmod(number, COLUMNS))
        for button, robot in zip(self.buttons, self._listed):
            button.setText(f"{robot.short_name(LONGEST_NAME)}\n{shown_text(robot.activity)}")
            button.setEnabled(free and not robot.is_shown)
        for number, button in enumerate(self.buttons):
            button.setVisible(number < len(self._listed))

    def _open(self) -> None:
        self._robots.watch(True)
        self._list(True)
        self.open()

    def _choose(self, number: int) -> None:
        self._robots.show(self._listed[number].namespace)

    def _close(self) -> None:
        self.hide()
        self._robots.watch(False)

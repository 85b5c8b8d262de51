"""Connects the choice of the robot with the robots on the ROS master."""

from __future__ import annotations

from PyQt5.QtWidgets import QWidget

from gpr20_common.low.clock import Clock
from gpr20_operator.robot.events import Request
from gpr20_operator.robot.robots import Robots
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_user_interface.pages.robots.sheet import RobotsSheet
from gpr20_user_interface.pages.settings.sheet import SettingsSheet
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.top_bar import TopBar

# In the top bar.
LONGEST_NAME = 16


class RobotsBinding(Page):
    """Names the robot where there are several, and lets the operator choose another one.

    Args:
        window: The window.
        robots: The robots of the master.
        settings: The sheet whose button opens the list.
        top_bar: Names the robot.
        clock: Measures how long the window has been open.

    Attributes:
        sheet: The list.
    """

    def __init__(
        self,
        window: QWidget,
        robots: Robots,
        settings: SettingsSheet,
        top_bar: TopBar,
        clock: Clock,
    ) -> None:
        self._robots = robots
        self._settings = settings
        self._top_bar = top_bar
        self._clock = clock
        self._opened_s = clock.now_s()
        self._control_seen = False
        self._proposed = False
        self.sheet = RobotsSheet(window)
        settings.robot_button.clicked.connect(lambda: self._open())
        self.sheet.robot_chosen.connect(robots.show)
        self.sheet.closed.connect(lambda: robots.watch(False))

    def on_event(self, event: object) -> None:
        """Follow the robots of the master."""
        self._robots.take(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now; propose a choice once if the window has no robot."""
        robots = self._robots
        self._control_seen = self._control_seen or snapshot.control_alive
        self._settings.robot_button.setVisible(robots.can_choose)
        several = robots.are_several and snapshot.replay is None
        self._top_bar.show_robot(robots.shown.short_name(LONGEST_NAME) if several else "")
        open_s = self._clock.now_s() - self._opened_s
        if not self._proposed and robots.must_choose(self._control_seen, open_s):
            self._proposed = True
            self._open()
        if self.sheet.isVisible():
            self.sheet.show_robots(robots.listed, Request.STOP not in snapshot.pending)

    def _open(self) -> None:
        self._robots.watch(True)
        self._settings.hide()
        self.sheet.show_robots(self._robots.listed, True)
        self.sheet.open()

"""Remote control: where the web page is, and the button that allows START and RESUME there."""

from __future__ import annotations

import math
from typing import Callable, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QLabel, QPushButton, QWidget

from gpr20_operator.plan.hold_question import HoldQuestion, remote_question
from gpr20_operator.robot.events import StartPlan
from gpr20_operator.robot.remote_control import Arming, remote_obstacle
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.widgets.hold_sheet import HoldSheet
from gpr20_user_interface.widgets.page import Page


class RemotePage(HoldSheet, Page):
    """Says where the web page is; a hold allows START and RESUME there until the next touch.

    Args:
        window: The window.
        arming: Whether they are allowed.
        plan: Returns what START would measure now.
        mark: Shows on every page that they are allowed, and how long.
        open_button: Opens the sheet.
    """

    # A survey has begun while it was allowed: the page has started it.
    survey_began = pyqtSignal()

    def __init__(
        self,
        window: QWidget,
        arming: Arming,
        plan: Callable[[], Optional[StartPlan]],
        mark: QLabel,
        open_button: QPushButton,
    ) -> None:
        super().__init__(window)
        self._arming, self._plan, self._mark = arming, plan, mark
        self._snapshot: Optional[Snapshot] = None
        open_button.clicked.connect(lambda: self.ask(self._current(), self._arm))

    def on_event(self, event: object) -> None:
        """Follow what the web page says."""
        self._arming.take(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show how long it is still allowed; end it if something forbids it."""
        before, self._snapshot = self._snapshot, snapshot
        self._arming.note(snapshot, self._plan())
        known = "" if before is None else before.running_survey
        if self._arming.armed and snapshot.running_survey not in ("", known):
            self.survey_began.emit()
        self._show_mark()
        if self.isVisible():
            self.show_question(self._current())

    def end(self) -> None:
        """Allow it no more: somebody has touched the window, or it closes."""
        if self._arming.armed:
            self._arming.touched()
            self._show_mark()

    def _arm(self) -> None:
        if self._snapshot is not None:
            self._arming.arm(self._snapshot)
            self._show_mark()

    def _current(self) -> HoldQuestion:
        snapshot = self._snapshot
        return remote_question(
            self._arming.web, None if snapshot is None else remote_obstacle(snapshot)
        )

    def _show_mark(self) -> None:
        left_s = math.ceil(self._arming.remaining_s)
        self._mark.setVisible(left_s > 0)
        title = self.tr("REMOTE")
        self._mark.setText(f"{title}\n{left_s // 60}:{left_s % 60:02d}")

"""The tab SURVEY: the plan of the next survey, or the survey that runs or ran last."""

from __future__ import annotations

from PyQt5.QtWidgets import QStackedWidget, QWidget

from gpr20_operator.robot.job import JobScreen
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_user_interface.widgets.page import Page


class SurveyTab(QStackedWidget, Page):
    """Shows the screen that the state of the survey needs."""

    def __init__(self, plan: QWidget, job: QWidget) -> None:
        super().__init__()
        self._screen = JobScreen()
        self._plan, self._job = plan, job
        for screen in (plan, job):
            self.addWidget(screen)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show the screen that is needed now."""
        self._screen.note(snapshot)
        self._show()

    def show_plan(self, snapshot: Snapshot) -> None:
        """Show the plan of the next survey; not while one is running."""
        self._screen.leave(snapshot)
        self._show()

    def _show(self) -> None:
        screen = self._job if self._screen.visible else self._plan
        if self.currentWidget() is not screen:
            self.setCurrentWidget(screen)

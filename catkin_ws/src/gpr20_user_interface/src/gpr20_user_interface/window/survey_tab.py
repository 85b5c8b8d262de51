"""The tab SURVEY: the plan of the next survey, the survey that runs, or the result of one."""

from __future__ import annotations

from PyQt5.QtWidgets import QStackedWidget, QWidget

from gpr20_operator.robot.snapshot import JobScreen, Snapshot
from gpr20_user_interface.pages.result.page import ResultPage
from gpr20_user_interface.widgets.page import Page


class SurveyTab(QStackedWidget, Page):
    """Shows the screen that the state of the survey needs.

    Args:
        plan: The plan of the next survey.
        job: A survey that runs, or a replay.
        result: A survey that has ended, or a stored one.
    """

    def __init__(self, plan: QWidget, job: QWidget, result: ResultPage) -> None:
        super().__init__()
        self._screen = JobScreen()
        self._plan, self._job, self._result = plan, job, result
        # Folder of a stored survey whose result was opened; empty: none.
        self._opened = ""
        for screen in (plan, job, result):
            self.addWidget(screen)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show the screen that is needed now."""
        self._screen.note(snapshot)
        if snapshot.running:
            self._opened = ""
        self._show(snapshot)

    def show_plan(self, snapshot: Snapshot) -> None:
        """Show the plan of the next survey; not while one is running."""
        self._opened = ""
        self._screen.leave(snapshot)
        self._show(snapshot)

    def show_result(self, folder: str, snapshot: Snapshot) -> None:
        """Show the result of a stored survey; not while one is running."""
        if not snapshot.running:
            self._opened = folder
            self._show(snapshot)

    def _show(self, snapshot: Snapshot) -> None:
        survey, screen = self._opened, self._plan
        if self._screen.visible:
            screen = self._job
            if snapshot.state is not None and not snapshot.running and snapshot.replay is None:
                survey = survey or snapshot.state.survey_id
        if survey:
            self._result.result.open(survey)
            screen = self._result
        if self.currentWidget() is not screen:
            self.setCurrentWidget(screen)

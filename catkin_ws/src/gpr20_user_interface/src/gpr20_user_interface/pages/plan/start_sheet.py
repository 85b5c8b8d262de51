"""The sheet before the robot moves: START and RESUME, by holding a button."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtWidgets import QWidget

from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.plan.hold_question import (
    HoldQuestion,
    other_analyzer_question,
    resume_past_question,
    resume_question,
    start_question,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_survey.faults import OTHER_ZEROS
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.widgets.hold_sheet import HoldSheet


class StartSheet(HoldSheet):
    """Asks before a survey starts or is resumed, and then requests it.

    It closes when what it asks is not possible any more: another client was faster.

    Args:
        window: The window.
        survey: Takes the requests.
        past: The list of past surveys.
    """

    def __init__(self, window: QWidget, survey: WindowPresenter, past: PastSurveys) -> None:
        super().__init__(window)
        self._survey = survey
        self._past = past
        self._is_possible: Callable[[Snapshot], bool] = _can_start
        self._make: Callable[[], HoldQuestion] = lambda: resume_question(None)

    def ask_start(self, parameters: SurveyParameters, annotation: Annotation) -> None:
        """Ask whether to start a survey."""

        def make() -> HoldQuestion:
            known = self._survey.preview_of(parameters)
            return start_question(parameters, known, annotation)

        self._ask(make, _can_start, lambda: self._survey.start(parameters, annotation))

    def ask_resume(self) -> None:
        """Ask whether to resume the survey that is paused."""
        unproven = _zeros_are_unproven(self._survey.snapshot)
        self._ask(
            lambda: resume_question(self._survey.snapshot.progress, unproven),
            _can_resume,
            lambda: self._survey.resume(accept_zeros=unproven),
        )

    def ask_resume_past(self, folder: str) -> None:
        """Ask whether to resume a survey that ended early."""
        self._ask(
            lambda: resume_past_question(folder, self._past.find(folder)),
            _no_survey_runs,
            lambda: self._survey.resume(folder),
        )

    def ask_resume_with(self, identity: str) -> None:
        """Ask whether to continue a survey with another analyzer."""
        self._ask(
            lambda: other_analyzer_question(identity),
            lambda snapshot: _no_survey_runs(snapshot) or _can_resume(snapshot),
            lambda: self._survey.resume_with(identity),
        )

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now; close if it is too late."""
        if not self.isVisible():
            return
        if self._is_possible(snapshot):
            self.show_question(self._make())
        else:
            self.hide()

    def _ask(
        self,
        make: Callable[[], HoldQuestion],
        is_possible: Callable[[Snapshot], bool],
        act: Callable[[], None],
    ) -> None:
        self._make, self._is_possible = make, is_possible
        self.ask(make(), act)


def _can_start(snapshot: Snapshot) -> bool:
    return snapshot.can_start


def _no_survey_runs(snapshot: Snapshot) -> bool:
    # If the main control does not answer, it is better said after the request than by a sheet
    # that closes.
    return not snapshot.fields_locked


def _can_resume(snapshot: Snapshot) -> bool:
    return snapshot.can_resume


def _zeros_are_unproven(snapshot: Snapshot) -> bool:
    """Return whether the paused survey waits for a decision about the zeros of the axes."""
    state = snapshot.state
    return state is not None and state.message.fault_code == OTHER_ZEROS.code

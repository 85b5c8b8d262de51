"""Connects the survey that runs with the top bar, STATUS and the dialogs."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtWidgets import QWidget

from gpr20_common.message import Message
from gpr20_operator.robot.notices import (
    Notice,
    Refused,
    analyzer_notice,
    node_notice,
    refusal_notice,
    state_notice,
)
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_operator.robot.survey_model import Refusal, Snapshot
from gpr20_user_interface.pages.plan.start_sheet import StartSheet
from gpr20_user_interface.pages.status.view import StatusView
from gpr20_user_interface.widgets.cards import AnalyzerQuestion, NoticeView
from gpr20_user_interface.widgets.page import Page
from gpr20_user_interface.widgets.top_bar import TopBar


class SurveyBinding(Page):
    """Passes PAUSE, RESUME and STOP on, shows state and refusals.

    Attributes:
        notice: The dialog of refusals and faults.
        question: The dialog about another analyzer.
    """

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        top_bar: TopBar,
        status: StatusView,
        start_sheet: StartSheet,
    ) -> None:
        self._survey = survey
        self._top_bar = top_bar
        self._status = status
        self._start_sheet = start_sheet
        self.notice = NoticeView(window)
        self.question = AnalyzerQuestion(window)
        top_bar.stop.pressed.connect(survey.stop)
        top_bar.pause_pressed.connect(survey.pause)
        top_bar.resume_pressed.connect(start_sheet.ask_resume)
        self.notice.resume_pressed.connect(top_bar.resume_pressed)
        top_bar.replay.pause.clicked.connect(lambda: survey.pause_replay())
        status.message.touched.connect(lambda state: self.notice.show_notice(state_notice(state)))
        status.health.node_touched.connect(lambda node: self.notice.show_notice(node_notice(node)))

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._top_bar.refresh(snapshot)
        self._status.refresh(snapshot)

    def take_refusal(self, refusal: Optional[Refusal]) -> None:
        """Show why a request was refused; None: none was."""
        if refusal is None:
            return
        if refusal.other_analyzer:
            self._ask_about_analyzer(refusal.reason, refusal.other_analyzer)
        else:
            self.show_refusal(Refused[refusal.request.name], refusal.reason)

    def show_refusal(self, refused: Refused, reason: Message) -> None:
        """Show why something did not succeed."""
        self.notice.show_notice(refusal_notice(refused, reason))

    def show_fault(self, card: Notice) -> None:
        """Show the card of a fault, unless a dialog asks about it or says it already."""
        shown = self.notice.notice if self.notice.isVisible() else None
        if not self.question.isVisible() and (shown is None or shown.text != card.text):
            self.notice.show_notice(card)

    def hide_resumable(self) -> None:
        """Close the card of a fault after which the survey has been resumed or stopped."""
        if self.notice.notice is not None and self.notice.notice.resumable:
            self.notice.hide()

    def _ask_about_analyzer(self, reason: Message, identity: str) -> None:
        # The status of the survey may have opened a notice with the same reason.
        self.notice.hide()
        self.question.ask(
            analyzer_notice(reason, identity),
            lambda: self._start_sheet.ask_resume_with(identity),
        )

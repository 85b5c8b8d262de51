"""The sheet that says what will happen, and waits for a button that is held."""

from __future__ import annotations

from operator import attrgetter
from typing import Callable, Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QSizePolicy, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.plan.texts import (
    HoldQuestion,
    other_analyzer_question,
    plan_question,
    resume_past_question,
    resume_question,
)
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.faults import OTHER_ZEROS
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.presenter import WindowPresenter
from gpr20_user_interface.touch.hold import HoldButton
from gpr20_user_interface.widgets.widgets import (
    Overlay,
    Page,
    column,
    grid,
    new_button,
    new_label,
    row,
    say,
    set_look,
)

MOST_ROWS = 12
MARGIN_PX = 12
LONGEST_WORD = 20


class HoldSheet(Overlay):
    """Shows a HoldQuestion; a button to hold is far from CANCEL.

    It lies where no other sheet has OK, CLOSE or CANCEL: a touch that comes twice never reaches
    it.

    Attributes:
        question: What is asked; None before the first time.
        hold: The button that must be held.
        cancel: Closes the sheet.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.question: Optional[HoldQuestion] = None
        self._act: Callable[[], None] = self.hide
        self.title = new_label("title")
        self._rows = [(new_label("row_name"), new_label(wraps=True)) for _ in range(MOST_ROWS)]
        self.warning, self.doubt = new_label("warning", wraps=True), new_label(wraps=True)
        self.hold = HoldButton()
        self.hold.setObjectName("large_hold")
        self.cancel = new_button(self.hide)
        self._lay_out()
        self.hold.held.connect(self._on_held)

    def ask(self, question: HoldQuestion, act: Callable[[], None]) -> None:
        """Open with a question.

        Args:
            question: What will happen.
            act: Called once the button has been held.
        """
        # In the language of now, also where the same was asked before.
        self._act, self.question = act, None
        self.show_question(question)
        self.open()

    def show_question(self, question: HoldQuestion) -> None:
        """Say the same with other words; what is held stays held."""
        if question == self.question:
            return
        self.question = question
        say(self.cancel, Message("CLOSE") if question.hold is None else Message("Cancel"))
        self.title.setText(shown_text(question.title))
        for label, text in (
            (self.warning, question.warning),
            (self.doubt, question.doubt),
            (self.hold, question.hold),
        ):
            label.setText("" if text is None else shown_text(text))
            label.setVisible(bool(label.text()))
        for number, pair in enumerate(self._rows):
            used = number < len(question.rows)
            for place, label in enumerate(pair):
                label.setVisible(used)
                label.setText(_broken(shown_text(question.rows[number][place])) if used else "")

    def _on_held(self) -> None:
        self.hide()
        self._act()

    def _lay_out(self) -> None:
        rows = grid(gap=0)
        for number, (name, value) in enumerate(self._rows):
            value.setTextFormat(Qt.TextFormat.PlainText)
            rows.addWidget(name, number, 0, Qt.AlignmentFlag.AlignTop)
            rows.addWidget(value, number, 1, Qt.AlignmentFlag.AlignTop)
        rows.setColumnStretch(1, 1)
        rows.setRowStretch(MOST_ROWS, 1)
        for label in (self.warning, self.doubt):
            set_look(label, "level", "doubtful")
        self.hold.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        right = column(self.warning)
        right.addStretch(1)
        right.addWidget(self.hold, 4)
        right.addStretch(1)
        right.addWidget(self.cancel)
        left = column(self.title, (rows, 1), self.doubt)
        self.setLayout(row((left, 1), right, margin=MARGIN_PX))


def _broken(text: str) -> str:
    """Let lines end in the identity of an analyzer, whose parts are separated by commas alone."""
    words = (one if len(one) <= LONGEST_WORD else one.replace(",", ", ") for one in text.split(" "))
    return " ".join(words)


CAN_START, CAN_RESUME = attrgetter("can_start"), attrgetter("can_resume")


class StartSheet(HoldSheet, Page):
    """Asks before a survey starts or is resumed, and then requests it.

    It closes when what it asks is not possible any more: another client was faster.

    Args:
        window: The window.
        survey: Takes the requests.
        past: The list of past surveys.
    """

    def __init__(self, window: QWidget, survey: WindowPresenter, past: PastSurveys) -> None:
        super().__init__(window)
        self._survey, self._past = survey, past
        # What moves the robot is green, as START is.
        set_look(self.hold, "moves", True)
        self._is_possible: Callable[[Snapshot], bool] = CAN_START
        self._make: Callable[[], HoldQuestion] = lambda: resume_question(None)

    def ask_start(
        self, parameters: SurveyParameters, permittivity: float, annotation: Annotation
    ) -> None:
        """Ask whether to start a survey."""

        def make() -> HoldQuestion:
            known = self._survey.preview_of(parameters)
            return plan_question(parameters, permittivity, known, annotation)

        self._ask(make, CAN_START, lambda: self._survey.start(parameters, permittivity, annotation))

    def ask_resume(self) -> None:
        """Ask whether to resume the survey that is paused."""
        unproven = _zeros_are_unproven(self._survey.snapshot)
        self._ask(
            lambda: resume_question(self._survey.snapshot.progress, unproven),
            CAN_RESUME,
            lambda: self._survey.resume(accept_zeros=unproven),
        )

    def ask_resume_past(self, folder: str) -> None:
        """Ask whether to resume a survey that ended early."""
        self._ask(
            lambda: resume_past_question(folder, self._past.find(folder)),
            _no_survey_runs,
            lambda: self._survey.resume(folder),
        )

    def ask_resume_with(self, identity: str, reason: Message) -> None:
        """Ask whether to continue a survey with another analyzer."""
        self._ask(
            lambda: other_analyzer_question(reason),
            lambda snapshot: _no_survey_runs(snapshot) or snapshot.can_resume,
            lambda: self._survey.resume_with(identity),
        )

    def show_state(self, snapshot: Snapshot) -> None:
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


# If the main control does not answer, it is better said after the request than by a sheet that
# closes.
def _no_survey_runs(snapshot: Snapshot) -> bool:
    return not snapshot.fields_locked


def _zeros_are_unproven(snapshot: Snapshot) -> bool:
    """Return whether the paused survey waits for a decision about the zeros of the axes."""
    state = snapshot.state
    return state is not None and state.message.fault_code == OTHER_ZEROS.code

"""The CONTROL tab."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import (
    QButtonGroup,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QStackedWidget,
    QVBoxLayout,
)

from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.events import DOCUMENTED_TRAVEL
from gpr20_user_interface.mid.field_messages import (
    allowed_values,
    corrections,
    field_problems,
    field_title,
)
from gpr20_user_interface.mid.parameter_form import (
    ADDRESS,
    FormCheck,
    after_arrow,
    check_form,
    texts_of,
)
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.views.look import COMMAND_PX, look_of
from gpr20_user_interface.views.pad import Judge
from gpr20_user_interface.views.parameter_form_view import ParameterFormView, TouchEdit
from gpr20_user_interface.views.preview_panel import PreviewPanel
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text

STEPS = (1, 10, 100)
SIDE_WIDTH_PX = 166


@dataclass(frozen=True)
class PadRequest:
    """A field that needs keys: their texts, and where the entry goes."""

    title: str
    hint: str
    edit: TouchEdit
    judge: Judge


class ControlView(TranslatedWidget):
    """Parameters and their checks, START, PAUSE and RESUME."""

    # Carries the SurveyParameters.
    start_pressed = pyqtSignal(object)
    pause_pressed = pyqtSignal()
    resume_pressed = pyqtSignal()
    # Carries a PadRequest.
    pad_wanted = pyqtSignal(object)
    # Carries the SurveyParameters, or None while they are wrong.
    parameters_changed = pyqtSignal(object)

    def __init__(self) -> None:
        super().__init__()
        self.form = ParameterFormView()
        self.preview = PreviewPanel()
        self.problems = QPlainTextEdit()
        self.start = QPushButton()
        self.pause = QPushButton()
        self.profiles = QPushButton()
        self.notes = QPushButton()
        self._step_title = QLabel()
        self._steps = QButtonGroup(self)
        self._below = QStackedWidget()
        self._travel = DOCUMENTED_TRAVEL
        self._proposed_address = ""
        self._snapshot: Optional[Snapshot] = None
        self._check: FormCheck = check_form(self.form.texts(), self._travel)
        self._lay_out()
        self._connect()
        self.retranslate()

    @property
    def parameters(self) -> Optional[SurveyParameters]:
        """The values of the fields; None while they are wrong."""
        return self._check.parameters

    def step_button(self, step: int) -> QPushButton:
        """Return the button that chooses a step of the arrows."""
        button = self._steps.button(step)
        assert isinstance(button, QPushButton)
        return button

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        before, self._snapshot = self._snapshot, snapshot
        self._propose_address(snapshot)
        if (snapshot.travel or DOCUMENTED_TRAVEL) != self._travel:
            self._travel = snapshot.travel or DOCUMENTED_TRAVEL
            self._check_form()
        shown = None if before is None else before.survey_parameters
        if snapshot.survey_parameters is not None and snapshot.survey_parameters != shown:
            self.show_parameters(snapshot.survey_parameters)
        for widget in (self.form, self.profiles):
            widget.setEnabled(not snapshot.fields_locked)
        self._show_buttons()

    def show_parameters(self, parameters: SurveyParameters) -> None:
        """Put parameters into the fields."""
        for name, text in texts_of(parameters).items():
            self.form.show_text(name, text)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self._step_title.setText(self.tr("Arrows change by"))
        self.profiles.setText(self.tr("PROFILES"))
        self.notes.setText(self.tr("NOTES"))
        self.start.setText(self.tr("START"))
        self._show_problems()
        self._show_buttons()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        for button in (self.start, self.pause):
            button.setMinimumHeight(look.px(COMMAND_PX))
        self._grid.setColumnMinimumWidth(1, look.px(SIDE_WIDTH_PX))

    def _lay_out(self) -> None:
        self.problems.setObjectName("problems")
        self.problems.setReadOnly(True)
        self._below.addWidget(self.preview)
        self._below.addWidget(self.problems)
        self.start.setObjectName("start")
        self._step_title.setObjectName("quiet")
        grid = QGridLayout(self)
        grid.setContentsMargins(6, 4, 6, 4)
        grid.setHorizontalSpacing(10)
        grid.setVerticalSpacing(2)
        grid.addWidget(self.form, 0, 0)
        grid.addWidget(self._below, 1, 0)
        grid.addLayout(self._side(), 0, 1, 2, 1)
        grid.setColumnStretch(0, 1)
        self._grid = grid
        grid.setRowStretch(1, 1)

    def _side(self) -> QVBoxLayout:
        side = QVBoxLayout()
        side.setSpacing(6)
        side.addWidget(self._step_title)
        row = QHBoxLayout()
        row.setSpacing(6)
        for step in STEPS:
            button = QPushButton(str(step))
            button.setCheckable(True)
            button.setChecked(step == STEPS[0])
            self._steps.addButton(button, step)
            row.addWidget(button)
        side.addLayout(row)
        side.addWidget(self.profiles)
        side.addWidget(self.notes)
        side.addStretch(1)
        side.addWidget(self.pause)
        side.addWidget(self.start)
        return side

    def _connect(self) -> None:
        self.form.changed.connect(self._on_form_changed)
        self.form.stepped.connect(self._on_step)
        self.form.tapped.connect(self._on_tap)
        self.start.clicked.connect(self._on_start)
        self.pause.clicked.connect(self._on_pause)

    def _on_form_changed(self) -> None:
        self._check_form()
        self._show_buttons()

    def _on_step(self, name: str, direction: int) -> None:
        edit = self.form.edit(name)
        change = direction * self._steps.checkedId()
        edit.setText(after_arrow(name, edit.text(), change, self._travel))

    def _on_tap(self, edit: TouchEdit) -> None:
        name = self.form.name_of(edit)
        hint = shown_text(allowed_values(name, self._travel))

        def judge(text: str) -> str:
            check = check_form(self.form.texts_with(edit, text), self._travel)
            correction = corrections(check, self._travel).get(name)
            return "" if correction is None else shown_text(correction)

        self.pad_wanted.emit(PadRequest(shown_text(field_title(name)), hint, edit, judge))

    def _on_start(self) -> None:
        if self._check.parameters is not None:
            self.start_pressed.emit(self._check.parameters)

    def _on_pause(self) -> None:
        if self._snapshot is not None and self._snapshot.can_resume:
            self.resume_pressed.emit()
        else:
            self.pause_pressed.emit()

    def _propose_address(self, snapshot: Snapshot) -> None:
        """Show the address of the robot's configuration, unless the operator chose another."""
        proposed = snapshot.defaults.vna_address if snapshot.defaults else ""
        if proposed in ("", self._proposed_address):
            return
        if self.form.texts()[ADDRESS] == self._proposed_address:
            self.form.show_text(ADDRESS, proposed)
        self._proposed_address = proposed

    def _check_form(self) -> None:
        self._check = check_form(self.form.texts(), self._travel)
        self._show_problems()
        self.parameters_changed.emit(self._check.parameters)

    def _show_problems(self) -> None:
        problems = field_problems(self._check, self._travel)
        by_field = {name: shown_text(problem) for name, problem in problems.items()}
        self.form.show_problems(by_field)
        text = "\n".join(by_field.values())
        if text != self.problems.toPlainText():
            self.problems.setPlainText(text)
        self._below.setCurrentWidget(self.problems if text else self.preview)

    def _show_buttons(self) -> None:
        known = self._snapshot
        self.start.setEnabled(
            known is not None and known.can_start and self._check.parameters is not None
        )
        resume = known is not None and known.can_resume
        paused = known is not None and known.paused
        self.pause.setText(self.tr("RESUME") if paused else self.tr("PAUSE"))
        self.pause.setEnabled(resume or (known is not None and known.can_pause))
        self.notes.setEnabled(known is None or known.replay is None)

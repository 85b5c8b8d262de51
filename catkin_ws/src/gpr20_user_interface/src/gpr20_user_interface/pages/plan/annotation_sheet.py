"""Name, operator, site, position and notes of the next survey, or of one that is stored."""

from __future__ import annotations

from typing import Dict, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from gpr20_operator.plan.annotation_form import HINTS, TITLES, check_texts, texts_of
from gpr20_survey.plan.annotation import Annotation
from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.edits import Field, FieldBox, TouchEdit, TouchText
from gpr20_user_interface.widgets.keys import KeyPad
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.text_pad import TextPad
from gpr20_user_interface.widgets.widgets import new_button, set_look

NUMBERS = ("latitude", "longitude")
# More characters than any field may have, so that a text which is too long is named as such.
MAX_LENGTH = 1000
BUTTON_PX = 130
# Row, column, and how many columns.
PLACES = {
    "name": (0, 0, 2),
    "operator": (0, 2, 2),
    "site": (1, 0, 2),
    "latitude": (1, 2, 1),
    "longitude": (1, 3, 1),
    "notes": (2, 0, 4),
}


class AnnotationSheet(Overlay):
    """The fields; each opens keys on the screen when it is touched."""

    # Carries the survey, an id or the name of its folder, and its Annotation. Empty: the next.
    saved = pyqtSignal(str, object)

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._survey: Optional[str] = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.title.setWordWrap(True)
        self.problem = QLabel()
        self.problem.setWordWrap(True)
        self.text_pad = TextPad(window)
        self.number_pad = KeyPad(window)
        self.fields: Dict[str, Field] = {
            name: TouchText(name) if name == "notes" else self._line(name) for name in TITLES
        }
        self._boxes = {name: FieldBox(field) for name, field in self.fields.items()}
        self.save = new_button(self._on_save)
        self.close_button = new_button(self.hide)
        for name, box in self._boxes.items():
            box.tapped.connect(lambda name=name: self._on_tap(name))
            self.fields[name].textChanged.connect(self._check)
        self._lay_out()
        self.retranslate()

    @property
    def survey(self) -> Optional[str]:
        """The survey whose annotation is shown; empty: the next one; None: the sheet is closed."""
        return self._survey if self.isVisible() else None

    def show_annotation(self, survey: str, annotation: Annotation) -> None:
        """Open with an annotation.

        Args:
            survey: The survey's id, or the name of its folder; empty: the next one.
            annotation: What it has now.
        """
        self._survey = survey
        for name, text in texts_of(annotation).items():
            self.fields[name].setText(text)
        self.retranslate()
        self._check()
        self.open()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        if self._survey:
            title = self.tr("Notes of survey {survey}").format(survey=self._survey)
        else:
            title = self.tr("Notes of the next survey")
        self.title.setText(title)
        for name, box in self._boxes.items():
            box.title.setText(shown_text(TITLES[name]))
        self.save.setText(self.tr("SAVE"))
        self.close_button.setText(self.tr("CLOSE"))
        self._check()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        gap_px = look.px(GAP_PX)
        for layout in (self._rows, self._top, self._grid):
            layout.setSpacing(gap_px)
        self._rows.setContentsMargins(gap_px, gap_px, gap_px, gap_px)
        for button in (self.save, self.close_button):
            button.setFixedSize(look.px(BUTTON_PX), look.px(TOUCH_PX))

    def _texts(self) -> Dict[str, str]:
        return {name: field.text() for name, field in self.fields.items()}

    def _check(self) -> None:
        check = check_texts(self._texts())
        problems = {name: shown_text(message) for name, message in check.problems.items()}
        for name, box in self._boxes.items():
            box.show_problem(problems.get(name, ""))
        self.problem.setText(next(iter(problems.values()), ""))
        set_look(self.problem, "level", "wrong" if problems else "")
        self.problem.setVisible(bool(problems))
        self.save.setEnabled(check.annotation is not None)

    def _on_save(self) -> None:
        annotation = check_texts(self._texts()).annotation
        if annotation is not None:
            self.saved.emit(self._survey or "", annotation)

    def _on_tap(self, name: str) -> None:
        field = self.fields[name]

        def judge(text: str) -> str:
            problem = check_texts({**self._texts(), name: text}).problems.get(name)
            return "" if problem is None else shown_text(problem)

        title, hint = shown_text(TITLES[name]), shown_text(HINTS[name])
        if name in NUMBERS:
            # The other half of a position may still be missing.
            self.number_pad.ask(field.setText, title, hint, field.text(), judge, strict=False)
        else:
            several_lines = name == "notes"
            self.text_pad.ask(field.setText, title, hint, field.text(), judge, several_lines)

    @staticmethod
    def _line(name: str) -> TouchEdit:
        edit = TouchEdit(name)
        edit.setMaxLength(MAX_LENGTH)
        return edit

    def _lay_out(self) -> None:
        self._top = QHBoxLayout()
        self._top.addWidget(self.title, 1)
        self._top.addWidget(self.close_button)
        self._top.addWidget(self.save)
        self._grid = QGridLayout()
        for name, (row, column, columns) in PLACES.items():
            self._grid.addWidget(self._boxes[name], row, column, 1, columns)
        for column in range(4):
            self._grid.setColumnStretch(column, 1)
        self._grid.setRowStretch(2, 1)
        self._rows = QVBoxLayout(self)
        self._rows.addLayout(self._top)
        self._rows.addWidget(self.problem)
        self._rows.addLayout(self._grid, 1)

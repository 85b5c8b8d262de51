"""Operator, site, position and notes of the next survey, or of one that is stored."""

from __future__ import annotations

from typing import Dict, Optional, Union

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPlainTextEdit, QWidget

from gpr20_survey.plan.annotation import Annotation
from gpr20_user_interface.mid.annotation_form import HINTS, TITLES, check_texts, texts_of
from gpr20_user_interface.views.key_pad import DIGITS, KeyPad
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.parameter_form_view import TouchEdit
from gpr20_user_interface.views.text_pad import TextPad
from gpr20_user_interface.views.translation import shown_text
from gpr20_user_interface.views.widgets import new_button, set_look

NUMBERS = ("latitude", "longitude")
# More characters than any field may have, so that a text which is too long is named as such.
MAX_LENGTH = 1000


class TouchText(QPlainTextEdit):
    """Lines of text that report a tap; a keyboard can write in them as usual."""

    tapped = pyqtSignal()

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setTabChangesFocus(True)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger or a mouse button leaves the field."""
        super().mouseReleaseEvent(event)
        if self.rect().contains(event.pos()):
            self.tapped.emit()

    def text(self) -> str:
        """Return the text."""
        return self.toPlainText()

    def setText(self, text: str) -> None:  # noqa: N802 (as in QLineEdit)
        """Replace the text."""
        self.setPlainText(text)

    def show_problem(self, problem: str) -> None:
        """Mark the field as wrong; an empty problem as right."""
        set_look(self, "wrong", bool(problem))
        self.setToolTip(problem)


class AnnotationSheet(Overlay):
    """The fields; each opens keys on the screen when it is touched."""

    # Carries the survey, an id or the name of its folder, and its Annotation. Empty: the next.
    saved = pyqtSignal(str, object)

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._survey: Optional[str] = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.problem = QLabel()
        self.problem.setWordWrap(True)
        self.text_pad = TextPad(window)
        self.number_pad = KeyPad(window, DIGITS)
        self._labels = {name: QLabel() for name in TITLES}
        self.fields: Dict[str, Union[TouchEdit, TouchText]] = {
            name: TouchText(name) if name == "notes" else self._line(name) for name in TITLES
        }
        self.save = new_button(self._on_save)
        self.close_button = new_button(self.hide)
        for name, field in self.fields.items():
            field.tapped.connect(lambda name=name: self._on_tap(name))
            field.textChanged.connect(self._check)
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
        for name, label in self._labels.items():
            label.setText(shown_text(TITLES[name]))
        self.save.setText(self.tr("SAVE"))
        self.close_button.setText(self.tr("CLOSE"))
        self._check()

    def _texts(self) -> Dict[str, str]:
        return {name: field.text() for name, field in self.fields.items()}

    def _check(self) -> None:
        check = check_texts(self._texts())
        problems = {name: shown_text(message) for name, message in check.problems.items()}
        for name, field in self.fields.items():
            field.show_problem(problems.get(name, ""))
        self.problem.setText(next(iter(problems.values()), ""))
        set_look(self.problem, "level", "wrong" if problems else "")
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
        left = Qt.Alignment() | Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        edit.setAlignment(left)
        return edit

    def _lay_out(self) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(16, 8, 16, 8)
        grid.setSpacing(6)
        grid.addWidget(self.title, 0, 0, 1, 4)
        self._labels["notes"].setAlignment(Qt.AlignmentFlag.AlignTop)
        for row, name in ((1, "operator"), (2, "site"), (4, "notes")):
            grid.addWidget(self._labels[name], row, 0)
            grid.addWidget(self.fields[name], row, 1, 1, 3)
        for column, name in ((0, "latitude"), (2, "longitude")):
            grid.addWidget(self._labels[name], 3, column)
            grid.addWidget(self.fields[name], 3, column + 1)
        grid.addWidget(self.problem, 5, 0, 1, 4)
        buttons = QHBoxLayout()
        buttons.addWidget(self.save, 1)
        buttons.addWidget(self.close_button, 1)
        grid.addLayout(buttons, 6, 0, 1, 4)
        grid.setRowStretch(4, 1)
        grid.setColumnStretch(1, 1)
        grid.setColumnStretch(3, 1)

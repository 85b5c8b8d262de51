"""The sheet that says what will happen, and waits for a button that is held."""

from __future__ import annotations

from typing import Callable, List, Optional, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QGridLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from gpr20_operator.plan.hold_question import HoldQuestion
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button, set_look

MOST_ROWS = 7
HOLD_WIDTH_PX = 230
MARGIN_PX = 16


class HoldSheet(Overlay):
    """Shows a HoldQuestion; the button to hold is far from CANCEL.

    It lies where no other sheet has OK, CLOSE or CANCEL: a touch that comes twice never reaches
    it.

    Attributes:
        hold: The button that must be held.
        cancel: Closes the sheet.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._question: Optional[HoldQuestion] = None
        self._act: Callable[[], None] = self.hide
        self.title = QLabel()
        self.title.setObjectName("title")
        self._rows: List[Tuple[QLabel, QLabel]] = [(QLabel(), QLabel()) for _ in range(MOST_ROWS)]
        self.warning = QLabel()
        self.hold = HoldButton()
        self.cancel = new_button(self.hide)
        self._grid = QGridLayout(self)
        self._names = QGridLayout()
        self._lay_out()
        self.hold.held.connect(self._on_held)
        self.restyle()
        self.retranslate()

    @property
    def question(self) -> Optional[HoldQuestion]:
        """What is asked; None before the first time."""
        return self._question

    def ask(self, question: HoldQuestion, act: Callable[[], None]) -> None:
        """Open with a question.

        Args:
            question: What will happen.
            act: Called once the button has been held.
        """
        self._act = act
        self.show_question(question)
        self.open()

    def show_question(self, question: HoldQuestion) -> None:
        """Say the same with other words; what is held stays held."""
        if question != self._question:
            self._question = question
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.cancel.setText(self.tr("Cancel"))
        question = self._question
        if question is None:
            return
        self.title.setText(shown_text(question.title))
        self.warning.setText(shown_text(question.warning))
        self.hold.setText(shown_text(question.hold))
        for number, (name, value) in enumerate(self._rows):
            used = number < len(question.rows)
            name.setVisible(used)
            value.setVisible(used)
            if used:
                name.setText(shown_text(question.rows[number][0]))
                value.setText(shown_text(question.rows[number][1]))

    def restyle(self) -> None:
        """Take the sizes of the look."""
        px = look_of(self).px
        self._grid.setContentsMargins(*(px(MARGIN_PX),) * 4)
        self._grid.setSpacing(px(GAP_PX))
        self._names.setHorizontalSpacing(px(MARGIN_PX))
        self._grid.setColumnMinimumWidth(1, px(HOLD_WIDTH_PX))

    def _on_held(self) -> None:
        self.hide()
        self._act()

    def _lay_out(self) -> None:
        rows = self._names
        for number, (name, value) in enumerate(self._rows):
            name.setObjectName("quiet")
            value.setTextFormat(Qt.TextFormat.PlainText)
            value.setWordWrap(True)
            rows.addWidget(name, number, 0, Qt.AlignmentFlag.AlignTop)
            rows.addWidget(value, number, 1, Qt.AlignmentFlag.AlignTop)
        rows.setColumnStretch(1, 1)
        rows.setRowStretch(MOST_ROWS, 1)
        self.warning.setWordWrap(True)
        set_look(self.warning, "level", "doubtful")
        left = QVBoxLayout()
        left.addLayout(rows, 1)
        left.addWidget(self.warning)
        grid = self._grid
        grid.addWidget(self.title, 0, 0, 1, 2)
        grid.addLayout(left, 1, 0)
        right = QVBoxLayout()
        right.addStretch(1)
        self.hold.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        right.addWidget(self.hold, 2)
        right.addStretch(1)
        grid.addLayout(right, 1, 1)
        grid.addWidget(self.cancel, 2, 0, Qt.AlignmentFlag.AlignLeft)
        grid.setRowStretch(1, 1)
        grid.setColumnStretch(0, 1)

"""What is always said above the pictures: simulated or not, how the image was made, notes."""

from __future__ import annotations

from typing import Sequence

from PyQt5.QtWidgets import QLabel, QVBoxLayout, QWidget

from gpr20_analysis.sentences import limited, shown
from gpr20_common.message import Message
from gpr20_viewer.views.colours import QUIET, SIMULATED, WRONG

LISTED = 3


class StatusBar(QWidget):
    """The lines above the pictures.

    Attributes:
        banner: Says that the survey is simulated; not there for others.
        caption: How the image was made.
        problem: Why there is no image, what is wrong or doubted; hidden if nothing is.
        notes: The first notes on survey and image.
    """

    def __init__(self, simulated: bool) -> None:
        super().__init__()
        self.banner = QLabel(
            "SIMULATED: the simulated robot made this survey; nothing was measured."
        )
        self.banner.setStyleSheet(SIMULATED)
        self.banner.setVisible(simulated)
        self.caption = QLabel()
        self.problem = QLabel()
        self.problem.setStyleSheet(WRONG)
        self.problem.setWordWrap(True)
        self.problem.hide()
        self.notes = QLabel()
        self.notes.setStyleSheet(QUIET)
        self.notes.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        for label in (self.banner, self.caption, self.problem, self.notes):
            layout.addWidget(label)

    def show_problem(self, problems: Sequence[Message]) -> None:
        """Show what is wrong or doubted; nothing if the list is empty."""
        self.problem.setText("\n".join(shown(one) for one in problems))
        self.problem.setVisible(bool(problems))

    def show_notes(self, notes: Sequence[Message]) -> None:
        """Show the first notes; all of them stand in the list of notes."""
        texts = [one.sentence() for one in limited(notes, LISTED)]
        self.notes.setText(" · ".join(texts))
        self.notes.setToolTip("\n".join(one.sentence() for one in notes))
        self.notes.setVisible(bool(texts))

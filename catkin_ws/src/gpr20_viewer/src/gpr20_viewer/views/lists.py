"""Lists that are only read: notes, keys."""

from __future__ import annotations

from typing import Sequence

from PyQt5.QtWidgets import QLabel, QScrollArea

from gpr20_analysis.sentences import shown
from gpr20_common.message import Message
from gpr20_viewer.views.keys import KEYS


class ReadList(QScrollArea):
    """Lines of text that can be scrolled.

    Attributes:
        text: The lines.
    """

    def __init__(self) -> None:
        super().__init__()
        self.text = QLabel()
        self.text.setWordWrap(True)
        self.text.setMargin(6)
        self.setWidget(self.text)
        self.setWidgetResizable(True)


class NotesList(ReadList):
    """Everything that is noted about survey and image."""

    def __init__(self) -> None:
        super().__init__()

    def show_notes(self, notes: Sequence[Message]) -> None:
        """Show notes."""
        lines = [shown(one) for one in notes]
        self.text.setText("\n\n".join(lines) or "nothing is noted")


class KeysList(ReadList):
    """What each key does."""

    def __init__(self) -> None:
        super().__init__()
        rows = [f"{key.shown}\t{key.effect.sentence()}" for key in KEYS]
        self.text.setText("\n".join(rows))

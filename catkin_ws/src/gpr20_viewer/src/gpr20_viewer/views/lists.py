"""Lists that are only read: notes, keys."""

from __future__ import annotations

from typing import Sequence

from PyQt5.QtWidgets import QLabel, QScrollArea

from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import Catalogue
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

    def __init__(self, catalogue: Catalogue) -> None:
        super().__init__()
        self._catalogue = catalogue

    def show_notes(self, notes: Sequence[Message]) -> None:
        """Show notes."""
        lines = [shown(one, self._catalogue) for one in notes]
        self.text.setText("\n\n".join(lines) or self._catalogue.tr("nothing is noted"))


class KeysList(ReadList):
    """What each key does."""

    def __init__(self, catalogue: Catalogue) -> None:
        super().__init__()
        rows = [f"{key.shown}\t{catalogue.text(key.effect)}" for key in KEYS]
        self.text.setText("\n".join(rows))

"""The list of what is wrong with the robot, and what to do about it."""

from __future__ import annotations

from typing import Dict, List, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QFrame, QGridLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from gpr20_doctor.mid.finding import Finding, Level
from gpr20_user_interface.views.look import GAP_PX
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text
from gpr20_user_interface.views.widgets import set_look

LOOKS: Dict[Level, str] = {
    Level.OK: "good",
    Level.NOTE: "",
    Level.UNKNOWN: "",
    Level.WARNING: "doubtful",
    Level.FAULT: "bad",
}


class DoctorList(TranslatedWidget):
    """One line per finding, the worst first: its level, its sentence, and the remedy below."""

    def __init__(self) -> None:
        super().__init__()
        self._findings: Tuple[Finding, ...] = ()
        self._rows: List[Tuple[QLabel, QLabel]] = []
        self._list = QWidget()
        self._grid = QGridLayout(self._list)
        self._grid.setContentsMargins(0, 0, GAP_PX, 0)
        self._grid.setSpacing(GAP_PX)
        self._grid.setColumnStretch(1, 1)
        area = QScrollArea()
        area.setWidget(self._list)
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(area)

    @property
    def texts(self) -> List[str]:
        """The lines that are shown."""
        rows = self._rows[: len(self._findings)]
        return [f"{level.text()}: {text.text()}" for level, text in rows]

    def show_findings(self, findings: Tuple[Finding, ...]) -> None:
        """Show findings; most times they are the last ones."""
        if findings != self._findings:
            self._findings = findings
            self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        while len(self._rows) < len(self._findings):
            self._add_row()
        for number, (level, text) in enumerate(self._rows):
            used = number < len(self._findings)
            level.setVisible(used)
            text.setVisible(used)
            if used:
                self._show(self._findings[number], level, text)

    def _add_row(self) -> None:
        level, text = QLabel(), QLabel()
        level.setAlignment(Qt.AlignmentFlag.AlignCenter)
        text.setWordWrap(True)
        row = len(self._rows)
        self._grid.addWidget(level, row, 0, Qt.AlignmentFlag.AlignTop)
        self._grid.addWidget(text, row, 1)
        self._grid.setRowStretch(row, 0)
        self._grid.setRowStretch(row + 1, 1)
        self._rows.append((level, text))

    @staticmethod
    def _show(finding: Finding, level: QLabel, text: QLabel) -> None:
        # First: the width of the text counts with the padding of its look.
        set_look(level, "level", LOOKS[finding.level])
        level.setText(shown_text(finding.level.title))
        lines = [finding.text] if finding.remedy is None else [finding.text, finding.remedy]
        text.setText("\n".join(map(shown_text, lines)))

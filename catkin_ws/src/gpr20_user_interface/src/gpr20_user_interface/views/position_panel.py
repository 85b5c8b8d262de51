"""Where the antennas are and where they go."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QGridLayout, QLabel, QWidget

from gpr20_user_interface.mid.events import CurrentPosition, TargetPosition
from gpr20_user_interface.views.translation import TranslatedWidget

UNKNOWN = "—"
HEIGHT_COLUMN = 4


class PositionPanel(TranslatedWidget):
    """X, Y and Z, now and as the target, and the height over the ground."""

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self._cells: Dict[Tuple[str, int], QLabel] = {}
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        self._titles = [self._label("") for _ in range(HEIGHT_COLUMN)]
        for column, label in enumerate(self._titles, 1):
            label.setObjectName("quiet")
            grid.addWidget(label, 0, column)
        self._rows = [QLabel(), QLabel()]
        for row, (name, columns) in enumerate((("current", HEIGHT_COLUMN), ("target", 3)), 1):
            grid.addWidget(self._rows[row - 1], row, 0)
            for column in range(1, columns + 1):
                self._cells[name, column] = self._label(UNKNOWN)
                self._cells[name, column].setObjectName("figure")
                grid.addWidget(self._cells[name, column], row, column)
        self.retranslate()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        titles = (self.tr("X mm"), self.tr("Y mm"), self.tr("Z °"), self.tr("Height m"))
        for label, title in zip(self._titles, titles):
            label.setText(title)
        for label, title in zip(self._rows, (self.tr("Now"), self.tr("Target"))):
            label.setText(title)

    def cell(self, row: str, column: int) -> str:
        """Return the text of a cell: row "current" or "target", column from 1."""
        return self._cells[row, column].text()

    def show_current(self, position: Optional[CurrentPosition]) -> None:
        """Show where the axes are; None if that is not known now."""
        self._show("current", position)

    def show_target(self, position: Optional[TargetPosition]) -> None:
        """Show where the axes go; None if nowhere."""
        self._show("target", position)

    def show_height(self, height_m: Optional[float]) -> None:
        """Show the height [m]; None if it is not known now."""
        self._cells["current", HEIGHT_COLUMN].setText(
            UNKNOWN if height_m is None else f"{height_m:.3f}"
        )

    def _show(self, row: str, position: object) -> None:
        for column, name in enumerate(("x_mm", "y_mm", "z_deg"), 1):
            text = UNKNOWN if position is None else f"{getattr(position, name):.2f}"
            self._cells[row, column].setText(text)

    @staticmethod
    def _label(text: str) -> QLabel:
        label = QLabel(text)
        flags = Qt.Alignment() | Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        label.setAlignment(flags)
        return label

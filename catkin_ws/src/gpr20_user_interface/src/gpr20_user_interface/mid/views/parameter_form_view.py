"""The fields of the parameters."""

from __future__ import annotations

from typing import Dict, Mapping, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QLabel, QLineEdit, QSizePolicy, QWidget

from gpr20_user_interface.mid.parameter_form import FIELDS
from gpr20_user_interface.mid.views.style import set_wrong

# More characters than any parameter needs.
MAX_LENGTH = 40


class ParameterFormView(QWidget):
    """Shows one field per parameter and tells when a text changes."""

    changed = pyqtSignal()

    def __init__(self, parent: Optional[QWidget] = None) -> None:
        super().__init__(parent)
        self._edits: Dict[str, QLineEdit] = {}
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(5)
        for column, title in enumerate((self.tr("Start"), self.tr("Stop"), self.tr("Points")), 1):
            grid.addWidget(QLabel(title), 0, column)
        rows = (
            (self.tr("MHz"), ("start_frequency_hz", "stop_frequency_hz", "frequency_points")),
            (self.tr("X mm"), ("x_start_mm", "x_stop_mm", "x_points")),
            (self.tr("Y mm"), ("y_start_mm", "y_stop_mm", "y_points")),
        )
        for row, (title, names) in enumerate(rows, 1):
            grid.addWidget(QLabel(title), row, 0)
            for column, name in enumerate(names, 1):
                grid.addWidget(self._new_edit(name), row, column)
        self._add_wide(grid, len(rows) + 1, self.tr("VNA"), "vna_address")
        self._add_wide(grid, len(rows) + 2, self.tr("Z °"), "polarizations_deg")

    def texts(self) -> Dict[str, str]:
        """Return the text of every field by the name of its parameter."""
        return {name: edit.text() for name, edit in self._edits.items()}

    def edit(self, name: str) -> QLineEdit:
        """Return the field of a parameter."""
        return self._edits[name]

    def show_problems(self, problems: Mapping[str, str]) -> None:
        """Mark the fields that are wrong; each says what is allowed when it is pointed at."""
        for name, edit in self._edits.items():
            set_wrong(edit, name in problems)
            edit.setToolTip(problems.get(name, ""))

    def _add_wide(self, grid: QGridLayout, row: int, title: str, name: str) -> None:
        grid.addWidget(QLabel(title), row, 0)
        grid.addWidget(self._new_edit(name), row, 1, 1, 3)

    def _new_edit(self, name: str) -> QLineEdit:
        default = next(field.default for field in FIELDS if field.name == name)
        edit = QLineEdit(default)
        edit.setObjectName(name)
        edit.setMaxLength(MAX_LENGTH)
        edit.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        edit.textChanged.connect(self._on_text_changed)
        self._edits[name] = edit
        return edit

    def _on_text_changed(self, _text: str) -> None:
        self.changed.emit()

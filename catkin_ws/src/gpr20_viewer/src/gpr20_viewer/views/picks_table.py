"""The list of picks, their notes, and what can be done with them."""

from __future__ import annotations

from typing import Optional, Sequence

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from gpr20_analysis.dataset import MM_PER_M
from gpr20_viewer.picks import NO_CLEARANCE_BY_PICKS, Pick, PickEditor
from gpr20_viewer.views.colours import QUIET, SMALL, WRONG

NOTE_COLUMN = 5
READ_ONLY = Qt.ItemFlags() | Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
NOTE_PX = 130


class PicksTable(QWidget):
    """Shows picks; the signals are requests of the analyst.

    Attributes:
        chosen: A pick was selected: its name.
        noted: A note was written: name of the pick, note.
    """

    chosen = pyqtSignal(str)
    noted = pyqtSignal(str, str)

    def __init__(self) -> None:
        super().__init__()
        self.notice = QLabel(NO_CLEARANCE_BY_PICKS.sentence())
        self.notice.setWordWrap(True)
        self.state = QLabel()
        self.state.setWordWrap(True)
        self.table = QTableWidget(0, 8)
        self.table.setHorizontalHeaderLabels(
            [
                "",
                "x mm",
                "y mm",
                "depth mm",
                "rotation",
                "note",
                "permittivity",
                "level dB",
            ]
        )
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.verticalHeader().hide()
        self.table.setStyleSheet(SMALL)
        self.pick_button = QPushButton("Pick")
        self.undo_button = QPushButton("Undo")
        self.redo_button = QPushButton("Redo")
        self.delete_button = QPushButton("Delete")
        self.export_button = QPushButton("Export")
        buttons = QHBoxLayout()
        for button in (
            self.pick_button, self.undo_button, self.redo_button, self.delete_button,
            self.export_button,
        ):  # fmt: skip
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            button.setMinimumWidth(20)
            buttons.addWidget(button)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.addWidget(self.notice)
        layout.addWidget(self.table, 1)
        layout.addLayout(buttons)
        layout.addWidget(self.state)
        self.table.itemSelectionChanged.connect(self._selected)
        self.table.cellChanged.connect(self._edited)

    @property
    def selected(self) -> Optional[str]:
        """Name of the selected pick; None: none is selected."""
        rows = self.table.selectionModel().selectedRows()
        return self.table.item(rows[0].row(), 0).text() if rows else None

    def show_picks(self, editor: PickEditor) -> None:
        """Show the picks; the selection stays."""
        selected = self.selected
        self.table.blockSignals(True)
        self.table.setRowCount(len(editor.picks))
        for row, pick in enumerate(editor.picks):
            for column, text in enumerate(self._texts(pick)):
                item = QTableWidgetItem(text)
                if column != NOTE_COLUMN:
                    item.setFlags(READ_ONLY)
                self.table.setItem(row, column, item)
        self.table.clearSelection()
        self.table.resizeColumnsToContents()
        self.table.setColumnWidth(NOTE_COLUMN, max(NOTE_PX, self.table.columnWidth(NOTE_COLUMN)))
        names = [one.id for one in editor.picks]
        if selected in names:
            self.table.selectRow(names.index(selected))
        self.table.blockSignals(False)
        self.undo_button.setEnabled(editor.can_undo)
        self.redo_button.setEnabled(editor.can_redo)

    def select(self, name: str) -> None:
        """Select a pick without saying so."""
        self.table.blockSignals(True)
        for row in range(self.table.rowCount()):
            if self.table.item(row, 0).text() == name:
                self.table.selectRow(row)
        self.table.blockSignals(False)

    def show_state(self, text: str, wrong: bool) -> None:
        """Show where the picks are stored, or why they are not."""
        self.state.setText(text)
        self.state.setStyleSheet(WRONG if wrong else QUIET)

    def _texts(self, pick: Pick) -> Sequence[str]:
        turn_deg = pick.polarization_deg
        combined = "combination"
        return (
            pick.id,
            *(f"{one * MM_PER_M:.0f}" for one in (pick.x_m, pick.y_m, pick.depth_m)),
            combined if turn_deg is None else f"{turn_deg:g}°",
            pick.note,
            f"{pick.permittivity:.3g}",
            "" if pick.level_db is None else f"{pick.level_db:.1f}",
        )

    def _selected(self) -> None:
        if self.selected is not None:
            self.chosen.emit(self.selected)

    def _edited(self, row: int, column: int) -> None:
        if column == NOTE_COLUMN:
            self.noted.emit(self.table.item(row, 0).text(), self.table.item(row, column).text())

"""The list of candidates in the image that is shown."""

from __future__ import annotations

from typing import List, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from gpr20_analysis.candidates.table import candidate_heading, candidate_row, places_sentence
from gpr20_analysis.sentences import ENGLISH, shown
from gpr20_survey.results.candidates import NO_CLEARANCE, CandidateList
from gpr20_viewer.views.colours import QUIET, SMALL


class CandidatesTable(QWidget):
    """Shows candidates.

    Attributes:
        chosen: A candidate was selected: its name.
        searched: Whether candidates are searched in each image.
    """

    chosen = pyqtSignal(str)

    def __init__(self) -> None:
        super().__init__()
        self.searched = QCheckBox("search candidates in each image")
        self.notice = QLabel(NO_CLEARANCE.sentence())
        self.notice.setWordWrap(True)
        self.notes = QLabel()
        self.notes.setStyleSheet(QUIET)
        self.notes.setWordWrap(True)
        titles = candidate_heading(ENGLISH)
        self.table = QTableWidget(0, len(titles))
        self.table.setHorizontalHeaderLabels(titles)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.verticalHeader().hide()
        self.table.horizontalHeader().setStretchLastSection(True)
        self.table.setStyleSheet(SMALL)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        for widget in (self.searched, self.notice, self.notes):
            layout.addWidget(widget)
        layout.addWidget(self.table, 1)
        self.table.itemSelectionChanged.connect(self._selected)

    def show_candidates(self, found: Optional[CandidateList]) -> None:
        """Show candidates; None: none were searched.

        Args:
            found: The candidates.
            source: Where the permittivity came from that gave their depths.
        """
        listed = () if found is None else found.candidates
        self.table.blockSignals(True)
        self.table.setRowCount(len(listed))
        for row, one in enumerate(listed):
            for column, text in enumerate(candidate_row(one, ENGLISH)):
                self.table.setItem(row, column, QTableWidgetItem(text))
        self.table.clearSelection()
        self.table.resizeColumnsToContents()
        self.table.blockSignals(False)
        self.notes.setText("\n".join(self._notes(found)))

    def _notes(self, found: Optional[CandidateList]) -> List[str]:
        if found is None:
            return ["No search was made for the image that is shown."]
        messages = [places_sentence(found), *found.notes]
        return [shown(one) for one in messages]

    def _selected(self) -> None:
        rows = self.table.selectionModel().selectedRows()
        if rows:
            self.chosen.emit(self.table.item(rows[0].row(), 0).text())

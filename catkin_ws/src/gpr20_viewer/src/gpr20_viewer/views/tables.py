"""The lists of places beside the pictures: candidates, and picks with their file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Callable, Dict, Optional, Sequence

import pyqtgraph
from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gpr20_analysis.candidates.table import candidate_table, places_sentence, weaker_sentence
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.sentences import shown
from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.message import Message
from gpr20_survey.results.candidates import NO_CLEARANCE, CandidateList
from gpr20_viewer.picks import NO_CLEARANCE_BY_PICKS, Pick, PickRefusedError
from gpr20_viewer.picks_file import PicksFile

QUIET = "color: #444444; font-size: 11px;"
WRONG = "background: #ffe3e3; color: #8f0000; font-weight: bold; padding: 3px;"
NAME, NOTE = "id", "note"


class PlaceTable(pyqtgraph.TableWidget):
    """Rows of texts, of which the first is the name of a place.

    Attributes:
        chosen: A row was selected: its name.
    """

    chosen = pyqtSignal(str)

    def __init__(self) -> None:
        super().__init__(editable=False, sortable=False)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.verticalHeader().hide()
        # A list that it stores says neither that it is simulated nor that it is no clearance.
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)
        self.setStyleSheet("font-size: 11px;")
        self.itemSelectionChanged.connect(self._selected)

    @property
    def selected(self) -> Optional[str]:
        """Name of the selected row; None: none is selected."""
        rows = self.selectionModel().selectedRows()
        return self.item(rows[0].row(), 0).text() if rows else None

    def show_rows(self, rows: Sequence[Dict[str, str]], selected: Optional[str] = None) -> None:
        """Show rows, and select one without a signal; None: the one that is selected now."""
        selected = selected or self.selected
        self.blockSignals(True)
        self.setData(list(rows))
        self.clearSelection()
        names = [next(iter(one.values())) for one in rows]
        if selected in names:
            self.selectRow(names.index(selected))
        self.blockSignals(False)

    def _selected(self) -> None:
        if self.selected is not None:
            self.chosen.emit(self.selected)


class CandidatesTab(QWidget):
    """Shows the places to check, and the weaker echoes when they are asked for.

    Attributes:
        table: The list.
        weaker: Shows the weaker echoes, or hides them again.
    """

    def __init__(self) -> None:
        super().__init__()
        self._found: Optional[CandidateList] = None
        self.notice, self.notes = _label(NO_CLEARANCE.sentence()), _label("", QUIET)
        self.table, self.weaker = PlaceTable(), QCheckBox()
        self.weaker.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.weaker.toggled.connect(self._show_rows)
        _stack(self, self.notice, self.notes, self.table, self.weaker)

    def show_candidates(self, found: CandidateList) -> None:
        """Show the list of the image that is shown."""
        self._found = found
        self.notes.setText("\n".join(map(shown, (places_sentence(found), *found.notes))))
        self.weaker.setText(shown(weaker_sentence(found)))
        self.weaker.setVisible(found.weaker > 0)
        self._show_rows()

    def _show_rows(self) -> None:
        found = self._found
        if found is not None:
            listed = found.candidates if self.weaker.isChecked() else found.shown()
            titles, *rows = candidate_table(found, listed)
            self.table.show_rows([dict(zip(titles, one)) for one in rows])


class PicksTab(QWidget):
    """Edits and shows the picks of a survey; each change is stored at once.

    Args:
        file: Where they are stored.
        author: Who picks; may be empty.
        now: Returns the time, ISO 8601, UTC.
        choose_export: Asks for the file to export to; None: a dialog does.

    Attributes:
        changed: The picks have changed.
        pick_wanted: The analyst wants to pick the place of the cursor.
        editor: The picks.
        table: The list.
        notes: What is noted about the stored ones.
        is_unsaved: Whether the last change could not be stored.

    Raises:
        PicksFileError: The stored picks are damaged or of another survey.
        OSError: They cannot be read.
    """

    changed = pyqtSignal()
    pick_wanted = pyqtSignal()

    def __init__(
        self,
        file: PicksFile,
        author: str,
        now: Callable[[], str],
        choose_export: Optional[Callable[[], Optional[Path]]] = None,
    ) -> None:
        super().__init__()
        self._file, self._author, self._now = file, author, now
        self._choose_export = choose_export or self._choose_in_dialog
        self.editor, self.notes = file.load()
        self.is_unsaved = False
        self.table, self.notice = PlaceTable(), _label(NO_CLEARANCE_BY_PICKS.sentence())
        self.state = _label("")
        buttons = QHBoxLayout()
        for text, act in (
            ("Pick", self.pick_wanted.emit),
            ("Undo", self.undo),
            ("Delete", self.delete_selected),
            ("Export", self.export),
        ):
            button = QPushButton(text)
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            button.setMinimumWidth(20)
            button.clicked.connect(lambda _checked, act=act: act())
            buttons.addWidget(button)
        layout = _stack(self, self.notice, self.table)
        layout.addLayout(buttons)
        layout.addWidget(self.state)
        self.table.cellChanged.connect(self._edited)
        self._show_rows()
        self._say_stored()

    def add(self, pick: Pick) -> None:
        """Pick a place, by this author and now; say so if one is there already."""
        try:
            added = self.editor.add(replace(pick, author=self._author, time=self._now()))
        except PickRefusedError as error:
            self.say(error.message, self.is_unsaved)
            return
        self._store(added.id)

    def delete_selected(self) -> None:
        """Delete the selected pick."""
        if self.table.selected is not None:
            self.editor.remove(self.table.selected)
            self._store()

    def undo(self) -> None:
        """Take the last change back."""
        self.editor.undo()
        self._store()

    def export(self) -> None:
        """Write the picks to a file that the analyst names."""
        path = self._choose_export()
        if path is None:
            return
        try:
            self._file.export(self.editor, path)
        except Gpr20Error as error:
            self.say(error.message, wrong=True)
        else:
            self.say(Message("Exported to {path}", path=path), wrong=self.is_unsaved)

    def say(self, message: Message, wrong: bool) -> None:
        """Show where the picks are stored, or why they are not."""
        self.state.setText(shown(message))
        self.state.setStyleSheet(WRONG if wrong else QUIET)

    def _edited(self, row: int, column: int) -> None:
        name, note = (self.table.item(row, one).text() for one in (0, column))
        self.editor.set_note(name, note)
        self._store()

    def _store(self, selected: Optional[str] = None) -> None:
        self._show_rows(selected)
        try:
            self._file.save(self.editor)
        except Gpr20Error as error:
            self._say_unsaved(error.message)
        except OSError as error:
            reason = os_reason(error)
            self._say_unsaved(Message("{file}: {reason}", file=self._file.path, reason=reason))
        else:
            self.is_unsaved = False
            self._say_stored()
        self.changed.emit()

    def _say_unsaved(self, reason: Message) -> None:
        self.is_unsaved = True
        self.say(Message("NOT SAVED: {reason}", reason=reason), wrong=True)

    def _say_stored(self) -> None:
        self.say(Message("Picks are stored in {path}", path=self._file.path), wrong=False)

    def _show_rows(self, selected: Optional[str] = None) -> None:
        rows = [_row(one) for one in self.editor.picks]
        self.table.show_rows(rows, selected)
        self.table.blockSignals(True)
        for row, texts in enumerate(rows):
            self.table.item(row, list(texts).index(NOTE)).setEditable(True)
        self.table.blockSignals(False)

    def _choose_in_dialog(self) -> Optional[Path]:
        start = self._file.path.with_name("picks.csv")
        name, _kind = QFileDialog.getSaveFileName(self, "Export", str(start), "CSV (*.csv)")
        return Path(name) if name else None


def _row(pick: Pick) -> Dict[str, str]:
    level_db = pick.level_db
    return {
        NAME: pick.id,
        "x mm": f"{pick.x_m * MM_PER_M:.0f}",
        "y mm": f"{pick.y_m * MM_PER_M:.0f}",
        "depth mm": f"{pick.depth_m * MM_PER_M:.0f}",
        "rotation": f"{pick.polarization_deg:g}°",
        NOTE: pick.note,
        "permittivity": f"{pick.permittivity:.3g}",
        "level dB": "" if level_db is None else f"{round(level_db, 1) + 0.0:.1f}",
    }


def _label(text: str, style: str = "") -> QLabel:
    label = QLabel(text)
    label.setWordWrap(True)
    label.setStyleSheet(style)
    return label


def _stack(parent: QWidget, *widgets: QWidget) -> QVBoxLayout:
    layout = QVBoxLayout(parent)
    layout.setContentsMargins(4, 4, 4, 4)
    for widget in widgets:
        layout.addWidget(widget, int(isinstance(widget, PlaceTable)))
    return layout

"""The picks of the window: each change is stored at once."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, List, Optional, Tuple

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QFileDialog

from gpr20_analysis.sentences import shown
from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.message import Message
from gpr20_viewer.picks import Pick, PickEditor, PickRefusedError
from gpr20_viewer.picks_file import PicksFile
from gpr20_viewer.positions import Place
from gpr20_viewer.views.picks_table import PicksTable


class PickDesk(QObject):
    """Edits, stores and shows the picks of a survey.

    Args:
        file: Where they are stored.
        author: Who picks; may be empty.
        now: Returns the time, ISO 8601, UTC.
        choose_export: Asks for the file to export to; None: do not export.

    Attributes:
        changed: The picks have changed.
        editor: The picks.
        table: The list that shows them.
        notes: What is noted about the stored ones.
        is_unsaved: Whether the last change could not be stored.

    Raises:
        PicksFileError: The stored picks are damaged or of another survey.
        OSError: They cannot be read.
    """

    changed = pyqtSignal()

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
        self.editor: PickEditor
        self.notes: List[Message]
        self.editor, self.notes = file.load()
        self.is_unsaved = False
        self.table = PicksTable()
        self.table.undo_button.clicked.connect(lambda: self.undo())
        self.table.redo_button.clicked.connect(lambda: self.redo())
        self.table.delete_button.clicked.connect(lambda: self.delete_selected())
        self.table.export_button.clicked.connect(lambda: self.export())
        self.table.noted.connect(self.set_note)
        self.table.show_picks(self.editor)
        path = str(file.path)
        self.table.show_state(f"Picks are stored in {path}", wrong=False)

    def add(
        self,
        place: Place,
        polarization_deg: Optional[float],
        permittivity: Tuple[float, str],
        level_db: Optional[float],
    ) -> None:
        """Pick a place; say so if one is there already."""
        value, source = permittivity
        pick = Pick(
            "", place.x_m, place.y_m, place.depth_m, polarization_deg, value, source,
            level_db, "", self._author, self._now(),
        )  # fmt: skip
        try:
            added = self.editor.add(pick)
        except PickRefusedError as error:
            self.refuse(error.message)
            return
        self._store()
        self.table.select(added.id)

    def refuse(self, reason: Message) -> None:
        """Say why nothing was picked."""
        self._say(reason, wrong=self.is_unsaved)

    def set_note(self, name: str, note: str) -> None:
        """Write a note to a pick."""
        try:
            self.editor.set_note(name, note)
        except PickRefusedError as error:
            self.table.show_picks(self.editor)
            self._say(error.message, wrong=True)
            return
        self._store()

    def delete_selected(self) -> None:
        """Delete the selected pick."""
        if self.table.selected is not None:
            self.editor.remove(self.table.selected)
            self._store()

    def undo(self) -> None:
        """Take the last change back."""
        if self.editor.can_undo:
            self.editor.undo()
            self._store()

    def redo(self) -> None:
        """Make the undone change again."""
        if self.editor.can_redo:
            self.editor.redo()
            self._store()

    def export(self) -> None:
        """Write the picks to a file that the analyst names."""
        path = self._choose_export()
        if path is None:
            return
        try:
            self._file.export(self.editor, path)
        except Gpr20Error as error:
            self._say(error.message, wrong=True)
        else:
            self._say(Message("Exported to {path}", path=path), wrong=self.is_unsaved)

    def _store(self) -> None:
        self.table.show_picks(self.editor)
        try:
            self._file.save(self.editor)
        except Gpr20Error as error:
            self._fail(error.message)
        except OSError as error:
            self._fail(Message("{file}: {reason}", file=self._file.path, reason=os_reason(error)))
        else:
            self.is_unsaved = False
            path = self._file.path
            self._say(Message("Picks are stored in {path}", path=path), wrong=False)
        self.changed.emit()

    def _fail(self, reason: Message) -> None:
        self.is_unsaved = True
        self._say(Message("NOT SAVED: {reason}", reason=reason), wrong=True)

    def _say(self, message: Message, wrong: bool) -> None:
        self.table.show_state(shown(message), wrong)

    def _choose_in_dialog(self) -> Optional[Path]:
        start = self._file.path.with_name("picks.csv")
        title = "Export"
        name, _kind = QFileDialog.getSaveFileName(
            self.table, title, str(start), "CSV (*.csv);;JSON (*.json)"
        )
        return Path(name) if name else None

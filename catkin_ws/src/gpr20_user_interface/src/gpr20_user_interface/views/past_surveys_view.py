"""The list of past surveys: how each ended; resume one, look at one."""

from __future__ import annotations

from typing import Optional, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtGui import QShowEvent
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
)

from gpr20_user_interface.mid.past_surveys import PastSurvey, PastSurveys, Verdict
from gpr20_user_interface.views.look import TOUCH_PX, look_of
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text
from gpr20_user_interface.views.widgets import new_button

WHEN, VERDICT, TRACES = range(3)


class PastSurveysView(TranslatedWidget):
    """Shows PastSurveys and emits the operator's requests."""

    # Empty: the first page. Else the folder before which the next page begins.
    page_requested = pyqtSignal(str)
    # The name of a folder.
    open_requested = pyqtSignal(str)
    resume_requested = pyqtSignal(str)
    notes_requested = pyqtSignal(str)
    # A PastSurvey.
    candidates_requested = pyqtSignal(object)

    def __init__(self, surveys: PastSurveys) -> None:
        super().__init__()
        self._surveys = surveys
        self._revision = -1
        # As in the rows of the table.
        self._shown: Tuple[PastSurvey, ...] = ()
        self.table = QTableWidget(0, 3)
        self.details = QLabel()
        self.open = new_button(self._on_open)
        self.resume = new_button(self._on_resume)
        self.notes = new_button(self._on_notes)
        self.candidates = new_button(self._on_candidates)
        self.older = new_button(lambda: self.page_requested.emit(self._surveys.next_before))
        self.again = new_button(lambda: self.page_requested.emit(""))
        self._lay_out()
        self.table.itemSelectionChanged.connect(self._show_choice)
        self.retranslate()

    @property
    def chosen(self) -> Optional[PastSurvey]:
        """The survey that the operator touched."""
        rows = {index.row() for index in self.table.selectedIndexes()}
        return self._shown[rows.pop()] if rows and max(rows) < len(self._shown) else None

    def refresh(self) -> None:
        """Show the list if it has changed; request it again if it is visible and outdated."""
        if self._surveys.outdated and self.isVisible():
            self._ask_again()
        if self._surveys.revision != self._revision:
            self._revision = self._surveys.revision
            self._show_list()

    def _ask_again(self) -> None:
        self._surveys.outdated = False
        if not self._surveys.replay:
            self.page_requested.emit("")

    def _show_list(self) -> None:
        # The choice stays, wherever its survey is in the new list.
        chosen = self.chosen
        self._shown = self._surveys.surveys
        self.table.setRowCount(len(self._shown))
        for row, survey in enumerate(self._shown):
            self._show_row(row, survey)
            if chosen is not None and survey.folder == chosen.folder:
                self.table.selectRow(row)
        self._show_choice()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Request the list whenever the tab is opened."""
        super().showEvent(event)
        self._ask_again()

    def _show_row(self, row: int, survey: PastSurvey) -> None:
        counted = f"{survey.stored_traces} / {survey.planned_traces}"
        texts = {
            WHEN: survey.day_and_time,
            VERDICT: self._word(survey),
            TRACES: counted if survey.problem is None else "—",
        }
        for column, text in texts.items():
            self.table.setItem(row, column, QTableWidgetItem(text))

    def _word(self, survey: PastSurvey) -> str:
        word = {
            Verdict.COMPLETE: self.tr("complete"),
            Verdict.INCOMPLETE: self.tr("INCOMPLETE"),
            Verdict.RUNNING: self.tr("running"),
            Verdict.UNREADABLE: self.tr("CANNOT BE READ"),
        }[self._surveys.verdict(survey)]
        # Not inside an f-string, where xgettext finds no text.
        simulated = self.tr("simulated")
        return f"{word} ({simulated})" if survey.simulated else word

    def _show_choice(self) -> None:
        chosen = self.chosen
        self.open.setEnabled(chosen is not None and self._surveys.can_open(chosen))
        self.resume.setEnabled(chosen is not None and self._surveys.can_resume(chosen))
        self.notes.setEnabled(chosen is not None and chosen.problem is None)
        self.candidates.setEnabled(chosen is not None and self._surveys.can_search(chosen))
        self.older.setEnabled(self._surveys.more and not self._surveys.replay)
        self.again.setEnabled(not self._surveys.replay)
        if self._surveys.problem is not None:
            text = shown_text(self._surveys.problem)
        elif chosen is None:
            text = self.tr("Touch a survey.")
        else:
            text = f"{chosen.folder}: {self._sentence(chosen)}"
        self.details.setText(text)

    def _sentence(self, survey: PastSurvey) -> str:
        if self._surveys.verdict(survey) is Verdict.RUNNING:
            return self.tr("Survey in progress.")
        message = survey.problem or survey.verdict
        return (
            self.tr("The survey did not end properly.") if message is None else shown_text(message)
        )

    def _on_open(self) -> None:
        if self.chosen is not None:
            self.open_requested.emit(self.chosen.folder)

    def _on_resume(self) -> None:
        if self.chosen is not None:
            self.resume_requested.emit(self.chosen.folder)

    def _on_notes(self) -> None:
        if self.chosen is not None:
            self.notes_requested.emit(self.chosen.folder)

    def _on_candidates(self) -> None:
        if self.chosen is not None:
            self.candidates_requested.emit(self.chosen)

    def restyle(self) -> None:
        """Take the sizes of the look."""
        self.table.verticalHeader().setDefaultSectionSize(look_of(self).px(TOUCH_PX))

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        titles = [self.tr("Started (UTC)"), self.tr("Coverage"), self.tr("Traces")]
        self.table.setHorizontalHeaderLabels(titles)
        self.open.setText(self.tr("Show in RADAR"))
        self.resume.setText(self.tr("Resume"))
        self.notes.setText(self.tr("Notes"))
        self.candidates.setText(self.tr("Candidates"))
        self.older.setText(self.tr("Older"))
        self.again.setText(self.tr("Refresh"))
        self._show_list()

    def _lay_out(self) -> None:
        table = self.table
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        table.verticalHeader().hide()
        table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        table.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.details.setWordWrap(True)
        self.details.setTextFormat(Qt.TextFormat.PlainText)
        buttons = QHBoxLayout()
        for button in (
            self.open,
            self.resume,
            self.notes,
            self.candidates,
            self.older,
            self.again,
        ):
            buttons.addWidget(button)
        column = QVBoxLayout(self)
        column.setContentsMargins(4, 4, 4, 4)
        column.setSpacing(4)
        column.addWidget(table, 1)
        column.addWidget(self.details)
        column.addLayout(buttons)

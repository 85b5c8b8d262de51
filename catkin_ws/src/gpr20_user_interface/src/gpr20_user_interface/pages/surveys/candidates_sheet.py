"""The candidates of a stored survey: search, progress and the list."""

from __future__ import annotations

from typing import Callable, List

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QGridLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QProgressBar,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from gpr20_operator.jobs.search import (
    PERMITTIVITY_RANGE,
    CandidateSearch,
    SearchState,
    check_permittivity,
)
from gpr20_operator.plan.spec import Keys
from gpr20_survey.no_clearance import NO_CLEARANCE
from gpr20_survey.results.candidates import Candidate
from gpr20_survey.results.hiding_map import ONLY_THIS
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.look.look import look_of
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.edits import TouchEdit
from gpr20_user_interface.widgets.keys import Pad
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button

NONE = "—"
LONGEST_REMARK = 220
# There is no list beside it, which would need the room.
LONGEST_PROBLEM = 500
# Nothing in a row is touched.
ROW_PX = 40


class CandidatesSheet(Overlay):
    """Shows a CandidateSearch; the sentence that it is no clearance is always visible.

    Args:
        window: The window that it covers.
        search: The search.
        language: Returns the code of the window's language.
    """

    def __init__(
        self, window: QWidget, search: CandidateSearch, language: Callable[[], str]
    ) -> None:
        super().__init__(window)
        self.search = search
        self._language = language
        self._shown: object = None
        self.title = QLabel()
        self.title.setObjectName("title")
        self.simulated = QLabel()
        self.simulated.setObjectName("simulated")
        self.no_clearance = QLabel()
        self.no_clearance.setObjectName("alarm")
        self.no_clearance.setWordWrap(True)
        self.table = QTableWidget(0, 6)
        self.details = QLabel()
        self.details.setTextFormat(Qt.TextFormat.PlainText)
        self.details.setWordWrap(True)
        self.progress = QProgressBar()
        self.progress.setRange(0, 0)  # it is not known how long it takes
        self.permittivity_label = QLabel()
        self.permittivity = TouchEdit("permittivity")
        self.number_pad = Pad(window)
        self.find_button = new_button(self._on_find)
        self.hiding_button = new_button(self._on_hiding)
        self.cancel = new_button(self._on_cancel)
        self.close_button = new_button(self.hide)
        self.permittivity.tapped.connect(self._on_tap)
        self.permittivity.textChanged.connect(self._show)
        self._lay_out()
        self.retranslate()

    def show_survey(self, survey: SurveySummary) -> None:
        """Open for a survey."""
        self.search.choose(survey)
        self.retranslate()
        self.open()

    def refresh(self) -> None:
        """Show the search if it has changed, and how long it has been running."""
        search = self.search
        progress = search.state, search.problem, search.can_start, int(search.running_s)
        state = (*progress, search.hiding is None)
        if state != self._shown:
            self._shown = state
            self._show()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        self.table.verticalHeader().setDefaultSectionSize(look_of(self).px(ROW_PX))

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        survey = self.search.survey
        self.title.setText(
            self.tr("Candidates of {survey}").format(
                survey="" if survey is None else survey.name or survey.local_time()
            )
        )
        self.simulated.setText(self.tr("SIMULATED"))
        self.no_clearance.setText(shown_text(NO_CLEARANCE))
        self.permittivity_label.setText(self.tr("Permittivity"))
        self.find_button.setText(self.tr("FIND"))
        self.hiding_button.setText(self.tr("HIDDEN?"))
        self.cancel.setText(self.tr("CANCEL"))
        self.close_button.setText(self.tr("CLOSE"))
        self.table.setHorizontalHeaderLabels(
            [
                self.tr("id"),
                self.tr("x mm"),
                self.tr("y mm"),
                self.tr("depth mm"),
                self.tr("false alarms per m2"),
                self.tr("flags"),
            ]
        )
        self._show()

    def _show(self) -> None:
        search = self.search
        found, survey = search.found, search.survey
        running = search.state is SearchState.RUNNING
        wrong = check_permittivity(self.permittivity.text())
        self.permittivity.show_problem("" if wrong is None else shown_text(wrong))
        self.find_button.setEnabled(search.can_start and wrong is None)
        self.hiding_button.setEnabled(search.can_start and found is not None)
        self.cancel.setEnabled(running)
        self.progress.setVisible(running)
        self.table.setVisible(not running and search.problem is None)
        self.simulated.setVisible(
            (survey is not None and survey.simulated) or (found is not None and found.simulated)
        )
        rows = found.shown() if found is not None else ()
        self.table.setRowCount(len(rows))
        for row, one in enumerate(rows):
            for column, text in enumerate(self._cells(one)):
                self.table.setItem(row, column, QTableWidgetItem(text))
        self.details.setText(self._sentence())

    def _cells(self, one: Candidate) -> List[str]:
        return [
            one.id,
            *one.place_texts,
            one.false_alarms_text or NONE,
            ", ".join(shown_text(label) for label in one.labels) or NONE,
        ]

    def _sentence(self) -> str:
        search = self.search
        if search.state is SearchState.RUNNING:
            text = self.tr("Searching for {seconds} s.")
            return text.format(seconds=int(search.running_s))
        if search.problem is not None:
            return shown_text(search.problem)[:LONGEST_PROBLEM]
        if search.hiding is not None:
            details = " ".join(shown_text(one) for one in search.hiding.details)
            return f"{shown_text(ONLY_THIS)} {details}"[:LONGEST_PROBLEM]
        found = search.found
        if found is None:
            return self.tr("FIND searches the stored data. It takes up to some minutes.")
        counted = self.tr(
            "Candidates: {primary}. Doubtful: {secondary}, not shown: {hidden}. Permittivity: "
            "{permittivity}."
        ).format(
            primary=found.primary,
            secondary=found.total - found.primary,
            hidden=found.total - len(found.shown()) - found.omitted_primary,
            permittivity=f"{found.permittivity:.3g}",
        )
        missing = self.tr("NOT shown, although NOT doubtful: {count}.")
        parts = [missing.format(count=found.omitted_primary)] if found.omitted_primary else []
        return " ".join([*parts, counted, search.remarks])[:LONGEST_REMARK]

    def _on_find(self) -> None:
        self.search.start(self.permittivity.text(), self._language())
        self._show()

    def _on_hiding(self) -> None:
        self.search.start_hiding()
        self._show()

    def _on_cancel(self) -> None:
        self.search.cancel()
        self._show()

    def _on_tap(self) -> None:
        def judge(text: str) -> str:
            wrong = check_permittivity(text)
            return "" if wrong is None else shown_text(wrong)

        self.number_pad.ask(
            self.permittivity.setText,
            self.permittivity_label.text(),
            shown_text(PERMITTIVITY_RANGE),
            self.permittivity.text(),
            judge,
            Keys.NUMBER,
            strict=False,
        )

    def _lay_out(self) -> None:
        table = self.table
        table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        table.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        table.verticalHeader().hide()
        header = table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(True)
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 4, 8, 4)
        grid.setSpacing(4)
        grid.addWidget(self.title, 0, 0)
        grid.addWidget(self.simulated, 0, 1)
        grid.addWidget(self.no_clearance, 1, 0, 1, 2)
        grid.addWidget(table, 2, 0, 1, 2)
        grid.addWidget(self.progress, 3, 0, 1, 2)
        grid.addWidget(self.details, 4, 0, 1, 2)
        buttons = QHBoxLayout()
        buttons.addWidget(self.permittivity_label)
        buttons.addWidget(self.permittivity, 1)
        for button in (self.find_button, self.hiding_button, self.cancel, self.close_button):
            buttons.addWidget(button, 1)
        grid.addLayout(buttons, 5, 0, 1, 2)
        grid.setRowStretch(2, 1)
        grid.setColumnStretch(0, 1)

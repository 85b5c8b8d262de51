"""The list of past surveys: how each ended; look at one, resume, search or export it."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

from PyQt5.QtCore import QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QBrush, QColor, QIcon, QPainter, QPixmap, QShowEvent
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
)

from gpr20_operator.ground.past_surveys import PastSurveys, Verdict
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.look.look import GAP_PX, Look, Mark, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, shown_text
from gpr20_user_interface.widgets.widgets import new_button

Coverage = Tuple[Tuple[int, ...], ...]


def coverage_icon(
    coverage: Optional[Coverage], width_mm: float, height_mm: float, size_px: int, look: Look
) -> QIcon:
    """Return the map: full where all is stored, hatched where a part is, empty where nothing is.

    Args:
        coverage: Stored share of each part [%], Y upwards; None: it is not known.
        width_mm: Of the area.
        height_mm: Of the area.
        size_px: Of the longer side.
        look: Colours.
    """
    picture = QPixmap(size_px, size_px)
    picture.fill(Qt.GlobalColor.transparent)
    if coverage is None or width_mm <= 0.0 or height_mm <= 0.0:
        return QIcon(picture)
    longer_mm = max(width_mm, height_mm)
    width_px, height_px = (size_px * one / longer_mm for one in (width_mm, height_mm))
    left_px, top_px = (size_px - width_px) / 2.0, (size_px - height_px) / 2.0
    rows, columns = len(coverage), len(coverage[0])
    painter = QPainter(picture)
    painter.fillRect(QRectF(left_px, top_px, width_px, height_px), QColor(look.colour(Mark.PAPER)))
    part = QBrush(QColor(look.colour(Mark.STOP_PARTLY)), Qt.BrushStyle.Dense4Pattern)
    whole = QBrush(QColor(look.colour(Mark.STOP_DONE)))
    for row, values in enumerate(coverage):
        for column, percent in enumerate(values):
            if percent:
                cell = QRectF(
                    left_px + width_px * column / columns,
                    top_px + height_px * (rows - 1 - row) / rows,
                    width_px / columns + 0.5,
                    height_px / rows + 0.5,
                )
                painter.fillRect(cell, whole if percent == 100 else part)
    painter.setPen(QColor(look.colour(Mark.BORDER)))
    painter.drawRect(QRectF(left_px, top_px, width_px - 1.0, height_px - 1.0))
    painter.end()
    # Chosen rows show it as it is, too.
    icon = QIcon()
    for mode in (QIcon.Mode.Normal, QIcon.Mode.Selected):
        icon.addPixmap(picture, mode)
    return icon


MAP, WHAT, AREA, VERDICT = range(4)
ROW_PX = 64
MAP_PX = 56
BUTTONS_PX = 150
LONGEST_SENTENCE = 160
MOST_ICONS = 500


class PastSurveysView(TranslatedWidget):
    """Shows PastSurveys and emits the operator's requests."""

    # Empty: the first page. Else the folder before which the next page begins.
    page_requested = pyqtSignal(str)
    # The name of a folder.
    open_requested = pyqtSignal(str)
    resume_requested = pyqtSignal(str)
    notes_requested = pyqtSignal(str)
    # A SurveySummary.
    candidates_requested = pyqtSignal(object)
    export_requested = pyqtSignal(object)

    def __init__(self, surveys: PastSurveys) -> None:
        super().__init__()
        self._surveys = surveys
        self._revision = -1
        self._asked_before: Optional[str] = None
        # As in the rows of the table.
        self._shown: Tuple[SurveySummary, ...] = ()
        self._icons: Dict[object, QIcon] = {}
        self.table = QTableWidget(0, 4)
        self.details = QLabel()
        self.open = new_button(self._on_open)
        self.notes = new_button(self._on_notes)
        self.candidates = new_button(self._on_candidates)
        self.export = new_button(self._on_export)
        self.resume = new_button(self._on_resume)
        self._lay_out()
        self.table.itemSelectionChanged.connect(self._show_choice)
        self.table.verticalScrollBar().valueChanged.connect(lambda _: self._read_older())
        self.retranslate()

    @property
    def chosen(self) -> Optional[SurveySummary]:
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
        self._asked_before = None
        if not self._surveys.replay:
            self.page_requested.emit("")

    def _read_older(self) -> None:
        """Request the next page when the end of the list comes near."""
        bar, before = self.table.verticalScrollBar(), self._surveys.next_before
        near = bar.value() >= bar.maximum() - bar.pageStep()
        wanted = near and self._surveys.more and not self._surveys.replay
        if wanted and self.isVisible() and before != self._asked_before:
            self._asked_before = before
            self.page_requested.emit(before)

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
        self._read_older()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Request the list whenever the tab is opened."""
        super().showEvent(event)
        self._ask_again()

    def restyle(self) -> None:
        """Take the sizes and colours of the look."""
        look = look_of(self)
        table = self.table
        table.verticalHeader().setDefaultSectionSize(look.px(ROW_PX))
        table.setIconSize(QSize(look.px(MAP_PX), look.px(MAP_PX)))
        header = table.horizontalHeader()
        header.resizeSection(MAP, look.px(ROW_PX + 8))
        for button in (self.open, self.notes, self.candidates, self.export, self.resume):
            button.setFixedWidth(look.px(BUTTONS_PX))
        self._icons.clear()
        self._show_list()

    def _show_row(self, row: int, survey: SurveySummary) -> None:
        counted = f"{survey.stored_traces} / {survey.planned_traces}"
        if self._surveys.verdict(survey) is Verdict.IMPORTED:
            counted = str(survey.stored_traces)
        area = survey.thumbnail
        known = area.width_mm or area.height_mm
        size = f"{area.width_mm:.0f} x {area.height_mm:.0f} mm" if known else "—"
        when = survey.local_time()
        texts = {
            MAP: "",
            WHAT: f"{survey.name}\n{when}" if survey.name else when,
            AREA: f"{size}\n{counted}" if survey.problem is None else "—",
            VERDICT: self._word(survey),
        }
        for column, text in texts.items():
            item = QTableWidgetItem(text)
            if column == MAP:
                item.setIcon(self._icon(survey))
            self.table.setItem(row, column, item)

    def _icon(self, survey: SurveySummary) -> QIcon:
        area = survey.thumbnail
        key = area.coverage, area.width_mm, area.height_mm
        if key not in self._icons:
            if len(self._icons) >= MOST_ICONS:
                self._icons.clear()
            look = look_of(self)
            self._icons[key] = coverage_icon(*key, look.px(MAP_PX), look)
        return self._icons[key]

    def _word(self, survey: SurveySummary) -> str:
        word = {
            Verdict.COMPLETE: self.tr("complete"),
            Verdict.INCOMPLETE: self.tr("INCOMPLETE"),
            Verdict.RUNNING: self.tr("running"),
            Verdict.UNREADABLE: self.tr("UNREADABLE"),
            Verdict.IMPORTED: self.tr("imported"),
        }[self._surveys.verdict(survey)]
        # Not inside an f-string, where xgettext finds no text.
        simulated = self.tr("SIMULATED")
        return f"{word}\n{simulated}" if survey.simulated and survey.problem is None else word

    def _show_choice(self) -> None:
        chosen = self.chosen
        analyzable = chosen is not None and self._surveys.can_analyze(chosen)
        self.open.setEnabled(chosen is not None and self._surveys.can_open(chosen))
        self.resume.setEnabled(chosen is not None and self._surveys.can_resume(chosen))
        self.notes.setEnabled(chosen is not None and chosen.problem is None)
        self.candidates.setEnabled(analyzable)
        self.export.setEnabled(analyzable)
        if self._surveys.problem is not None:
            text = shown_text(self._surveys.problem)
        elif chosen is None:
            text = self.tr("Touch a survey. Times are local.")
        else:
            text = f"{chosen.folder}: {self._sentence(chosen)}"
        self.details.setText(text[:LONGEST_SENTENCE])

    def _sentence(self, survey: SurveySummary) -> str:
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

    def _on_export(self) -> None:
        if self.chosen is not None:
            self.export_requested.emit(self.chosen)

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        self.open.setText(self.tr("Open"))
        self.resume.setText(self.tr("Resume"))
        self.notes.setText(self.tr("Notes"))
        self.candidates.setText(self.tr("Candidates"))
        self.export.setText(self.tr("Export"))
        self._show_list()

    def _lay_out(self) -> None:
        table = self.table
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        # Each line ends with dots where it does not fit.
        table.setWordWrap(False)
        table.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        table.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        table.verticalHeader().hide()
        header = table.horizontalHeader()
        header.hide()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(MAP, QHeaderView.ResizeMode.Fixed)
        header.setSectionResizeMode(WHAT, QHeaderView.ResizeMode.Stretch)
        self.details.setWordWrap(True)
        self.details.setTextFormat(Qt.TextFormat.PlainText)
        buttons = QVBoxLayout()
        buttons.setSpacing(GAP_PX)
        for button in (self.open, self.notes, self.candidates, self.export, self.resume):
            buttons.addWidget(button)
        buttons.addStretch(1)
        left = QVBoxLayout()
        left.setSpacing(4)
        left.addWidget(table, 1)
        left.addWidget(self.details)
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 4, 4, 4)
        row.setSpacing(GAP_PX)
        row.addLayout(left, 1)
        row.addLayout(buttons)

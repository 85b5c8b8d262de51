"""SURVEYS: the stored surveys; a touch on one shows its map, its answer and what can be done."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np
from PyQt5.QtCore import QAbstractListModel, QModelIndex, QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QBrush, QColor, QPainter, QPixmap, QPixmapCache, QResizeEvent, QShowEvent
from PyQt5.QtWidgets import QLabel, QPushButton, QStackedWidget, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.coverage import Cell
from gpr20_operator.ground.past_surveys import Ending, PastSurveys
from gpr20_operator.jobs.job import Job, Service
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.jobs.result_texts import headline, survey_lines
from gpr20_operator.plan.fields import Keys
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.words import local_time
from gpr20_survey.results.answers import FocusedImage, SurveySummary
from gpr20_user_interface.look.look import GAP_PX, Look, Mark, TextColours, icon, look_of
from gpr20_user_interface.look.translation import sentence_text, shown_text
from gpr20_user_interface.touch.scrolling import FingerList
from gpr20_user_interface.widgets.ground_picture import cells_image
from gpr20_user_interface.widgets.keys import Pad
from gpr20_user_interface.widgets.tile import ElidedLabel
from gpr20_user_interface.widgets.widgets import (
    EmptyState,
    Page,
    PulledText,
    column,
    holding,
    new_button,
    row,
    say,
    tiled,
)

ROW_PX = 80
PICTURE_PX = 64
SIMULATED = Message("SIMULATED")
SURVEY = int(Qt.ItemDataRole.UserRole)
SIGNS: Dict[Ending, str] = {
    Ending.COMPLETE: "\N{CHECK MARK} ",
    Ending.INCOMPLETE: "\N{WARNING SIGN} ",
    Ending.UNREADABLE: "\N{WARNING SIGN} ",
}


class SurveysModel(QAbstractListModel):
    """The surveys that are listed: map, name and time, how each ended, where and by whom.

    Args:
        surveys: Know how each ended.
        is_chosen: Whether the operator has touched a survey.

    Attributes:
        look: Sizes and colours.
    """

    def __init__(self, surveys: PastSurveys, is_chosen: Callable[[SurveySummary], bool]) -> None:
        super().__init__()
        self._past, self._is_chosen = surveys, is_chosen
        self.look = Look()
        self.surveys: Tuple[SurveySummary, ...] = ()

    def show(self, surveys: Tuple[SurveySummary, ...]) -> None:
        """Show other surveys; a list that has only become longer stays where it is scrolled to."""
        known = len(self.surveys)
        if len(surveys) > known and surveys[:known] == self.surveys:
            self.beginInsertRows(QModelIndex(), known, len(surveys) - 1)
            self.surveys = surveys
            self.endInsertRows()
        elif surveys != self.surveys:
            self.beginResetModel()
            self.surveys = surveys
            self.endResetModel()

    def rowCount(self, parent: QModelIndex = QModelIndex()) -> int:  # noqa: N802, B008
        """Qt: how many rows there are."""
        return 0 if parent.isValid() else len(self.surveys)

    def data(self, index: QModelIndex, role: int = int(Qt.ItemDataRole.DisplayRole)) -> Any:
        """Qt: what a row says, and how it looks."""
        survey, roles = self.surveys[index.row()], Qt.ItemDataRole
        if role == SURVEY:
            return survey
        if role == roles.DisplayRole:
            return self._text(survey)
        if role == roles.DecorationRole:
            return map_picture(survey, self.look.px(PICTURE_PX), self.look)
        if role == roles.SizeHintRole:
            return QSize(0, self.look.px(ROW_PX))
        if role in (roles.BackgroundRole, roles.ForegroundRole) and self._is_chosen(survey):
            pair = self.look.text(TextColours.CHOSEN)
            return QBrush(QColor(pair.ground if role == roles.BackgroundRole else pair.ink))
        return None

    def _text(self, survey: SurveySummary) -> str:
        ending = SIGNS.get(self._past.ending_of(survey), "") + shown_text(self._past.ending(survey))
        when = shown_text(local_time(survey.started, survey.folder)) if survey.name.strip() else ""
        simulated = survey.simulated and survey.problem is None
        lines = (
            (shown_text(self._past.title_of(survey)), when),
            (ending,),
            (survey.site, survey.operator, shown_text(SIMULATED) if simulated else ""),
        )
        return "\n".join(" · ".join(filter(None, line)) for line in lines if any(line))


def map_picture(survey: SurveySummary, size_px: int, look: Look) -> QPixmap:
    """Return the map of a survey: full where all is stored, striped where a part is.

    Args:
        survey: Its summary.
        size_px: Of both sides.
        look: Colours.
    """
    size_mm, shape = (survey.width_mm, survey.height_mm), (survey.map_rows, survey.map_columns)
    key = f"survey {size_mm} {shape} {survey.map_percent!r} {size_px} {look.theme}"
    known = QPixmapCache.find(key)
    if known is not None:
        return known
    picture = QPixmap(size_px, size_px)
    picture.fill(Qt.GlobalColor.transparent)
    if 0 < shape[0] * shape[1] == len(survey.map_percent) and min(size_mm) > 0.0:
        percent = np.frombuffer(survey.map_percent, np.uint8).reshape(shape)
        part = np.where(percent > 0, Cell.PARTLY, Cell.MISSING)
        cells = np.where(percent == 100, Cell.DONE, part).astype(np.uint8)
        area = QRectF(0.0, 0.0, *(one * size_px / max(size_mm) - 1.0 for one in size_mm))
        area.moveCenter(QPointF(size_px / 2.0, size_px / 2.0))
        painter = QPainter(picture)
        painter.drawImage(area, cells_image(cells, size_px, look.theme))
        painter.setPen(QColor(look.colour(Mark.BORDER)))
        painter.drawRect(area)
        painter.end()
    QPixmapCache.insert(key, picture)
    return picture


MAP_PX = 80
SIGN_PX = 28
# Of a search; its button has no room for more.
LONGEST_SHOWN = 20


class SurveysPage(QWidget, Page):
    """The list of stored surveys.

    Args:
        window: Keys for the search open over it.
        surveys: The list.
        imaging: The answers that are known.

    Attributes:
        chosen: The survey that the operator touched.
        list: The surveys that fit the search.
    """

    # Empty: the first page. Else the folder before which the next page begins.
    page_requested = pyqtSignal(str)
    # The name of a folder.
    open_requested = pyqtSignal(str)
    resume_requested = pyqtSignal(str)
    notes_requested = pyqtSignal(str)
    result_requested = pyqtSignal(str)
    # The operator wants to plan the next survey.
    plan_requested = pyqtSignal()

    def __init__(self, window: QWidget, surveys: PastSurveys, imaging: Imaging) -> None:
        super().__init__()
        self._surveys = surveys
        self._revision = -1
        self._asked_before: Optional[str] = None
        self._text = ""
        self.chosen: Optional[SurveySummary] = None
        show = lambda _answer: self._show_choice()  # noqa: E731
        self._answer: Job[FocusedImage] = imaging.job(Service.FOCUS, show, show)
        self.pad = Pad(window)
        self.search = new_button(self._ask_text)
        self.clear = new_button(lambda: self.search_for(""), "✕")
        self.model = SurveysModel(surveys, lambda one: one.folder == self._folder)
        self.list = FingerList()
        self.list.setModel(self.model)
        self.list.tapped.connect(lambda row: self.choose(row.data(SURVEY)))
        self.list.verticalScrollBar().valueChanged.connect(lambda _: self._read_older())
        self.empty = EmptyState()
        self.title, self.map, self.details = ElidedLabel(), QLabel(), PulledText()
        self.result = self._key(self.result_requested, Message("Result"))
        self.open = self._key(self.open_requested, Message("Ground"))
        self.resume = self._key(self.resume_requested, Message("Resume"))
        self.notes = self._key(self.notes_requested, Message("Notes"))
        self._lay_out()
        self._show_list()

    def on_event(self, _event: object) -> None:
        """Show what the storage reports."""
        self._show()

    def show_state(self, _snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._show()

    def _show(self) -> None:
        """Show the list if it has changed; request it again if it is visible and outdated."""
        if self._surveys.outdated and self.isVisible():
            self._ask_again()
        if self._surveys.revision != self._revision:
            self._revision = self._surveys.revision
            self._show_list()

    def choose(self, survey: Optional[SurveySummary]) -> None:
        """Show a survey, its answer and what can be done with it; None: no survey."""
        self.chosen = survey
        self.list.viewport().update()
        self._answer.end()
        if survey is not None and self._surveys.can_open(survey):
            self._answer.ask(survey=survey.folder, only_known=True)
        self._show_choice()

    def search_for(self, text: str) -> None:
        """List the surveys that hold every word of a text; another one is not chosen any more."""
        self._text = " ".join(text.split())
        if self.chosen not in self._surveys.found(self._text, shown_text):
            self.choose(None)
        self._show_list()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Request the list whenever the tab is opened."""
        super().showEvent(event)
        self._ask_again()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Qt: there is more or less room for rows."""
        super().resizeEvent(event)
        self._read_older()

    @property
    def _folder(self) -> str:
        return "" if self.chosen is None else self.chosen.folder

    def _ask_text(self) -> None:
        hint = self.tr("Name, site, operator, date")
        asked = (self.search_for, self.tr("Search"), hint, self._text)
        self.pad.ask(*asked, lambda _text: "", Keys.LETTERS)

    def _ask_again(self) -> None:
        self._surveys.outdated = False
        self._asked_before = None
        self.page_requested.emit("")

    def _read_older(self) -> None:
        """Request the next page when the end of the rows that fit comes near."""
        before = self._surveys.next_before
        # By the rows: the scroll bar knows of new ones only later.
        seen_px = self.list.verticalScrollBar().value() + 2 * self.list.viewport().height()
        near = seen_px >= self.model.rowCount() * look_of(self).px(ROW_PX)
        wanted = near and self._surveys.more
        if wanted and self.isVisible() and before != self._asked_before:
            self._asked_before = before
            self.page_requested.emit(before)

    def _show_list(self) -> None:
        self.model.show(self._surveys.found(self._text, shown_text))
        if self.chosen is not None:
            # It may have changed; it stays chosen where it is not read yet.
            found = self._surveys.find(self.chosen.folder)
            self.chosen = self.chosen if self._surveys.more and found is None else found
        if self.chosen is None and self.model.surveys and self.isVisible():
            self.choose(self.model.surveys[0])
        self.list.viewport().update()
        self._show_empty()
        self._show_search()
        self._show_choice()
        self._read_older()

    def _show_search(self) -> None:
        self.clear.setVisible(bool(self._text))
        # Dots, while there may be more than were found.
        count = f"{len(self.model.surveys)}{'…' if self._surveys.more else ''}"
        shown = f"{self._text[:LONGEST_SHOWN]} · {count}"
        self.search.setText(shown if self._text else self.tr("Search"))

    def _show_empty(self) -> None:
        surveys, is_empty = self._surveys, not self.model.surveys
        self.shown.setCurrentWidget(self.empty if is_empty else self.list)
        if not is_empty:
            return
        if surveys.problem is not None:
            text = sentence_text(surveys.problem)
            self.empty.explain("warning", text, self.tr("Read again"), self._ask_again)
        elif not surveys.read or surveys.more:
            self.empty.explain("surveys", self.tr("The surveys are being read."))
        elif surveys.surveys:
            text, show_all = self.tr("No survey fits the search."), self.tr("Show all")
            self.empty.explain("search", text, show_all, lambda: self.search_for(""))
        else:
            text = self.tr("No survey is stored yet.")
            self.empty.explain("surveys", text, self.tr("Plan a survey"), self.plan_requested.emit)

    def _show_choice(self) -> None:
        surveys, chosen, look = self._surveys, self.chosen, look_of(self)
        for button, can in (
            (self.result, surveys.can_open),
            (self.open, surveys.can_open),
            (self.resume, surveys.can_resume),
            (self.notes, lambda one: one.problem is None),
        ):
            button.setVisible(chosen is not None and can(chosen))
        # What a touch does: the search takes its time.
        searched = self._answer.problem is None
        say(self.result, Message("Result") if searched else Message("Search\nand show"))
        title, lines = "", [self.tr("Touch a survey. Times are local.")]
        if chosen is not None:
            title, lines = shown_text(surveys.title_of(chosen)), self._lines(chosen)
            self.map.setPixmap(map_picture(chosen, look.px(MAP_PX), look))
        self.map.setVisible(chosen is not None and bool(chosen.map_percent))
        if surveys.problem is not None:
            lines = [sentence_text(surveys.problem)]
        self.title.setText(title)
        self.details.setText("\n".join(lines))

    def _lines(self, survey: SurveySummary) -> List[str]:
        """Return the answer, when and what was measured, and how the survey ended."""
        if survey.problem is not None:
            return [survey.folder, sentence_text(survey.problem)]
        answer = self._answer.problem
        if self._answer.result is not None:
            answer = headline(self._answer.result.found)
        when = local_time(survey.started, survey.folder) if survey.name.strip() else None
        lines = (answer, when, *survey_lines(self._surveys, survey))
        return [sentence_text(one) for one in lines if one is not None]

    def _key(self, requested: Any, text: Message) -> QPushButton:
        return new_button(lambda: requested.emit(self._folder), text)

    def show_again(self) -> None:
        """Show the same in another language, theme or size."""
        self.model.look = look = look_of(self)
        ink = look.text(TextColours.ARROW).ink
        self.search.setIcon(icon("search", ink, look.px(SIGN_PX)))
        self.search.setIconSize(QSize(look.px(SIGN_PX), look.px(SIGN_PX)))
        self.list.setIconSize(QSize(look.px(PICTURE_PX), look.px(PICTURE_PX)))
        self.list.doItemsLayout()
        self._show_list()

    def _lay_out(self) -> None:
        self.search.setObjectName("field")
        self.title.setObjectName("first_title")
        self.result.setObjectName("primary")
        self.map.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.shown = QStackedWidget()
        self.shown.addWidget(self.list)
        self.shown.addWidget(self.empty)
        left = column(row((self.search, 1), self.clear), (self.shown, 1))
        keys = tiled((self.result, self.open, self.resume, self.notes), 2)
        right = holding(column(self.title, self.map, (self.details, 1), keys), "surveys_panel")
        self.setLayout(row((left, 1), right, margin=GAP_PX))

"""The list of stored surveys: what a row says, and the map of a survey."""

from __future__ import annotations

from typing import Any, Callable, Dict, Tuple

from PyQt5.QtCore import QAbstractListModel, QModelIndex, QRectF, QSize, Qt
from PyQt5.QtGui import QBrush, QColor, QPainter, QPixmap, QPixmapCache

from gpr20_common.message import Message
from gpr20_operator.ground.past_surveys import Ending, PastSurveys
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.look.look import Look, Mark, TextColours
from gpr20_user_interface.look.translation import shown_text

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
        when = shown_text(self._past.time_of(survey)) if survey.name.strip() else ""
        simulated = survey.simulated and survey.problem is None
        lines = (
            (shown_text(self._past.title_of(survey)), when),
            (ending,),
            (survey.site, survey.operator, shown_text(SIMULATED) if simulated else ""),
        )
        return "\n".join(" · ".join(filter(None, line)) for line in lines if any(line))


def map_picture(survey: SurveySummary, size_px: int, look: Look) -> QPixmap:
    """Return the map of a survey: full where all is stored, hatched where a part is.

    Args:
        survey: Its summary.
        size_px: Of both sides.
        look: Colours.
    """
    size_mm, shape = (survey.width_mm, survey.height_mm), (survey.map_columns, survey.map_rows)
    key = f"survey {size_mm} {shape} {survey.map_percent!r} {size_px} {look.theme}"
    known = QPixmapCache.find(key)
    if known is not None:
        return known
    picture = QPixmap(size_px, size_px)
    picture.fill(Qt.GlobalColor.transparent)
    if 0 < shape[0] * shape[1] == len(survey.map_percent) and min(size_mm) > 0.0:
        painter = QPainter(picture)
        _paint_map(painter, survey, size_px, look)
        painter.end()
    QPixmapCache.insert(key, picture)
    return picture


def _paint_map(painter: QPainter, survey: SurveySummary, size_px: int, look: Look) -> None:
    scale = size_px / max(survey.width_mm, survey.height_mm)
    width, height = survey.width_mm * scale, survey.height_mm * scale
    left, top = (size_px - width) / 2.0, (size_px - height) / 2.0
    painter.fillRect(QRectF(left, top, width, height), QColor(look.colour(Mark.PAPER)))
    part = QBrush(QColor(look.colour(Mark.STOP_PARTLY)), Qt.BrushStyle.Dense4Pattern)
    whole = QBrush(QColor(look.colour(Mark.STOP_DONE)))
    cell_width, cell_height = width / survey.map_columns, height / survey.map_rows
    for place, percent in enumerate(survey.map_percent):
        if percent:
            row, column = divmod(place, survey.map_columns)
            # Y points upwards.
            x, y = left + cell_width * column, top + cell_height * (survey.map_rows - 1 - row)
            cell = QRectF(x, y, cell_width + 0.5, cell_height + 0.5)
            painter.fillRect(cell, whole if percent == 100 else part)
    painter.setPen(QColor(look.colour(Mark.BORDER)))
    painter.drawRect(QRectF(left, top, width - 1.0, height - 1.0))

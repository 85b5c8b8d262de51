"""The list of stored surveys: what a row says, and how it is painted."""

from __future__ import annotations

from typing import Any, Callable, Dict, Tuple

from PyQt5.QtCore import QAbstractListModel, QModelIndex, QRectF, QSize, Qt
from PyQt5.QtGui import QBrush, QColor, QFont, QPainter, QPixmap, QPixmapCache
from PyQt5.QtWidgets import QStyledItemDelegate, QStyleOptionViewItem

from gpr20_common.message import Message
from gpr20_operator.ground.past_surveys import Ending, PastSurveys, title_of
from gpr20_operator.words import local_time
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.look.icons import sign
from gpr20_user_interface.look.look import GAP_PX, Look, Mark, TextColours, look_of
from gpr20_user_interface.look.translation import shown_text

ROW_PX = 80
PICTURE_PX = 64
SIGN_PX = 20
LEFT = int(Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft)
RIGHT = int(Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight)
SIMULATED = Message("SIMULATED")
SURVEY = int(Qt.ItemDataRole.UserRole)
SIGNS: Dict[Ending, str] = {
    Ending.COMPLETE: "check",
    Ending.INCOMPLETE: "warning",
    Ending.RUNNING: "resume",
    Ending.UNREADABLE: "warning",
    Ending.IMPORTED: "surveys",
}


class SurveysModel(QAbstractListModel):
    """The surveys that are listed, as Qt asks for them."""

    def __init__(self) -> None:
        super().__init__()
        self._surveys: Tuple[SurveySummary, ...] = ()

    @property
    def surveys(self) -> Tuple[SurveySummary, ...]:
        """The rows."""
        return self._surveys

    def show(self, surveys: Tuple[SurveySummary, ...]) -> None:
        """Show other surveys; a list that has only become longer stays where it is scrolled to."""
        known = len(self._surveys)
        if len(surveys) > known and surveys[:known] == self._surveys:
            self.beginInsertRows(QModelIndex(), known, len(surveys) - 1)
            self._surveys = surveys
            self.endInsertRows()
        elif surveys != self._surveys:
            self.beginResetModel()
            self._surveys = surveys
            self.endResetModel()

    def rowCount(self, parent: QModelIndex = QModelIndex()) -> int:  # noqa: N802, B008
        """Qt: how many rows there are."""
        return 0 if parent.isValid() else len(self._surveys)

    def data(self, index: QModelIndex, role: int = int(Qt.ItemDataRole.DisplayRole)) -> Any:
        """Qt: what a row says."""
        survey = self._surveys[index.row()]
        if role == SURVEY:
            return survey
        return shown_text(title_of(survey)) if role == int(Qt.ItemDataRole.DisplayRole) else None


class SurveyRow(QStyledItemDelegate):
    """Paints a row: map, name and time, how the survey ended, where and by whom.

    Args:
        surveys: Know how each ended.
        is_chosen: Whether the operator has touched a survey.
    """

    def __init__(self, surveys: PastSurveys, is_chosen: Callable[[SurveySummary], bool]) -> None:
        super().__init__()
        self._surveys = surveys
        self._is_chosen = is_chosen

    def sizeHint(self, option: QStyleOptionViewItem, _index: QModelIndex) -> QSize:  # noqa: N802
        """Qt: how large a row is."""
        return QSize(option.rect.width(), look_of(option.widget).px(ROW_PX))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex) -> None:
        """Qt: paint a row."""
        survey: SurveySummary = index.data(SURVEY)
        look, row = look_of(option.widget), QRectF(option.rect)
        pair = look.text(
            TextColours.CHOSEN if self._is_chosen(survey) else TextColours.PLAIN,
        )
        gap, size = look.px(GAP_PX), look.px(PICTURE_PX)
        painter.save()
        painter.fillRect(row, QColor(pair.ground))
        painter.setPen(QColor(look.colour(Mark.GRID)))
        painter.drawLine(row.bottomLeft(), row.bottomRight())
        picture = map_picture(survey, size, look)
        painter.drawPixmap(round(row.left()) + gap, round(row.center().y() - size / 2.0), picture)
        painter.setPen(QColor(pair.ink))
        words = row.adjusted(2 * gap + size, gap / 2.0, -gap, -gap / 2.0)
        self._write(painter, words, survey, look, pair.ink)
        painter.restore()

    def _write(
        self, painter: QPainter, area: QRectF, survey: SurveySummary, look: Look, ink: str
    ) -> None:
        ending = shown_text(self._surveys.ending(survey))
        if survey.simulated and survey.problem is None:
            ending += f" · {shown_text(SIMULATED)}"
        people = " · ".join(one for one in (survey.site, survey.operator) if one)
        lines = [ending, people] if people else [ending]
        line = QRectF(area.topLeft(), area.topRight())
        line.setHeight(area.height() / (1 + len(lines)))
        when = shown_text(local_time(survey.started, survey.folder)) if survey.name.strip() else ""
        painter.drawText(line, RIGHT, when)
        taken = painter.fontMetrics().horizontalAdvance(when) + look.px(GAP_PX) if when else 0
        bold = QFont(painter.font())
        bold.setBold(True)
        plain = QFont(painter.font())
        painter.setFont(bold)
        _write_line(painter, line.adjusted(0, 0, -taken, 0), shown_text(title_of(survey)))
        painter.setFont(plain)
        size = look.px(SIGN_PX)
        for number, text in enumerate(lines):
            line.translate(0.0, line.height())
            indent = 0
            if number == 0:
                picture = sign(SIGNS[self._surveys.ending_of(survey)], ink, size)
                painter.drawPixmap(
                    round(line.left()), round(line.center().y() - size / 2.0), picture
                )
                indent = size + look.px(GAP_PX / 2)
            _write_line(painter, line.adjusted(indent, 0, 0, 0), text)


def _write_line(painter: QPainter, area: QRectF, text: str) -> None:
    shown = painter.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, int(area.width()))
    painter.drawText(area, LEFT, shown)


def map_picture(survey: SurveySummary, size_px: int, look: Look) -> QPixmap:
    """Return the map of a survey: full where all is stored, hatched where a part is.

    Args:
        survey: Its summary.
        size_px: Of the longer side.
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

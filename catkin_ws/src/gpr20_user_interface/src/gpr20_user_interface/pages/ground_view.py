"""The GROUND page: the survey from above, and the section below the place touched."""

from __future__ import annotations

from functools import partial
from typing import Callable, Optional, Tuple

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QColor, QPainter, QPaintEvent, QPen, QResizeEvent, QShowEvent
from PyQt5.QtWidgets import QBoxLayout, QPushButton, QSizePolicy, QStackedWidget, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground import texts
from gpr20_operator.ground.echoes import LevelScale
from gpr20_operator.ground.model import GroundModel
from gpr20_operator.ground.sources import Layer, Picture
from gpr20_operator.ground.texts import marks_above, marks_in_section
from gpr20_operator.palette import LAST_SHADE, shade_colours
from gpr20_survey.plan.markers import Marker
from gpr20_user_interface.look.look import Mark, look_of
from gpr20_user_interface.look.translation import sentence_text, shown_number, shown_text
from gpr20_user_interface.widgets.ground_picture import GroundPicture, SectionPlot
from gpr20_user_interface.widgets.plot import UNIT, Plot, image_of
from gpr20_user_interface.widgets.tile import SurveyBand
from gpr20_user_interface.widgets.widgets import (
    EmptyState,
    PulledText,
    column,
    holding,
    new_button,
    new_label,
    offer,
    row,
    say,
    set_look,
)

# The pictures have the room that others leave between what is pressed.
GAP_PX = 2
# While a finger drags, drawing more often costs a core and shows no more.
DRAG_MS = 60
# The view from above has at least and at most this part of the room.
LEAST_ABOVE, MOST_ABOVE = 0.3, 0.6


class ColourBar(QWidget):
    """Shows what the shades mean, the strongest at the top."""

    def __init__(self) -> None:
        super().__init__()
        self._scale: Optional[LevelScale] = None
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)

    def show_scale(self, scale: Optional[LevelScale]) -> None:
        """Show a scale; None: nothing."""
        if scale != self._scale:
            self._scale = scale
            self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        if self._scale is None:
            return
        painter, look = QPainter(self), look_of(self)
        metrics = painter.fontMetrics()
        line_px = metrics.height()
        painter.setPen(QColor(look.colour(Mark.INK)))
        painter.drawText(0, metrics.ascent(), "dB")
        bar = QRectF(0, line_px, self.width() * 0.36, self.height() - 1.5 * line_px)
        shades = np.arange(LAST_SHADE, -1, -1)[:, None]
        painter.drawImage(bar, image_of(shades, shade_colours()))
        painter.setPen(QPen(QColor(look.colour(Mark.BORDER)), 1))
        painter.drawRect(bar)
        painter.setPen(QColor(look.colour(Mark.INK)))
        last_px = -1.0
        for level_db, shade in self._scale.ticks()[::-1].tolist():
            y = bar.bottom() - shade * bar.height() + metrics.ascent() / 2.0 - 1
            # Numbers that would touch their neighbours are left out.
            if last_px < 0 or y - last_px >= line_px:
                painter.drawText(QPointF(bar.right() + 4, y), shown_number(level_db))
                last_px = y


class GroundView(QWidget):
    """Draws what a GroundModel shows; `refresh` follows it.

    Attributes:
        above: The survey from above.
        section: The section through the crosshair.
        text: What is known of the place that was touched.
        note: What must be known about the pictures; never cut off.
        band: Which survey is shown, if it is not the live one.
        problem: Why there is no newer focused image; None: nothing went wrong.
        is_running: Whether a survey runs: then none can be planned.
        is_replay: Whether it is a replay, which nobody adds to.
        carriage_mm: Where the antennas are (X, Y); None: not known.
    """

    opened = pyqtSignal()
    # There is nothing to show here: the stored surveys should be seen.
    surveys_wanted = pyqtSignal()

    def __init__(self, model: GroundModel) -> None:
        super().__init__()
        self.model = model
        self._drawn: Tuple[object, ...] = ()
        self._band: Optional[Message] = None
        self._enlarged: Optional[Plot] = None
        self.problem: Optional[Message] = None
        self.is_running = self.is_replay = False
        self.carriage_mm: Optional[Tuple[float, float]] = None
        self.above, self.section = GroundPicture(), SectionPlot()
        self._active: Plot = self.above
        self.empty, self._stack = EmptyState(), QStackedWidget()
        self.text, self.band = PulledText("ground_text"), SurveyBand()
        self.note = new_label("ground_note")
        self.bar = ColourBar()
        self.enlarge_key = new_button(lambda: self.enlarge(self._active))
        self.shallower = new_button(lambda: self._do(partial(model.step_depth, -1)), "▲")
        self.deeper = new_button(lambda: self._do(partial(model.step_depth, +1)), "▼")
        self.back, self.layers = QPushButton(), QPushButton()
        self.set_marker, self.finer = QPushButton(), QPushButton()
        say(self.layers, Message("Layers"))
        say(self.back, Message("Back\nto live"))
        self.next = new_button(lambda: self._do(model.choose_next))
        self._slow = QTimer(self)
        self._slow.setInterval(DRAG_MS)
        self._slow.setSingleShot(True)
        self._slow.timeout.connect(self.refresh)
        self._lay_out()
        self._connect()

    def show_band(self, band: Optional[Message]) -> None:
        """Say which survey is shown; None: the live one."""
        if band != self._band:
            self._band, self._drawn = band, ()
            self.band.show_band(band)
            self.back.setVisible(band is not None)

    def refresh(self) -> None:
        """Draw again if something has changed and the page is visible."""
        if not self.isVisible():
            return
        self.model.notice_survey()
        self.above.set_carriage(self.carriage_mm)
        running = self.is_running, self.is_replay
        state = (*self.model.state, self.problem, running, self.size(), self._enlarged)
        if state != self._drawn:
            self._drawn = state
            self._draw()

    def enlarge(self, plot: Optional[Plot]) -> None:
        """Let one picture have the whole room, or, if one has it already, share it again."""
        if self._enlarged is not None:
            self._enlarged.show_all()
        self._enlarged = None if self._enlarged is not None else plot
        self.refresh()

    def show_place(self, x_mm: float, y_mm: float) -> None:
        """Bring a place into the picture."""
        self._enlarged = None
        self.above.centre_on(x_mm, y_mm)
        self.refresh()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw what came while the page was hidden."""
        super().showEvent(event)
        self.opened.emit()
        self.refresh()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: there is more or less room."""
        super().resizeEvent(event)
        self._share_room()

    def show_again(self) -> None:
        """Show the same in another language, theme or size."""
        # A screen that is too small to operate has a sentence there.
        set_look(self._bottom, "covered", not look_of(self).touchable)
        self._drawn = ()
        self.refresh()

    def _draw(self) -> None:
        model, above = self.model, self.above
        has_survey = model.survey.map.grid is not None
        self._stack.setCurrentIndex(int(has_survey))
        if not has_survey and self.is_running:
            self.empty.explain("ground", shown_text(texts.BEGINS))
        elif not has_survey:
            self.empty.explain(
                *("ground", shown_text(texts.NO_SURVEY), self.tr("Stored surveys")),
                self.surveys_wanted.emit,
            )
        if not has_survey:
            return
        shown, point = model.pictures(), model.point
        above.show_coverage(model.survey.map, model.waiting)
        above.show_picture(shown.above)
        hatched = model.settings.layer is Layer.HIDING
        above.set_hiding(model.additions.hiding if hatched else None)
        above.set_marks(marks_above(model))
        above.set_crosshair(*((None, None) if point is None else point[:2]))
        above.set_notice(_sentences(texts.above_notice(model, shown, self.problem)))
        above.labels = ("X mm", shown_text(texts.depth_title(model, shown.above is not None)))
        self._draw_section(shown.section)
        picture = shown.above or shown.section
        self.bar.show_scale(None if picture is None else picture.scale)
        lines, notes = texts.touched_lines(model, shown), texts.notes(model)
        remark = (texts.remark(model),)
        # Beside the band there is no room for it.
        lines, notes = (lines, notes + remark) if self._band is None else (remark + lines, notes)
        self.text.setText("\n".join(map(sentence_text, lines)))
        self.note.setText(_sentences(notes))
        self._show_keys()
        self._share_room()

    def _draw_section(self, picture: Optional[Picture]) -> None:
        model, section = self.model, self.section
        section.show_section(picture, model.waiting_along)
        across, second = texts.section_title(model)
        section.labels = (across, shown_text(second))
        if picture is not None:
            section.set_crosshair(*model.section_crosshair)
            section.set_marks(marks_in_section(model))
            section.set_notice(_sentences(texts.nothing_in(model, picture, True)))

    def _show_keys(self) -> None:
        """Enable what can be done now, and say what it does."""
        model = self.model
        additions, ground, has_point = model.additions, model.survey.map, model.point is not None
        self.enlarge_key.setText("⤡" if self._enlarged is not None else "⤢")
        for key in (self.shallower, self.deeper):
            key.setEnabled(model.deepest_m is not None)
        visits, removes = bool(additions.candidates), isinstance(model.mark, Marker)
        gap = visits or ground.next_problem(None) is not None
        following = Message("Next\ncandidate") if visits else Message("Next\ngap")
        offer(self.next, following, None if gap else Message("No gap\nis left"))
        obstacle = None if has_point else Message("Touch\na place")
        if self.is_replay:
            obstacle = Message("Not in\na replay")
        act = Message("Remove\nmarker") if removes else Message("Set\nmarker")
        offer(self.set_marker, act, obstacle)
        if self.is_running:
            obstacle = Message("Finer:\nafterwards")
        elif ground.grid is None or ground.grid.plan is None:
            obstacle = Message("Finer: not\nimported")
        offer(self.finer, Message("Measure\nfiner"), obstacle)

    def _share_room(self) -> None:
        """Give each picture the room that leaves the least of it unused; true to scale above."""
        for plot in (self.above, self.section):
            plot.setVisible(self._enlarged in (None, plot))
        extent, room = self.above.extent or UNIT, self._room.size()
        beside, part = divided(extent.width() / extent.height(), room.width(), room.height())
        across = QBoxLayout.Direction.LeftToRight if beside else QBoxLayout.Direction.TopToBottom
        self._pictures.setDirection(across)
        self._pictures.setStretch(0, round(1000 * part))
        self._pictures.setStretch(1, round(1000 * (1.0 - part)))

    def _do(self, change: Callable[[], None]) -> None:
        change()
        self.refresh()

    def _refresh_soon(self) -> None:
        if not self._slow.isActive():
            self._slow.start()

    def _connect(self) -> None:
        above, section = self.above, self.section
        touches = [above.place_touched, above.mark_touched, section.touched, section.dragged]
        above.place_touched.connect(self.model.choose_place)
        above.mark_touched.connect(self.model.choose_mark)
        for signal in (section.touched, section.dragged):
            signal.connect(self.model.touch_section)
        for signal in touches:
            signal.connect(self._refresh_soon)
        for plot in (above, section):
            plot.pressed.connect(lambda plot=plot: setattr(self, "_active", plot))
            plot.double_tapped.connect(lambda plot=plot: self.enlarge(plot))

    def _lay_out(self) -> None:
        self.note.setTextFormat(Qt.TextFormat.PlainText)
        self.note.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        keys = (self.back, self.next, self.set_marker, self.finer, self.layers)
        for key in keys:
            key.setObjectName("ground_key")
            key.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Expanding)
        for key in (self.enlarge_key, self.shallower, self.deeper):
            key.setObjectName("ground_side")
        for key in (self.shallower, self.deeper):
            key.setAutoRepeat(True)
        self.back.hide()
        self._pictures = row(self.above, self.section, gap=GAP_PX)
        self._room = holding(self._pictures)
        beside = (self.enlarge_key, (self.bar, 1), self.shallower, self.deeper)
        top = row((self._room, 1), column(*beside, gap=GAP_PX), gap=GAP_PX)
        line = row((self.band, 1), self.note, gap=GAP_PX)
        line.addStretch()
        self._bottom = holding(row((self.text, 1), *keys, gap=2 * GAP_PX), "ground_bottom")
        self._stack.addWidget(self.empty)
        whole = column((top, 1), holding(line, "ground_line"), self._bottom, gap=GAP_PX)
        self._stack.addWidget(holding(whole))
        self.setLayout(row(self._stack))


def divided(shape: float, width_px: int, height_px: int) -> Tuple[bool, float]:
    """Return how the view from above, true to scale, and the section share a room.

    Args:
        shape: Width of the survey by its height.
        width_px: Of the room.
        height_px: Of the room.

    Returns:
        Whether the section is beside the view from above, else below it; and the part of the
        room that this view gets: the division leaves the least unused.
    """
    found = []
    for beside, along_px, across_px, part in (
        (True, width_px, height_px, shape),
        (False, height_px, width_px, 1.0 / shape),
    ):
        wanted_px = max(across_px * part, 1.0)
        above_px = max(min(max(wanted_px, LEAST_ABOVE * along_px), MOST_ABOVE * along_px), 1.0)
        # A picture that is narrower or wider than its room leaves some of it unused.
        unused = 1.0 - min(wanted_px, above_px) / max(wanted_px, above_px)
        found.append((unused * above_px * across_px, not beside, above_px / max(along_px, 1)))
    _unused, below, part = min(found)
    return not below, part


def _sentences(lines: Tuple[Message, ...]) -> str:
    return " ".join(map(sentence_text, lines))

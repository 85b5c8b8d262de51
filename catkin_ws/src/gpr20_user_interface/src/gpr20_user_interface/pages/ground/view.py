"""The GROUND page: the survey from above, the section and the trace below the place touched."""

from __future__ import annotations

from typing import Dict, List, Optional, Tuple

from PyQt5.QtCore import QPointF, QRect, QRectF, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QPainter, QPaintEvent, QPen, QResizeEvent, QShowEvent
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.geometry import divided
from gpr20_operator.ground.level_scale import LevelScale
from gpr20_operator.ground.records import Axis, Colours, Picture
from gpr20_user_interface.look.look import TOUCH_PX, Mark, look_of
from gpr20_user_interface.look.shade_colours import LAST_SHADE, colour_table
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.pages.ground import texts
from gpr20_user_interface.pages.ground.model import GroundModel, Layer, Shown
from gpr20_user_interface.pages.ground.section import SectionPlot, TracePlot
from gpr20_user_interface.widgets.ground_picture import Frame, GroundPicture
from gpr20_user_interface.widgets.labels import ElidedLabel, PulledText
from gpr20_user_interface.widgets.plot import Plot
from gpr20_user_interface.widgets.widgets import new_button

BAR_PX, COVERED_PX, SIDE_PX = 56, 68, 52
GAP_PX, LINE_PX = 2, 20
# The trace takes this part of a section's room, within limits.
TRACE_PART, LEAST_TRACE_PX, MOST_TRACE_PX = 0.22, 66, 150
# A room that is at least so large has a section along X and one along Y.
LARGE_PX = (1000, 500)
# While a finger drags, drawing more often costs a core and shows no more.
DRAG_MS = 60


class ColourBar(TranslatedWidget):
    """Shows what the shades mean, the strongest at the top; with a sign, zero is in the middle."""

    def __init__(self) -> None:
        super().__init__()
        self._shown: Tuple[Optional[LevelScale], Colours] = (None, Colours.ENVELOPE)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)

    def show_scale(self, scale: Optional[LevelScale], colours: Colours) -> None:
        """Show a scale; None: nothing."""
        if (scale, colours) != self._shown:
            self._shown = scale, colours
            self.update()

    def retranslate(self) -> None:
        """Nothing to write: dB is the same in every language."""

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw everything."""
        scale, colours = self._shown
        if scale is None:
            return
        painter, look = QPainter(self), look_of(self)
        metrics = painter.fontMetrics()
        line_px = metrics.height()
        painter.setPen(QColor(look.colour(Mark.INK)))
        painter.drawText(0, metrics.ascent(), "dB")
        bar = QRectF(0, line_px, self.width() * 0.36, self.height() - 1.5 * line_px)
        table = colour_table(colours)[LAST_SHADE::-1]
        image = QImage(table.tobytes(), 1, len(table), 4, QImage.Format.Format_RGBA8888)
        painter.drawImage(bar, image)
        painter.setPen(QPen(QColor(look.colour(Mark.BORDER)), 1))
        painter.drawRect(bar)
        painter.setPen(QColor(look.colour(Mark.INK)))
        last_px = -1.0
        for level_db in scale.ticks_db()[::-1]:
            shade = scale.shade_of(float(level_db))
            part = (shade + 1.0) / 2.0 if colours.signed else shade
            y = bar.bottom() - part * bar.height() + metrics.ascent() / 2.0 - 1
            # Numbers that would touch their neighbours are left out.
            if last_px < 0 or y - last_px >= line_px:
                painter.drawText(QPointF(bar.right() + 4, y), f"{level_db:g}")
                last_px = y


class Pictures(QWidget):
    """Shares its room among the pictures so that the survey leaves as little as possible unused.

    Attributes:
        above: The survey from above.
        sections: The section along the chosen axis, and, in a large room, along the other one.
        trace: The trace at the crosshair.
        enlarged: The picture that has the whole room; None: none has.
    """

    def __init__(self) -> None:
        super().__init__()
        self.above = GroundPicture()
        self.sections = (SectionPlot(), SectionPlot())
        self.trace = TracePlot(self.sections[0])
        self.enlarged: Optional[Plot] = None
        for one in self.plots:
            one.setParent(self)
        self.setMinimumSize(1, 1)

    @property
    def plots(self) -> Tuple[Plot, ...]:
        """All pictures."""
        return self.above, *self.sections, self.trace

    @property
    def is_large(self) -> bool:
        """Whether there is room for both sections."""
        return self.width() >= LARGE_PX[0] and self.height() >= LARGE_PX[1]

    @property
    def area_px(self) -> int:
        """How many pixels are pictures."""
        return sum(one.width() * one.height() for one in self.plots if one.isVisible())

    def enlarge(self, plot: Optional[Plot]) -> None:
        """Give one picture the whole room; None: share it."""
        if self.enlarged is not None:
            self.enlarged.show_all()
        self.enlarged = plot
        self.arrange()
        if plot is not None:
            plot.fill()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: there is more or less room."""
        super().resizeEvent(event)
        self.arrange()

    def arrange(self) -> None:
        """Place the pictures."""
        places = self._places()
        for one in self.plots:
            one.setVisible(one in places)
            if one in places:
                one.setGeometry(places[one])

    def _places(self) -> Dict[Plot, QRect]:
        room, gap = self.rect(), look_of(self).px(GAP_PX)
        if self.enlarged is not None:
            return {self.enlarged: room}
        extent = self.above.extent or QRectF(0.0, 0.0, 1.0, 1.0)
        division = divided(extent.width(), extent.height(), room.width(), room.height())
        above, rest = QRect(room), QRect(room)
        if division.beside:
            above.setWidth(division.above_px)
            rest.setLeft(division.above_px + gap)
        else:
            above.setHeight(division.above_px)
            rest.setTop(division.above_px + gap)
        return {self.above: above, **self._below_ground(rest, division.beside, gap)}

    def _below_ground(self, rest: QRect, stacked: bool, gap: int) -> Dict[Plot, QRect]:
        look, parts = look_of(self), [rest]
        if self.is_large:
            first, second = QRect(rest), QRect(rest)
            if stacked:
                first.setHeight((rest.height() - gap) // 2)
                second.setTop(first.bottom() + 1 + gap)
            else:
                first.setWidth((rest.width() - gap) // 2)
                second.setLeft(first.right() + 1 + gap)
            parts = [first, second]
        section, trace = QRect(parts[0]), QRect(parts[0])
        wide = round(TRACE_PART * section.width())
        wide = min(max(wide, look.px(LEAST_TRACE_PX)), look.px(MOST_TRACE_PX))
        section.setWidth(max(1, section.width() - wide - gap))
        trace.setLeft(section.right() + 1 + gap)
        return {self.trace: trace, **dict(zip(self.sections, (section, *parts[1:])))}


class GroundView(TranslatedWidget):
    """Draws what a GroundModel shows; `refresh` follows it.

    Attributes:
        model: What is chosen and shown.
        pictures: From above, below, and the trace.
        text: What is known of the place that was touched.
        note: What must be known about the pictures; never cut off.
        band: Which survey is shown, if it is not the live one.
    """

    # X, Y and depth in mm, or depth None.
    marker_wanted = pyqtSignal(float, float, object)
    # X and Y in mm.
    finer_wanted = pyqtSignal(float, float)
    # The finer survey that is planned.
    plan_wanted = pyqtSignal()
    layers_wanted = pyqtSignal()
    back_wanted = pyqtSignal()
    opened = pyqtSignal()

    def __init__(self, model: GroundModel) -> None:
        super().__init__()
        self.model = model
        self._drawn: Tuple[object, ...] = ()
        self._problem: Optional[Message] = None
        self._band: Optional[Message] = None
        self._carriage_mm: Optional[Tuple[float, float]] = None
        self.pictures = Pictures()
        self._active: Plot = self.pictures.above
        self.text, self.note, self.band = PulledText(), QLabel(), ElidedLabel()
        self.bar = ColourBar()
        self.enlarge_key = new_button(lambda: self.enlarge(self._active))
        self.shallower = new_button(lambda: self._step_depth(-1), "▲")
        self.deeper = new_button(lambda: self._step_depth(+1), "▼")
        self.back = new_button(self.back_wanted.emit)
        self.next = new_button(self._on_next)
        self.set_marker = new_button(self._on_marker)
        self.finer = new_button(self._on_finer)
        self.layers = new_button(self.layers_wanted.emit)
        self.use, self.drop = new_button(lambda: self.end_fit(True)), new_button(self._on_drop)
        self.fit_text = QLabel()
        self._slow = QTimer(self)
        self._lay_out()
        self._connect()
        self.retranslate()
        self.restyle()

    def set_problem(self, problem: Optional[Message]) -> None:
        """Note why there is no newer focused image; None: nothing went wrong."""
        self._problem = problem

    def set_carriage(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas are [mm]; None: not known."""
        self._carriage_mm = place_mm

    def show_band(self, band: Optional[Message]) -> None:
        """Say which survey is shown; None: the live one."""
        if band != self._band:
            self._band = band
            self._show_band()

    def refresh(self) -> None:
        """Draw again if something has changed and the page is visible."""
        if not self.isVisible():
            return
        model = self.model
        model.notice_survey()
        if self.is_fitting and model.hyperbola is None:
            self._show_fit(False)
        self.pictures.above.set_carriage(self._carriage_mm)
        state = (*model.state, self._problem, self.pictures.size(), self.pictures.enlarged)
        if state != self._drawn:
            self._drawn = state
            self._draw()

    def enlarge(self, plot: Optional[Plot]) -> None:
        """Let one picture have the whole room, or, if one has it already, share it again."""
        self.pictures.enlarge(None if self.pictures.enlarged is not None else plot)
        self._drawn = ()
        self._show_keys()
        self.refresh()

    @property
    def is_fitting(self) -> bool:
        """Whether a hyperbola is fitted."""
        return not self.use.isHidden()

    def begin_fit(self) -> None:
        """Let the operator drag a hyperbola over the enlarged section."""
        self.model.begin_hyperbola()
        if self.model.hyperbola is not None:
            self._show_fit(True)

    def end_fit(self, use: bool) -> None:
        """Take the permittivity of the hyperbola, or drop it."""
        self.model.end_hyperbola(use)
        self._show_fit(False)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Qt: draw what came while the page was hidden."""
        super().showEvent(event)
        self.opened.emit()
        self.refresh()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        look = look_of(self)
        gap = look.px(GAP_PX)
        for key in (self.enlarge_key, self.shallower, self.deeper):
            key.setFixedWidth(look.px(SIDE_PX))
            key.setMinimumHeight(look.px(TOUCH_PX))
        # A screen that is too small to operate has a sentence there.
        self._bottom.setFixedHeight(look.px(BAR_PX if look.touchable else COVERED_PX))
        for label in (self.note, self.band):
            label.setFixedHeight(look.px(LINE_PX))
        for layout in (self._top, self._column, self._line, self._whole):
            layout.setSpacing(gap)
        self._bar_layout.setSpacing(2 * gap)
        self.pictures.arrange()
        self._drawn = ()

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        self.set_marker.setText(self.tr("Set\nmarker"))
        self.layers.setText(self.tr("Layers"))
        self.back.setText(self.tr("Back\nto live"))
        self.drop.setText(self.tr("Cancel"))
        self.pictures.trace.labels = ("dB", self.tr("Trace"))
        self._drawn = ()
        self._show_band()
        self._show_keys()
        self.refresh()

    def _draw(self) -> None:
        model, pictures = self.model, self.pictures
        colours, above = model.settings.colours, pictures.above
        alongs = self._alongs()
        shown = model.pictures(alongs)
        loading = model.survey.loading.waiting
        number = model.settings.polarization
        above.set_frames(self._frames())
        above.show_coverage(
            model.survey.map,
            loading[number] if model.is_loading else None,
            Layer.COVERAGE in model.layers,
        )
        above.show_picture(shown.above, colours)
        above.set_hiding(model.additions.hiding if Layer.HIDING in model.layers else None)
        above.set_marks(model.marks_above())
        place, point = model.place, model.point
        above.set_crosshair(*((None, None) if point is None else point[:2]))
        above.set_notice(_sentences(texts.above_notice(model, shown, self._problem)))
        depth = texts.depth_title(model, shown.above is not None)
        above.labels = ("X mm", shown_text(depth))
        for plot, along, picture in zip(pictures.sections, alongs, shown.sections):
            self._draw_section(plot, along, picture)
        pictures.trace.show_curve(shown.curve)
        axis = pictures.sections[0].axis if shown.curve is None else shown.curve.axis
        depth_m = model.settings.depth_m
        pictures.trace.set_crosshair(
            None, None if place is None else model.second_of(depth_m, axis)
        )
        picture = shown.above or next((one for one in shown.sections if one is not None), None)
        signed = picture is not None and picture.signed
        scale = None if picture is None else picture.scale
        self.bar.show_scale(scale, colours if signed else Colours.ENVELOPE)
        self._write(shown)
        pictures.arrange()

    def _alongs(self) -> Tuple[Axis, ...]:
        """Return the directions of the sections that are seen."""
        pictures, along = self.pictures, self.model.settings.along
        if pictures.enlarged is not None and pictures.enlarged not in pictures.sections:
            return ()
        other = Axis.Y_MM if along is Axis.X_MM else Axis.X_MM
        return (along, other) if pictures.sections[1].isVisible() else (along,)

    def _draw_section(self, plot: SectionPlot, along: Axis, picture: Optional[Picture]) -> None:
        model, place = self.model, self.model.place
        plot.show_section(picture, model.settings.colours)
        in_time = plot.axis is Axis.DELAY_NS
        across, second = texts.section_title(model, along, in_time)
        plot.labels = (across, shown_text(second))
        if picture is None or place is None:
            return
        plot.set_crosshair(place.along(along), model.second_of(model.settings.depth_m, plot.axis))
        plot.set_marks(() if in_time else model.marks_in_section(along))
        notice = texts.section_notice(model, picture.measured, picture.above_noise)
        plot.set_notice("" if self.is_fitting else _sentences(notice))
        hyperbola = model.hyperbola
        if hyperbola is None or along is not model.settings.along:
            plot.set_hyperbola(*2 * (texts.NO_POINTS,), None)
            return
        places, drawn = model.hyperbola_points(picture)
        number = int(abs(places - hyperbola.across_mm).argmin())
        plot.set_hyperbola(places, drawn, (float(places[number]), float(drawn[number])))

    def _frames(self) -> List[Frame]:
        frames = [Frame(one.area) for one in self.model.additions.related]
        grid, plan = self.model.survey.map.grid, self.model.additions.plan
        if plan is not None and grid is not None and plan.refines == grid.survey_id:
            frames.append(Frame(plan.area, planned=True))
        return frames

    def _write(self, shown: Shown) -> None:
        model = self.model
        lines = texts.touched_lines(model, shown)
        if self._band is not None:
            # Beside the band there is no room for it.
            lines = (texts.remark(model), *lines)
        self.text.setText("\n".join(map(sentence_text, lines)))
        self._write_note()
        hyperbola = model.hyperbola
        value = model.settings.permittivity if hyperbola is None else hyperbola.permittivity
        self.fit_text.setText(self.tr("Permittivity {value:.1f}").format(value=value))
        self.use.setText(self.tr("Use {value:.1f}").format(value=value))
        self._show_keys()

    def _write_note(self) -> None:
        remark = () if self._band is not None else (texts.remark(self.model),)
        self.note.setText(_sentences((*texts.notes(self.model), *remark)))

    def _show_keys(self) -> None:
        """Enable what can be done now, and say what it does."""
        model = self.model
        additions, point = model.additions, model.point
        grid = model.survey.map.grid
        self.enlarge_key.setText("⤡" if self.pictures.enlarged is not None else "⤢")
        has_depth = model.deepest_m is not None
        for key in (self.shallower, self.deeper):
            key.setEnabled(has_depth)
        candidates = bool(additions.candidates) and Layer.CANDIDATES in model.layers
        self.next.setText(self.tr("Next\ncandidate") if candidates else self.tr("Next\ngap"))
        self.next.setEnabled(candidates or model.survey.map.next_problem(None) is not None)
        self.set_marker.setEnabled(additions.can_mark and point is not None)
        kept = additions.plan is not None
        self.finer.setText(self.tr("Finer\nplan") if kept else self.tr("Measure\nfiner"))
        has_plan = grid is not None and grid.plan is not None and additions.can_mark
        self.finer.setEnabled(kept or (has_plan and point is not None))

    def _show_band(self) -> None:
        band = self._band
        self.band.setVisible(band is not None)
        self.back.setVisible(band is not None and not self.is_fitting)
        if band is not None:
            self.band.show_text(shown_text(band))
        self._drawn = ()

    def _show_fit(self, fits: bool) -> None:
        for widget in (self.fit_text, self.use, self.drop):
            widget.setVisible(fits)
        for widget in (self.text, self.next, self.set_marker, self.finer, self.layers):
            widget.setVisible(not fits)
        self._show_band()
        self.pictures.enlarge(self.pictures.sections[0] if fits else None)
        self._drawn = ()
        self.refresh()

    def _step_depth(self, steps: int) -> None:
        self.model.step_depth(steps)
        self.refresh()

    def _on_next(self) -> None:
        if self.model.additions.candidates and Layer.CANDIDATES in self.model.layers:
            self.model.choose_next_candidate()
        else:
            self.model.choose_next_problem()
        self.refresh()

    def _on_marker(self) -> None:
        point = self.model.point
        if point is not None:
            self.marker_wanted.emit(*point)

    def _on_finer(self) -> None:
        point = self.model.point
        if self.model.additions.plan is not None:
            self.plan_wanted.emit()
        elif point is not None:
            self.finer_wanted.emit(*point[:2])

    def _on_drop(self) -> None:
        self.end_fit(False)

    def _on_place(self, x_mm: float, y_mm: float) -> None:
        self.model.choose_place(x_mm, y_mm)
        self._refresh_soon()

    def _on_mark(self, mark: object) -> None:
        self.model.choose_mark(mark)  # type: ignore[arg-type]
        self._refresh_soon()

    def _on_section(self, plot: SectionPlot, across_mm: float, second: float) -> None:
        model = self.model
        if model.hyperbola is not None:
            model.drag_hyperbola(plot.gripped, across_mm, second, plot.axis)
        else:
            along = self._alongs()[self.pictures.sections.index(plot)]
            model.touch_section(along, across_mm, second, plot.axis)
        self._refresh_soon()

    def _on_trace(self, _level: float, second: float) -> None:
        self.model.touch_depth(second, self.pictures.sections[0].axis)
        self._refresh_soon()

    def _on_active(self, plot: Plot) -> None:
        self._active = plot

    def _refresh_soon(self) -> None:
        if not self._slow.isActive():
            self._slow.start()

    def _connect(self) -> None:
        self._slow.setInterval(DRAG_MS)
        self._slow.setSingleShot(True)
        self._slow.timeout.connect(self.refresh)
        pictures = self.pictures
        pictures.above.place_touched.connect(self._on_place)
        pictures.above.mark_touched.connect(self._on_mark)
        for plot in pictures.sections:
            for signal in (plot.touched, plot.dragged):
                signal.connect(lambda x, y, plot=plot: self._on_section(plot, x, y))
        for signal in (pictures.trace.touched, pictures.trace.dragged):
            signal.connect(self._on_trace)
        for one in pictures.plots:
            one.pressed.connect(lambda plot=one: self._on_active(plot))
            one.double_tapped.connect(lambda plot=one: self.enlarge(plot))

    def _lay_out(self) -> None:
        self.note.setTextFormat(Qt.TextFormat.PlainText)
        self.note.setObjectName("ground_note")
        self.text.setObjectName("ground_text")
        self.band.setObjectName("shown_band")
        self.note.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self._bar_keys = (self.back, self.next, self.set_marker, self.finer, self.layers)
        self._bar_keys = (*self._bar_keys, self.use, self.drop)
        for key in self._bar_keys:
            key.setObjectName("ground_key")
            key.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Expanding)
        for key in (self.enlarge_key, self.shallower, self.deeper):
            key.setObjectName("ground_choice")
        self._line, self._column, self._top = QHBoxLayout(), QVBoxLayout(), QHBoxLayout()
        self._line.addWidget(self.band, 1)
        self._line.addWidget(self.note)
        self._line.addStretch(0)
        for key in (self.shallower, self.deeper):
            key.setAutoRepeat(True)
        self._column.addWidget(self.enlarge_key)
        self._column.addWidget(self.bar, 1)
        self._column.addWidget(self.shallower)
        self._column.addWidget(self.deeper)
        self._top.addWidget(self.pictures, 1)
        self._top.addLayout(self._column)
        self._bottom = QWidget()
        self._bar_layout = QHBoxLayout(self._bottom)
        self._bar_layout.setContentsMargins(0, 0, 0, 0)
        self._bar_layout.addWidget(self.text, 1)
        self._bar_layout.addWidget(self.fit_text, 1)
        for key in self._bar_keys:
            self._bar_layout.addWidget(key)
        self.fit_text.setObjectName("title")
        for widget in (self.fit_text, self.use, self.drop):
            widget.hide()
        self._whole = QVBoxLayout(self)
        self._whole.setContentsMargins(0, 0, 0, 0)
        self._whole.addLayout(self._top, 1)
        self._whole.addLayout(self._line)
        self._whole.addWidget(self._bottom)


def _sentences(lines: Tuple[Message, ...]) -> str:
    return " ".join(map(sentence_text, lines))

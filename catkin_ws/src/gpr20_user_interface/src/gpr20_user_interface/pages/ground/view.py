"""The GROUND page: the survey from above, the section and the trace below the place touched."""

from __future__ import annotations

from functools import partial
from typing import Callable, List, Optional, Tuple

from PyQt5.QtCore import Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QShowEvent
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout, QWidget

from gpr20_common.message import Message
from gpr20_operator.ground import texts
from gpr20_operator.ground.marks import marks_above, marks_in_section
from gpr20_operator.ground.model import GroundModel, Layer, Shown
from gpr20_operator.ground.records import Axis, Colours, Picture
from gpr20_user_interface.look.look import TOUCH_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.pages.ground.pictures import GAP_PX, ColourBar, Pictures
from gpr20_user_interface.pages.ground.section import SectionPlot
from gpr20_user_interface.widgets.ground_picture import Frame
from gpr20_user_interface.widgets.labels import PulledText, SurveyBand
from gpr20_user_interface.widgets.plot import Plot
from gpr20_user_interface.widgets.widgets import new_button

BAR_PX, COVERED_PX, SIDE_PX, LINE_PX = 56, 68, 52, 20
# While a finger drags, drawing more often costs a core and shows no more.
DRAG_MS = 60


class GroundView(TranslatedWidget):
    """Draws what a GroundModel shows; `refresh` follows it.

    Attributes:
        text: What is known of the place that was touched.
        note: What must be known about the pictures; never cut off.
        band: Which survey is shown, if it is not the live one.
        problem: Why there is no newer focused image; None: nothing went wrong.
        carriage_mm: Where the antennas are (X, Y); None: not known.
    """

    opened = pyqtSignal()

    def __init__(self, model: GroundModel) -> None:
        super().__init__()
        self.model = model
        self._drawn: Tuple[object, ...] = ()
        self.problem: Optional[Message] = None
        self._band: Optional[Message] = None
        self.carriage_mm: Optional[Tuple[float, float]] = None
        self.pictures = Pictures()
        self._active: Plot = self.pictures.above
        self.text, self.note, self.band = PulledText(), QLabel(), SurveyBand()
        self.bar = ColourBar()
        self.enlarge_key = new_button(lambda: self.enlarge(self._active))
        self.shallower = new_button(lambda: self._do(partial(model.step_depth, -1)), "▲")
        self.deeper = new_button(lambda: self._do(partial(model.step_depth, +1)), "▼")
        self.back, self.layers = QPushButton(), QPushButton()
        self.set_marker, self.finer = QPushButton(), QPushButton()
        self.next = new_button(lambda: self._do(model.choose_next))
        self.use = new_button(lambda: self.end_fit(True))
        self.drop = new_button(lambda: self.end_fit(False))
        self.fit_text = QLabel()
        self._slow = QTimer(self)
        self._slow.setInterval(DRAG_MS)
        self._slow.setSingleShot(True)
        self._slow.timeout.connect(self.refresh)
        self._lay_out()
        self._connect()
        self.retranslate()
        self.restyle()

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
        self.pictures.above.set_carriage(self.carriage_mm)
        state = (*model.state, self.problem, self.pictures.size(), self.pictures.enlarged)
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
        self._show_band()
        self._show_keys()
        self.refresh()

    def _draw(self) -> None:
        model, pictures = self.model, self.pictures
        settings, above, alongs = model.settings, pictures.above, self._alongs()
        shown = model.pictures(alongs)
        above.set_frames(self._frames())
        above.show_coverage(model.survey.map, model.waiting, Layer.COVERAGE in model.layers)
        above.show_picture(shown.above, settings.colours)
        above.set_hiding(model.additions.hiding if Layer.HIDING in model.layers else None)
        above.set_marks(marks_above(model))
        place, point = model.place, model.point
        above.set_crosshair(*((None, None) if point is None else point[:2]))
        above.set_notice(_sentences(texts.above_notice(model, shown, self.problem)))
        depth = texts.depth_title(model, shown.above is not None)
        above.labels = ("X mm", shown_text(depth))
        for plot, along, section in zip(pictures.sections, alongs, shown.sections):
            self._draw_section(plot, along, section)
        curve, picture = shown.curve, shown.first
        pictures.trace.show_curve(curve)
        axis = pictures.sections[0].axis if curve is None else curve.axis
        second = None if place is None else model.second_of(settings.depth_m, axis)
        pictures.trace.set_crosshair(None, second)
        signed = picture is not None and picture.signed
        scale = None if picture is None else picture.scale
        self.bar.show_scale(scale, settings.colours if signed else Colours.ENVELOPE)
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
        plot.show_section(picture, model.settings.colours, model.waiting_along(along))
        in_time = plot.axis is Axis.DELAY_NS
        across, second = texts.section_title(model, along, in_time)
        plot.labels = (across, shown_text(second))
        if picture is None or place is None:
            return
        plot.set_crosshair(place.along(along), model.second_of(model.settings.depth_m, plot.axis))
        plot.set_marks(() if in_time else marks_in_section(model, along))
        notice = texts.nothing_in(model, picture, along)
        plot.set_notice("" if self.is_fitting else _sentences(notice))
        fits = along is model.settings.along
        plot.set_hyperbola(model.hyperbola_points(picture) if fits else None)

    def _frames(self) -> List[Frame]:
        frames = [Frame(one.area) for one in self.model.additions.related]
        plan = self.model.additions.plan
        if plan is not None and plan.refines == self.model.survey.survey_id:
            frames.append(Frame(plan.area, planned=True))
        return frames

    def _write(self, shown: Shown) -> None:
        model = self.model
        lines, notes = texts.touched_lines(model, shown), texts.notes(model)
        remark = (texts.remark(model),)
        if self._band is None:
            notes += remark
        else:
            # Beside the band there is no room for it.
            lines = remark + lines
        self.text.setText("\n".join(map(sentence_text, lines)))
        self.note.setText(_sentences(notes))
        hyperbola = model.hyperbola
        value = model.settings.permittivity if hyperbola is None else hyperbola.permittivity
        self.fit_text.setText(shown_text(Message("Permittivity {value:.1f}", value=value)))
        self.use.setText(shown_text(Message("Use {value:.1f}", value=value)))
        self._show_keys()

    def _show_keys(self) -> None:
        """Enable what can be done now, and say what it does."""
        model = self.model
        additions, ground, has_point = model.additions, model.survey.map, model.point is not None
        self.enlarge_key.setText("⤡" if self.pictures.enlarged is not None else "⤢")
        for key in (self.shallower, self.deeper):
            key.setEnabled(model.deepest_m is not None)
        visits = model.visits_candidates
        self.next.setText(self.tr("Next\ncandidate") if visits else self.tr("Next\ngap"))
        self.next.setEnabled(visits or ground.next_problem(None) is not None)
        self.set_marker.setEnabled(additions.can_mark and has_point)
        kept = additions.plan is not None
        self.finer.setText(self.tr("Finer\nplan") if kept else self.tr("Measure\nfiner"))
        has_plan = ground.grid is not None and ground.grid.plan is not None and additions.can_mark
        self.finer.setEnabled(kept or (has_plan and has_point))

    def _show_band(self) -> None:
        band = self._band
        self.band.show_band(band)
        self.back.setVisible(band is not None and not self.is_fitting)
        self._drawn = ()

    def _show_fit(self, fits: bool) -> None:
        for widget in self._fits:
            widget.setVisible(fits)
        for widget in (self.text, self.next, self.set_marker, self.finer, self.layers):
            widget.setVisible(not fits)
        self._show_band()
        self.pictures.enlarge(self.pictures.sections[0] if fits else None)
        self.refresh()

    def _do(self, change: Callable[[], None]) -> None:
        change()
        self.refresh()

    def _on_section(self, plot: SectionPlot, across_mm: float, second: float) -> None:
        model = self.model
        if model.hyperbola is not None:
            model.drag_hyperbola(plot.grips_apex, across_mm, second, plot.axis)
        else:
            along = self._alongs()[self.pictures.sections.index(plot)]
            model.touch_section(along, across_mm, second, plot.axis)

    def _on_trace(self, _level: float, second: float) -> None:
        self.model.touch_depth(second, self.pictures.sections[0].axis)

    def _refresh_soon(self) -> None:
        if not self._slow.isActive():
            self._slow.start()

    def _connect(self) -> None:
        pictures = self.pictures
        above, trace = pictures.above, pictures.trace
        above.place_touched.connect(self.model.choose_place)
        above.mark_touched.connect(self.model.choose_mark)
        touches = [above.place_touched, above.mark_touched]
        for plot in pictures.sections:
            for signal in (plot.touched, plot.dragged):
                signal.connect(partial(self._on_section, plot))
                touches.append(signal)
        for signal in (trace.touched, trace.dragged):
            signal.connect(self._on_trace)
            touches.append(signal)
        for signal in touches:
            signal.connect(self._refresh_soon)
        for one in pictures.plots:
            one.pressed.connect(lambda plot=one: setattr(self, "_active", plot))
            one.double_tapped.connect(lambda plot=one: self.enlarge(plot))

    def _lay_out(self) -> None:
        self.note.setTextFormat(Qt.TextFormat.PlainText)
        self.note.setObjectName("ground_note")
        self.text.setObjectName("ground_text")
        self.fit_text.setObjectName("title")
        self.note.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        keys = (self.back, self.next, self.set_marker, self.finer, self.layers, self.use, self.drop)
        for key in keys:
            key.setObjectName("ground_key")
            key.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Expanding)
        for key in (self.enlarge_key, self.shallower, self.deeper):
            key.setObjectName("ground_choice")
        for key in (self.shallower, self.deeper):
            key.setAutoRepeat(True)
        self._bottom = QWidget()
        self._line, self._column, self._top = QHBoxLayout(), QVBoxLayout(), QHBoxLayout()
        self._bar_layout, self._whole = QHBoxLayout(self._bottom), QVBoxLayout(self)
        rows = (
            (self._line, (self.band, self.note), (self.band,)),
            (self._column, (self.enlarge_key, self.bar, self.shallower, self.deeper), (self.bar,)),
            (self._bar_layout, (self.text, self.fit_text, *keys), (self.text, self.fit_text)),
        )
        for layout, widgets, wide in rows:
            layout.setContentsMargins(0, 0, 0, 0)
            for widget in widgets:
                layout.addWidget(widget, int(widget in wide))
        self._line.addStretch(0)
        self._top.addWidget(self.pictures, 1)
        self._top.addLayout(self._column)
        self._whole.setContentsMargins(0, 0, 0, 0)
        self._whole.addLayout(self._top, 1)
        self._whole.addLayout(self._line)
        self._whole.addWidget(self._bottom)
        self._fits = (self.fit_text, self.use, self.drop)
        for widget in self._fits:
            widget.hide()


def _sentences(lines: Tuple[Message, ...]) -> str:
    return " ".join(map(sentence_text, lines))

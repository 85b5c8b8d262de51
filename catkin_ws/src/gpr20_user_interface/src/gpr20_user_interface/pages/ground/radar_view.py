"""The RADAR tab: the trace, the line and the slice at the crosshair."""

from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

from PyQt5.QtCore import QTimer, pyqtSignal
from PyQt5.QtGui import QShowEvent

from gpr20_common.message import Message
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.pictures import DEPTH_STEP_M
from gpr20_operator.ground.records import Axis, Colours, Picture, Source
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_user_interface.look.look import look_of
from gpr20_user_interface.pages.ground.picture_plot import Marked, line_spots, slice_spots
from gpr20_user_interface.pages.ground.plots import FixedPlot
from gpr20_user_interface.pages.ground.radar_model import Grip, RadarPictures, RadarPresenter
from gpr20_user_interface.pages.ground.radar_panel import RadarPanel
from gpr20_user_interface.pages.ground.radar_texts import RadarTexts
from gpr20_user_interface.widgets.widgets import connect_click

# A finger nearer to the apex of the hyperbola than this moves it, another one bends the flank.
GRIP_RADIUS_PX = 45
# While a finger drags, drawing more often costs a core and shows no more.
DRAG_MS = 60


class RadarView(RadarPanel):
    """Draws what a RadarPresenter shows; `refresh` follows it.

    Attributes:
        presenter: What is chosen and shown.
        enlarged: The picture that fills the tab; None: all three are shown.
        readout: What is known at the crosshair.
    """

    # X, Y and depth of the crosshair [mm], when the operator asks for a marker there.
    marker_wanted = pyqtSignal(float, float, float)

    def __init__(self, model: RadarModel) -> None:
        super().__init__()
        self.presenter = RadarPresenter(model)
        self.enlarged: Optional[FixedPlot] = None
        self._drawn: Tuple[object, ...] = ()
        self._markers: Tuple[Marker, ...] = ()
        self._can_mark = False
        self._problem: Optional[Message] = None
        self._texts = RadarTexts(self)
        self.readout = ""
        self._slow = QTimer(self)
        self._connect()
        self.retranslate()

    def show_model(self, model: RadarModel) -> None:
        """Follow another survey."""
        self.presenter.show_model(model)
        self.refresh()

    def set_image(self, image: Optional[FocusedImage], problem: Optional[Message]) -> None:
        """Take the focused image of the survey.

        Args:
            image: The newest one; None: there is none.
            problem: Why there is no newer one.
        """
        self.presenter.set_image(image)
        self._problem = problem

    def set_markers(self, markers: Sequence[Marker], can_mark: bool) -> None:
        """Draw the operator's markers.

        Args:
            markers: Those of the survey that is shown.
            can_mark: Whether this survey can have more.
        """
        self._markers, self._can_mark = tuple(markers), can_mark

    def refresh(self) -> None:
        """Draw again if something has changed and the tab is visible."""
        if not self.isVisible():
            return
        self.presenter.notice_survey()
        if self.is_fitting and self.presenter.hyperbola is None:
            # Another survey has begun meanwhile.
            self.enlarged = None
            self.arrange(None, fits=False)
        state = (*self.presenter.state, self._markers, self._can_mark, self._problem)
        if state != self._drawn:
            self._drawn = state
            self._draw()

    def enlarge(self, plot: Optional[FixedPlot]) -> None:
        """Let one picture fill the tab, or, if it does already, show all three again."""
        self.enlarged = None if plot is self.enlarged else plot
        self.arrange(self.enlarged, self.presenter.hyperbola is not None)
        self._drawn = ()
        self.refresh()

    def begin_fit(self) -> None:
        """Let the operator drag a hyperbola over the enlarged line."""
        # A hyperbola is one of echoes: a focused image has none.
        self.presenter.change(source=Source.ECHOES)
        self.presenter.begin_hyperbola()
        if self.presenter.hyperbola is not None:
            self.enlarged = None
            self.enlarge(self.line_plot)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw what came while the tab was hidden."""
        super().showEvent(event)
        self.refresh()

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        self.marker.setText(self.tr("Marker"))
        self.settings.setText(self.tr("Picture"))
        self.drop.setText(self.tr("Cancel"))
        self._drawn = ()
        self._write(RadarPictures(None, self.presenter.settings.depth_m, None, None, None, None))
        self.refresh()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        super().restyle()
        self._drawn = ()

    def _draw(self) -> None:
        presenter = self.presenter
        shown, colours = presenter.pictures(), presenter.settings.colours
        texts = self._texts
        notice = texts.slice_notice(presenter, shown, self._problem)
        self.trace_plot.show_curve(shown.curve)
        self.line_plot.show_picture(shown.line, colours, texts.line_notice(presenter, shown))
        self.slice_plot.show_picture(shown.slice, colours, notice)
        self._mark(shown)
        for bar in (self.bar, self.top_bar):
            picture = shown.slice or shown.line
            signed = picture is not None and picture.signed
            scale = None if picture is None else picture.scale
            bar.show_scale(
                scale,
                colours if signed else Colours.ENVELOPE,
                self.presenter.shows_focused,
            )
        self._bound_depth()
        self._write(shown)

    def _mark(self, shown: RadarPictures) -> None:
        presenter, place, line = self.presenter, shown.place, shown.line
        marked: List[Marked] = [*presenter.candidates, *self._markers]
        if shown.curve is not None:
            second = presenter.second_of(shown.depth_m, shown.curve.axis)
            self.trace_plot.set_crosshair(None, second)
        if line is not None and place is not None:
            second = presenter.second_of(shown.depth_m, line.axis)
            self.line_plot.set_crosshair(place.along(line.across), second)
            # Nothing lies over the hyperbola while it is fitted.
            hidden = presenter.hyperbola is not None or line.axis is not Axis.DEPTH_MM
            self.line_plot.set_spots(
                ()
                if hidden
                else line_spots(marked, place, line.across, self.enlarged is self.line_plot)
            )
            self._show_hyperbola(line)
        if place is not None:
            self.slice_plot.set_crosshair(place.x_mm, place.y_mm)
        self.slice_plot.set_spots(
            slice_spots(marked, shown.depth_m, self.enlarged is self.slice_plot)
        )

    def _show_hyperbola(self, line: Picture) -> None:
        hyperbola = self.presenter.hyperbola
        across, second = self.presenter.hyperbola_points(line)
        apex = None
        if hyperbola is not None:
            number = int(abs(across - hyperbola.across_mm).argmin())
            apex = (float(across[number]), float(second[number]))
        self.line_plot.set_hyperbola(across, second, apex)

    def _bound_depth(self) -> None:
        deepest = self.presenter.deepest_m
        for widget in (self.depth_slider, self.shallower, self.deeper):
            widget.setEnabled(deepest is not None)
        self.depth_slider.blockSignals(True)
        if deepest is not None:
            self.depth_slider.setMaximum(max(1, int(deepest / DEPTH_STEP_M + 1e-6)))
        self.depth_slider.setValue(round(self.presenter.settings.depth_m / DEPTH_STEP_M))
        self.depth_slider.blockSignals(False)

    def _write(self, shown: RadarPictures) -> None:
        presenter, texts = self.presenter, self._texts
        self.trace_plot.set_labels("dB", texts.second(shown.curve))
        second = texts.second(shown.line)
        self.line_plot.set_labels(texts.across(presenter.settings.along), second)
        self.slice_plot.set_labels(self.tr("X mm"), self.tr("Y mm"))
        self.readout = texts.readout(self.presenter, shown)
        for plot, key, title in (
            (self.trace_plot, self.trace_key, texts.trace_title(presenter, shown)),
            (self.line_plot, self.line_key, texts.line_title(presenter, shown)),
            (self.slice_plot, self.slice_key, texts.slice_title(shown)),
        ):
            first, _line_end, second = title.partition("\n")
            enlarged = f"{first} ⤡\n{self.readout}"
            key.setText(enlarged if plot is self.enlarged else f"{first} ⤢\n{second}".strip())
        self.note.setText(texts.note(presenter))
        self.along.setText(texts.along_key(presenter.settings.along))
        self.source.setText(texts.source_key(presenter))
        hyperbola = presenter.hyperbola
        value = presenter.settings.permittivity if hyperbola is None else hyperbola.permittivity
        self.fit_text.setText(self.tr("Permittivity {value:.1f}").format(value=value))
        self.use.setText(self.tr("Use {value:.1f}").format(value=value))
        grid = presenter.model.grid
        self.source.setEnabled(grid is not None)
        self.marker.setEnabled(self._can_mark and shown.place is not None)

    def _step_depth(self, steps: int) -> None:
        self.presenter.step_depth(steps)
        self.refresh()

    def _on_slider(self, steps: int) -> None:
        self.presenter.set_depth(steps * DEPTH_STEP_M)
        self._refresh_soon()

    def _on_along(self) -> None:
        along = Axis.Y_MM if self.presenter.settings.along is Axis.X_MM else Axis.X_MM
        self.presenter.end_hyperbola()
        self.presenter.change(along=along)
        self.refresh()

    def _on_source(self) -> None:
        focused = self.presenter.settings.source is Source.ECHOES
        self.presenter.change(source=Source.FOCUSED if focused else Source.ECHOES)
        self.refresh()

    def _on_use(self) -> None:
        self.presenter.take_permittivity()
        self.enlarge(None)

    def _on_drop(self) -> None:
        self.presenter.end_hyperbola()
        self.enlarge(None)

    def _on_marker(self) -> None:
        place = self.presenter.place
        if place is not None:
            depth_mm = self.presenter.settings.depth_m * 1000.0
            self.marker_wanted.emit(place.x_mm, place.y_mm, depth_mm)

    def _on_slice(self, x_mm: float, y_mm: float) -> None:
        self.presenter.touch_slice(x_mm, y_mm)
        self._refresh_soon()

    def _on_curve(self, _level: float, second: float) -> None:
        axis = self.trace_plot.axis
        self.presenter.touch_curve(second, axis)
        self._refresh_soon()

    def _on_line_touched(self, across_mm: float, second: float) -> None:
        plot = self.line_plot
        self._grip = Grip.FLANK
        if plot.grip is not None:
            away = plot.to_screen(across_mm, second) - plot.to_screen(*plot.grip)
            if abs(away.x()) + abs(away.y()) <= look_of(self).px(GRIP_RADIUS_PX):
                self._grip = Grip.APEX
        self._on_line(across_mm, second)

    def _on_line(self, across_mm: float, second: float) -> None:
        axis = self.line_plot.axis
        if self.presenter.hyperbola is None:
            self.presenter.touch_line(across_mm, second, axis)
        else:
            self.presenter.drag_hyperbola(self._grip, across_mm, second, axis)
        self._refresh_soon()

    def _refresh_soon(self) -> None:
        if not self._slow.isActive():
            self._slow.start()

    def _connect(self) -> None:
        self._grip = Grip.FLANK
        self._slow.setInterval(DRAG_MS)
        self._slow.setSingleShot(True)
        self._slow.timeout.connect(self.refresh)
        for button, act in (
            (self.trace_key, lambda: self.enlarge(self.trace_plot)),
            (self.line_key, lambda: self.enlarge(self.line_plot)),
            (self.slice_key, lambda: self.enlarge(self.slice_plot)),
            (self.shallower, lambda: self._step_depth(-1)),
            (self.deeper, lambda: self._step_depth(+1)),
            (self.along, self._on_along),
            (self.source, self._on_source),
            (self.marker, self._on_marker),
            (self.use, self._on_use),
            (self.drop, self._on_drop),
        ):
            connect_click(button, act)
        self.depth_slider.valueChanged.connect(self._on_slider)
        for plot, on_touch in (
            (self.slice_plot, self._on_slice),
            (self.trace_plot, self._on_curve),
        ):
            plot.touched.connect(on_touch)
            plot.dragged.connect(on_touch)
        self.line_plot.touched.connect(self._on_line_touched)
        self.line_plot.dragged.connect(self._on_line)

"""The RADAR tab: the last trace, the line it belongs to, the slice of the whole area."""

from __future__ import annotations

from typing import Optional, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QShowEvent
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QSlider, QVBoxLayout

from gpr20_user_interface.mid.map_grid import Cell
from gpr20_user_interface.mid.radar_model import MIN_BACKGROUND_TRACES, RadarModel
from gpr20_user_interface.mid.radar_pictures import (
    DEPTH_STEP_M,
    Axis,
    RadarSettings,
    a_scan,
    b_scan,
    c_scan,
    depths_m,
)
from gpr20_user_interface.views.look import TOUCH_PX, look_of
from gpr20_user_interface.views.plots import CurvePlot, PicturePlot
from gpr20_user_interface.views.radar_controls import RadarControls
from gpr20_user_interface.views.translation import TranslatedWidget

SHALLOWEST_STEPS = 0


class RadarView(TranslatedWidget):
    """Draws the echoes of a RadarModel; `refresh` follows it."""

    def __init__(self, model: RadarModel) -> None:
        super().__init__()
        self._model = model
        self._drawn: Optional[Tuple[RadarModel, int, RadarSettings]] = None
        self.trace_plot = CurvePlot()
        self.line_plot = PicturePlot(true_to_scale=False)
        self.slice_plot = PicturePlot(true_to_scale=True)
        self.depth_slider = QSlider(Qt.Orientation.Vertical)
        self.controls = RadarControls()
        self.note = QLabel()
        self._lay_out()
        self.controls.changed.connect(lambda _settings: self.refresh())
        self.depth_slider.valueChanged.connect(
            lambda steps: self.controls.set_depth(round(steps * DEPTH_STEP_M, 4))
        )
        self.retranslate()

    def show_model(self, model: RadarModel) -> None:
        """Follow another survey."""
        self._model = model
        self.refresh()

    def refresh(self) -> None:
        """Draw again if something has changed and the tab is visible."""
        state = (self._model, self._model.revision, self.controls.settings)
        if not self.isVisible() or state == self._drawn:
            return
        grid = self._model.grid
        if grid is not None:
            self.controls.set_rotations(grid.rotations_deg)
        self._drawn = (self._model, self._model.revision, self.controls.settings)
        self._bound_slider()
        self._draw()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw what came while the tab was hidden."""
        super().showEvent(event)
        self.refresh()

    def _draw(self) -> None:
        settings, model = self.controls.settings, self._model
        latest = model.latest
        curve = None if latest is None else a_scan(model, latest, settings)
        line = None if latest is None else b_scan(model, latest.stop.row, settings)
        area = c_scan(model, settings)
        self.trace_plot.show_curve(curve, settings.in_db)
        self.line_plot.show_picture(line, settings.in_db)
        self.slice_plot.show_picture(area, settings.in_db)
        axis = Axis.DELAY_NS if curve is None else curve.axis
        self._label_plots(latest, axis)
        self._show_note()

    def _label_plots(self, latest: Optional[Cell], axis: Axis) -> None:
        grid, settings = self._model.grid, self.controls.settings
        down = self.tr("Depth mm") if axis is Axis.DEPTH_MM else self.tr("Delay ns")
        level = self.tr("Level dB") if settings.in_db else self.tr("Level")
        self.trace_plot.set_labels(level, down)
        self.line_plot.set_labels(self.tr("X mm"), down)
        self.slice_plot.set_labels(self.tr("X mm"), self.tr("Y mm"))
        self.trace_plot.set_title(self.tr("Last trace"))
        line = self.tr("Line")
        if latest is not None and grid is not None:
            y_mm = grid.ys_mm[latest.stop.row]
            line = self.tr("Line at Y {y:g} mm").format(y=round(float(y_mm), 2))
        self.line_plot.set_title(line)
        depth_mm = settings.depth_m * 1000.0
        self.slice_plot.set_title(self.tr("Slice at depth {depth:.0f} mm").format(depth=depth_mm))

    def _show_note(self) -> None:
        model, settings = self._model, self.controls.settings
        parts = []
        if model.grid is not None and model.grid.simulated:
            parts.append(self.tr("SIMULATED"))
        if model.grid is not None:
            counted = self.tr("{count} of {planned} traces")
            parts.append(counted.format(count=model.count, planned=model.grid.planned))
        if model.given_up:
            text = self.tr("cannot be shown: {count}")
            parts.append(text.format(count=len(model.given_up)))
        if model.count and depths_m(model, settings.permittivity) is None:
            parts.append(self.tr("no height was measured: the depth is unknown"))
        if settings.remove_background and model.background(settings.polarization) is None:
            text = self.tr("background is not removed from fewer than {count} traces")
            parts.append(text.format(count=MIN_BACKGROUND_TRACES))
        parts.append(self.tr("Grey: not measured. No echo does not mean no mine."))
        self.note.setText(" · ".join(parts))

    def _bound_slider(self) -> None:
        depths = depths_m(self._model, self.controls.settings.permittivity)
        self.depth_slider.setEnabled(depths is not None)
        if depths is not None:
            self.depth_slider.setRange(
                SHALLOWEST_STEPS, max(1, round(float(depths[-1]) / DEPTH_STEP_M))
            )

    def restyle(self) -> None:
        """Take the sizes of the look."""
        self.depth_slider.setFixedWidth(look_of(self).px(TOUCH_PX))

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        self._label_plots(self._model.latest, Axis.DEPTH_MM)
        self._show_note()
        self._drawn = None

    def _lay_out(self) -> None:
        self.depth_slider.setInvertedAppearance(True)
        self.depth_slider.setRange(SHALLOWEST_STEPS, 100)
        self.depth_slider.setPageStep(1)
        self.depth_slider.setValue(round(self.controls.settings.depth_m / DEPTH_STEP_M))
        self.note.setWordWrap(True)
        self.note.setObjectName("note")
        plots = QHBoxLayout()
        plots.setSpacing(2)
        plots.addWidget(self.trace_plot, 4)
        plots.addWidget(self.line_plot, 7)
        plots.addWidget(self.slice_plot, 7)
        plots.addWidget(self.depth_slider)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.setSpacing(4)
        layout.addWidget(self.note)
        layout.addLayout(plots, 1)
        layout.addWidget(self.controls)

"""The MAP tab: the drawing, its legend, the stop that was touched and its trace."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QShowEvent
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from gpr20_user_interface.mid.map_coverage import StopState
from gpr20_user_interface.mid.map_grid import Cell, Stop
from gpr20_user_interface.mid.map_model import MapModel
from gpr20_user_interface.mid.radar_model import RadarModel
from gpr20_user_interface.mid.radar_pictures import a_scan
from gpr20_user_interface.mid.radar_records import Axis, RadarSettings
from gpr20_user_interface.views.look import look_of
from gpr20_user_interface.views.map_canvas import STOP_MARKS, MapCanvas
from gpr20_user_interface.views.plots import CurvePlot
from gpr20_user_interface.views.translation import TranslatedWidget, shown_text
from gpr20_user_interface.views.widgets import new_button

PANEL_WIDTH_PX = 290
SWATCH_PX = 16


class MapView(TranslatedWidget):
    """Follows a MapModel and the traces in a RadarModel; `refresh` draws them.

    Attributes:
        selected: The stop that was touched and the polarization that is shown of it.
    """

    def __init__(self, model: MapModel, radar: RadarModel) -> None:
        super().__init__()
        self._model = model
        self._radar = radar
        self.selected: Optional[Cell] = None
        self._drawn: Tuple[object, ...] = ()
        self.canvas = MapCanvas(model)
        self.legend: Dict[StopState, QLabel] = {state: QLabel() for state in StopState}
        self._swatches: Dict[StopState, QLabel] = {}
        self._panel = QWidget()
        self.verdict = QLabel()
        self.stop_text = QLabel()
        self.trace_plot = CurvePlot()
        self.next_problem = new_button(self._on_next_problem)
        self.polarization = new_button(self._on_polarization)
        self._lay_out()
        self.canvas.stop_touched.connect(self.select)
        self.retranslate()

    def show_models(self, model: MapModel, radar: RadarModel) -> None:
        """Follow another survey."""
        self._model, self._radar = model, radar
        self.selected = None
        self.canvas.set_model(model)
        self.canvas.set_selected(None)
        self.refresh()

    def set_carriage(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas are [mm]; None: not known."""
        if self.isVisible():
            self.canvas.set_carriage(place_mm)

    def select(self, stop: Stop) -> None:
        """Show a stop and its trace."""
        number = 0 if self.selected is None else self.selected.polarization
        self.selected = Cell(stop, number)
        self.canvas.set_selected(stop)
        self.refresh()

    def refresh(self) -> None:
        """Draw again if something has changed and the tab is visible."""
        model, radar = self._model, self._radar
        state = (
            *(model, model.revision, model.current, model.verdict),
            *(radar, radar.revision, self.selected),
        )
        if not self.isVisible() or state == self._drawn:
            return
        self._drawn = state
        if self.selected is not None and not self._is_planned(self.selected):
            self.selected = None
            self.canvas.set_selected(None)
        self.canvas.update()
        self._show_legend()
        self._show_stop()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw what came while the tab was hidden."""
        super().showEvent(event)
        self.refresh()

    def _is_planned(self, cell: Cell) -> bool:
        grid = self._model.grid
        if grid is None:
            return False
        rows, columns = grid.shape
        known = cell.polarization < len(grid.rotations_deg)
        return known and cell.stop.row < rows and cell.stop.column < columns

    def _show_legend(self) -> None:
        counts = self._model.counts()
        for state, label in self.legend.items():
            number = "—" if counts is None else str(counts[state])
            label.setText(f"{self._name(state)}: {number}")
        verdict = self._model.verdict
        self.verdict.setText("" if verdict is None else shown_text(verdict))
        self.next_problem.setEnabled(self._model.next_problem(None) is not None)

    def _show_stop(self) -> None:
        grid, cell = self._model.grid, self.selected
        self.polarization.setEnabled(grid is not None and len(grid.rotations_deg) > 1)
        if grid is None or cell is None:
            self.stop_text.setText(self.tr("Touch a stop to see its trace."))
            self.polarization.setText(self.tr("Antenna"))
            self.trace_plot.show_curve(None)
            return
        x_mm, y_mm = grid.xs_mm[cell.stop.column], grid.ys_mm[cell.stop.row]
        state = self._model.state_at(cell.stop)
        words = "—" if state is None else self._name(state)
        text = self.tr("X {x:g} mm, Y {y:g} mm: {state}").format(
            x=round(float(x_mm), 2), y=round(float(y_mm), 2), state=words
        )
        reasons = [shown_text(reason) for reason in self._model.reasons_at(cell.stop)]
        has_trace = self._radar.grid is not None and self._radar.has(cell)
        if not has_trace:
            reasons.append(self._why_no_trace(grid.index(cell)))
        self.stop_text.setText("\n".join([text, *reasons]))
        rotation_deg = grid.rotations_deg[cell.polarization]
        self.polarization.setText(self.tr("Antenna {rotation:g}°").format(rotation=rotation_deg))
        curve = a_scan(self._radar, cell, RadarSettings()) if has_trace else None
        self.trace_plot.show_curve(curve)
        if curve is not None:
            self._label_plot(curve.axis)

    def _why_no_trace(self, index: int) -> str:
        given_up = self._radar.given_up.get(index)
        return self.tr("no trace to show") if given_up is None else shown_text(given_up)

    def _on_next_problem(self) -> None:
        after = None if self.selected is None else self.selected.stop
        stop = self._model.next_problem(after)
        if stop is not None:
            self.select(stop)

    def _on_polarization(self) -> None:
        grid = self._model.grid
        if grid is not None and self.selected is not None:
            number = (self.selected.polarization + 1) % len(grid.rotations_deg)
            self.selected = Cell(self.selected.stop, number)
            self.refresh()

    def _name(self, state: StopState) -> str:
        return {
            StopState.DONE: self.tr("Done"),
            StopState.PARTLY: self.tr("Partly"),
            StopState.MISSING: self.tr("Missing"),
            StopState.FAILED: self.tr("Failed"),
        }[state]

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        self.next_problem.setText(self.tr("Next\nunfinished stop"))
        self._label_plot(Axis.DEPTH_MM)
        self._drawn = ()
        self._show_legend()
        self._show_stop()

    def restyle(self) -> None:
        """Take the sizes and colours of the look."""
        look = look_of(self)
        self._panel.setFixedWidth(look.px(PANEL_WIDTH_PX))
        for state, swatch in self._swatches.items():
            swatch.setFixedSize(look.px(SWATCH_PX), look.px(SWATCH_PX))
            colour = look.colour(STOP_MARKS[state])
            swatch.setStyleSheet(f"background: {colour};")

    def _label_plot(self, axis: Axis) -> None:
        down = self.tr("Depth mm") if axis is Axis.DEPTH_MM else self.tr("Delay ns")
        self.trace_plot.set_labels(self.tr("Level dB"), down)

    def _lay_out(self) -> None:
        panel = self._panel
        column = QVBoxLayout(panel)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addLayout(self._new_legend())
        for label in (self.verdict, self.stop_text):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
            column.addWidget(label)
        column.addWidget(self.trace_plot, 1)
        buttons = QHBoxLayout()
        buttons.addWidget(self.next_problem)
        buttons.addWidget(self.polarization)
        column.addLayout(buttons)
        row = QHBoxLayout(self)
        row.setContentsMargins(4, 4, 4, 4)
        row.addWidget(self.canvas, 1)
        row.addWidget(panel)

    def _new_legend(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(3)
        order = (StopState.DONE, StopState.PARTLY, StopState.MISSING, StopState.FAILED)
        for number, state in enumerate(order):
            swatch = QLabel()
            self._swatches[state] = swatch
            row, pair = divmod(number, 2)
            grid.addWidget(swatch, row, 2 * pair)
            grid.addWidget(self.legend[state], row, 2 * pair + 1)
        for column in (1, 3):
            grid.setColumnStretch(column, 1)
        return grid

"""The trace of a stop, over the whole tab."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import Cell
from gpr20_operator.ground.map_model import MapModel
from gpr20_operator.ground.pictures import a_scan
from gpr20_operator.ground.records import Axis, RadarSettings
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.pages.ground.map_selection import select_cell
from gpr20_user_interface.pages.ground.map_texts import place_lines
from gpr20_user_interface.pages.ground.plots import CurvePlot
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button


class TraceSheet(Overlay):
    """Shows the A-scan of a stop and changes its polarization."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._model = MapModel()
        self._radar = RadarModel()
        self.cell: Optional[Cell] = None
        self.title = QLabel()
        self.title.setTextFormat(Qt.TextFormat.PlainText)
        self.title.setWordWrap(True)
        self.plot = CurvePlot()
        self.polarization = new_button(self._on_polarization)
        self.close_button = new_button(self.hide)
        self._lay_out()
        self.retranslate()

    def show_trace(self, model: MapModel, radar: RadarModel, cell: Cell) -> None:
        """Open with the trace of a stop."""
        self._model, self._radar, self.cell = model, radar, cell
        self.open()
        self._show()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.close_button.setText(self.tr("Close"))
        self._show()

    def _show(self) -> None:
        grid, cell = self._model.grid, self.cell
        self.polarization.setEnabled(grid is not None and len(grid.rotations_deg) > 1)
        if grid is None or cell is None:
            self.plot.show_curve(None)
            return
        lines = place_lines(select_cell(grid, cell), self._model, self._radar)
        self.title.setText(" ".join(shown_text(one) for one in lines))
        rotation_deg = grid.rotations_deg[cell.polarization]
        self.polarization.setText(self.tr("Antenna {rotation:g}°").format(rotation=rotation_deg))
        has_trace = self._radar.grid is not None and self._radar.has(cell)
        curve = a_scan(self._radar, cell, RadarSettings()) if has_trace else None
        self.plot.show_curve(curve)
        axis = Axis.DEPTH_MM if curve is None else curve.axis
        down = self.tr("Depth mm") if axis is Axis.DEPTH_MM else self.tr("Delay ns")
        self.plot.set_labels(self.tr("Level dB"), down)

    def _on_polarization(self) -> None:
        grid, cell = self._model.grid, self.cell
        if grid is not None and cell is not None:
            number = (cell.polarization + 1) % len(grid.rotations_deg)
            self.cell = Cell(cell.stop, number)
            self._show()

    def _lay_out(self) -> None:
        keys = QHBoxLayout()
        keys.addWidget(self.polarization, 1)
        keys.addWidget(self.close_button, 1)
        column = QVBoxLayout(self)
        column.addWidget(self.title)
        column.addWidget(self.plot, 1)
        column.addLayout(keys)

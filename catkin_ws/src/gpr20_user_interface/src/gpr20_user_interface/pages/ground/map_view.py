"""The MAP tab: the drawing, its legend, and the place that was touched."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

import numpy as np
from PyQt5.QtCore import QSize, pyqtSignal
from PyQt5.QtGui import QPixmap, QShowEvent
from PyQt5.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QVBoxLayout,
    QWidget,
)

from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.grid import Cell, Stop
from gpr20_operator.ground.map_model import MapModel
from gpr20_user_interface.look.look import GAP_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, sentence_text, shown_text
from gpr20_user_interface.pages.ground.map_canvas import MapCanvas, stops_image
from gpr20_user_interface.pages.ground.map_patterns import StopPattern
from gpr20_user_interface.pages.ground.map_selection import (
    Mark,
    Selection,
    next_candidate,
    select_cell,
    select_mark,
    select_place,
)
from gpr20_user_interface.pages.ground.map_texts import STATE_NAMES, place_lines, summary_lines
from gpr20_user_interface.widgets.labels import PulledText
from gpr20_user_interface.widgets.widgets import new_button

PANEL_WIDTH_PX = 416
SWATCH_PX = 24


class MapView(TranslatedWidget):
    """Follows a MapModel, the traces in a RadarModel and what belongs to the survey.

    Attributes:
        selected: The place that was touched; None: none.
    """

    # A Cell whose trace is to be shown.
    trace_wanted = pyqtSignal(object)
    # X and Y in mm, and the depth in mm or None.
    marker_wanted = pyqtSignal(float, float, object)
    markers_wanted = pyqtSignal()
    # A Selection, or None: the plan that is kept.
    finer_wanted = pyqtSignal(object)
    opened = pyqtSignal()

    def __init__(self, model: MapModel, radar: RadarModel, additions: AdditionsPresenter) -> None:
        super().__init__()
        self._model = model
        self._radar = radar
        self._additions = additions
        self.selected: Optional[Selection] = None
        self._drawn: Tuple[object, ...] = ()
        self.canvas = MapCanvas(model, additions)
        self.legend: Dict[StopState, QLabel] = {state: QLabel() for state in StopState}
        self.swatches: Dict[StopState, QLabel] = {state: QLabel() for state in StopState}
        self.text = PulledText()
        self.next_problem = new_button(self._on_next_problem)
        self.next_candidate = new_button(self._on_next_candidate)
        self.trace = new_button(self._on_trace)
        self.set_marker = new_button(self._on_marker)
        self.markers = new_button(self.markers_wanted.emit)
        self.finer = new_button(self._on_finer)
        self._panel = QWidget()
        self._keys, self._row = QGridLayout(), QHBoxLayout()
        self._lay_out()
        self.canvas.touched.connect(self._on_touch)
        self.retranslate()
        self.restyle()

    @property
    def radar_model(self) -> RadarModel:
        """The traces of the survey that is shown."""
        return self._radar

    def show_models(self, model: MapModel, radar: RadarModel) -> None:
        """Follow another survey."""
        self._model, self._radar = model, radar
        self.canvas.set_model(model)
        self.select(None)

    def set_carriage(self, place_mm: Optional[Tuple[float, float]]) -> None:
        """Note where the antennas are [mm]; None: not known."""
        if self.isVisible():
            self.canvas.set_carriage(place_mm)

    def select(self, selected: Optional[Selection]) -> None:
        """Show a place; None: none."""
        self.selected = selected
        self.canvas.set_selected(selected)
        self.refresh()

    def select_stop(self, stop: Stop) -> None:
        """Show a stop."""
        if self._model.grid is not None:
            number = 0 if self.selected is None else self.selected.cell.polarization
            self.select(select_cell(self._model.grid, Cell(stop, number)))

    def select_mark(self, mark: Mark) -> None:
        """Show a candidate or a marker."""
        if self._model.grid is not None:
            self.select(select_mark(self._model.grid, mark))

    def refresh(self) -> None:
        """Draw again if something has changed and the tab is visible."""
        model, radar, additions = self._model, self._radar, self._additions
        state = (
            *(model, model.revision, model.current, model.verdict),
            *(radar, radar.revision, self.selected, additions.revision),
        )
        if not self.isVisible() or state == self._drawn:
            return
        self._drawn = state
        if self.selected is not None and not self._is_there(self.selected):
            self.selected = None
            self.canvas.set_selected(None)
        self.canvas.update()
        self._show_legend()
        self._show_place()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 (Qt's name)
        """Draw what came while the tab was hidden."""
        super().showEvent(event)
        self.opened.emit()
        self.refresh()

    def restyle(self) -> None:
        """Take the sizes and colours of the look."""
        look = look_of(self)
        self._panel.setFixedWidth(look.px(PANEL_WIDTH_PX))
        for spaced in (self._keys, self._panel.layout(), self._row):
            spaced.setSpacing(look.px(GAP_PX))
        size = look.px(SWATCH_PX)
        pattern = StopPattern((1, 1), (size, size))
        for state, swatch in self.swatches.items():
            image = stops_image(pattern, np.array([[state]], np.uint8), look)
            swatch.setPixmap(QPixmap.fromImage(image))
            swatch.setFixedSize(QSize(size + 2, size + 2))

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.next_problem.setText(self.tr("Next\nunfinished"))
        self.next_candidate.setText(self.tr("Next\ncandidate"))
        self.trace.setText(self.tr("Trace"))
        self.set_marker.setText(self.tr("Set\nmarker"))
        self._drawn = ()
        self._show_legend()
        self._show_place()

    def _is_there(self, selected: Selection) -> bool:
        """Return whether the survey still has what is selected."""
        grid, cell = self._model.grid, selected.cell
        if grid is None:
            return False
        rows, columns = grid.shape
        known = cell.polarization < len(grid.rotations_deg)
        marks = (*self._additions.candidates, *self._additions.markers)
        return (
            known
            and cell.stop.row < rows
            and cell.stop.column < columns
            and (selected.mark is None or selected.mark in marks)
        )

    def _show_legend(self) -> None:
        counts = self._model.counts()
        for state, label in self.legend.items():
            number = "—" if counts is None else str(counts[state])
            label.setText(f"{shown_text(STATE_NAMES[state])}: {number}")
        additions = self._additions
        self.next_problem.setEnabled(self._model.next_problem(None) is not None)
        self.next_candidate.setEnabled(bool(additions.candidates))
        # Not inside an f-string, where xgettext finds no text.
        title = self.tr("Markers")
        self.markers.setText(f"{title}\n{len(additions.markers)}")
        self.markers.setEnabled(bool(additions.markers))

    def _show_place(self) -> None:
        selected = self.selected
        there = selected is not None and self._model.grid is not None
        self.trace.setEnabled(there)
        self.set_marker.setEnabled(there and self._additions.can_mark)
        kept = not there and self._additions.plan is not None
        self.finer.setText(self.tr("Finer\nplan") if kept else self.tr("Measure\nfiner"))
        grid = self._model.grid
        has_plan = grid is not None and grid.plan is not None
        self.finer.setEnabled(kept or (there and has_plan and self._additions.can_mark))
        lines = (
            summary_lines(self._model, self._additions)
            if selected is None or not there
            else place_lines(selected, self._model, self._radar)
        )
        self.text.setText("\n".join(sentence_text(one) for one in lines))

    def _on_touch(self, x_mm: float, y_mm: float, reach_mm: float) -> None:
        grid, additions = self._model.grid, self._additions
        if grid is not None:
            marks: Tuple[Mark, ...] = (*additions.candidates, *additions.markers)
            self.select(select_place(grid, marks, (x_mm, y_mm), reach_mm, self.selected))

    def _on_next_problem(self) -> None:
        after = None if self.selected is None else self.selected.cell.stop
        stop = self._model.next_problem(after)
        if stop is not None:
            self.select_stop(stop)

    def _on_next_candidate(self) -> None:
        candidate = next_candidate(self._additions.candidates, self.selected)
        if candidate is not None:
            self.select_mark(candidate)

    def _on_trace(self) -> None:
        if self.selected is not None:
            self.trace_wanted.emit(self.selected.cell)

    def _on_marker(self) -> None:
        if self.selected is not None:
            selected = self.selected
            self.marker_wanted.emit(selected.x_mm, selected.y_mm, selected.depth_mm)

    def _on_finer(self) -> None:
        self.finer_wanted.emit(self.selected)

    def _lay_out(self) -> None:
        column = QVBoxLayout(self._panel)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(self._new_legend())
        column.addWidget(self.text, 1)
        buttons = (
            *(self.next_problem, self.next_candidate, self.trace),
            *(self.set_marker, self.markers, self.finer),
        )
        for number, button in enumerate(buttons):
            self._keys.addWidget(button, *divmod(number, 3))
            self._keys.setColumnStretch(number % 3, 1)
        column.addLayout(self._keys)
        self._row.addWidget(self.canvas, 1)
        self._row.addWidget(self._panel)
        whole = QVBoxLayout(self)
        whole.setContentsMargins(4, 4, 4, 4)
        whole.addLayout(self._row, 1)

    def _new_legend(self) -> QGridLayout:
        grid = QGridLayout()
        grid.setSpacing(4)
        order = (StopState.DONE, StopState.PARTLY, StopState.MISSING, StopState.FAILED)
        for number, state in enumerate(order):
            self.swatches[state].setObjectName("swatch")
            row, pair = divmod(number, 2)
            grid.addWidget(self.swatches[state], row, 2 * pair)
            grid.addWidget(self.legend[state], row, 2 * pair + 1)
        for column in (1, 3):
            grid.setColumnStretch(column, 1)
        return grid

"""Planning a small survey around a place: size, distance of the stops, and what that takes."""

from __future__ import annotations

from functools import partial
from typing import Callable, Optional, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.ground.finer_plan import (
    SIZES_MM,
    SPACING_STEP_MM,
    FinerPlan,
    clipped_spacing,
    plan_finer,
    proposed_spacing,
    spacing_of,
)
from gpr20_operator.ground.grid import SurveyGrid
from gpr20_operator.words import duration
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.look.translation import shown_number, shown_text
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button

# Returns how long a survey takes [s]; None: not known.
Duration = Callable[[SurveyParameters], Optional[float]]


class FinerSheet(Overlay):
    """Shows a FinerPlan and changes it; nothing moves by it.

    Attributes:
        plan: What it shows; None: nothing that the robot can measure.
    """

    # A FinerPlan that is to be measured now, or kept while a survey runs.
    chosen = pyqtSignal(object)
    # The plan that was kept is not wanted any more.
    dropped = pyqtSignal()

    def __init__(self, window: QWidget, duration: Duration) -> None:
        super().__init__(window)
        self._duration = duration
        self._grid: Optional[SurveyGrid] = None
        self._place_mm: Tuple[float, float] = (0.0, 0.0)
        self._size_mm = SIZES_MM[0]
        self._spacing_mm = 1.0
        self._problem = ""
        self._running = False
        self.plan: Optional[FinerPlan] = None
        self.title, self.size_title, self.spacing_title = QLabel(), QLabel(), QLabel()
        self.spacing, self.figures, self.note = QLabel(), QLabel(), QLabel()
        self.sizes = [new_button(partial(self._choose, one), f"{one:g} mm") for one in SIZES_MM]
        self.closer = new_button(lambda: self._choose(change_mm=-SPACING_STEP_MM), "-")
        self.wider = new_button(lambda: self._choose(change_mm=SPACING_STEP_MM), "+")
        self.use, self.close_button = new_button(self._on_use), new_button(self.hide)
        self.drop = new_button(self.dropped.emit)
        self.drop.clicked.connect(self.hide)
        self._lay_out()
        self.retranslate()

    def show_place(self, grid: SurveyGrid, x_mm: float, y_mm: float) -> None:
        """Open with a plan around a place of a survey."""
        self._grid, self._place_mm = grid, (x_mm, y_mm)
        self._spacing_mm = proposed_spacing(grid)
        self.drop.hide()
        self.open()
        self._choose(SIZES_MM[0])

    def show_plan(self, grid: SurveyGrid, plan: FinerPlan) -> None:
        """Open with a plan that was kept, for this survey or another one of this robot."""
        self._grid, self._place_mm = grid, (plan.x_mm, plan.y_mm)
        self._size_mm, self._spacing_mm = plan.size_mm, plan.spacing_mm
        self.plan = plan
        self.drop.show()
        self.open()
        self._show()

    def note_running(self, running: bool) -> None:
        """Note whether a survey runs: then a plan can only be kept."""
        if running != self._running:
            self._running = running
            self._show()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.size_title.setText(self.tr("Area"))
        self.spacing_title.setText(self.tr("Spacing"))
        self.drop.setText(self.tr("Drop plan"))
        self.close_button.setText(self.tr("Close"))
        self._show()

    def _choose(self, size_mm: Optional[float] = None, change_mm: float = 0.0) -> None:
        """Plan with another size, or another distance of the stops."""
        if self._grid is None:
            return
        self._size_mm = self._size_mm if size_mm is None else size_mm
        self._spacing_mm = clipped_spacing(self._spacing_mm + change_mm)
        try:
            self.plan = plan_finer(self._grid, *self._place_mm, self._size_mm, self._spacing_mm)
        except InvalidValueError as error:
            self.plan, self._problem = None, shown_text(error.message)
        self._show()

    def _show(self) -> None:
        x_mm, y_mm = self._place_mm
        title = Message("Measure finer around X {x:.0f} mm, Y {y:.0f} mm", x=x_mm, y=y_mm)
        self.title.setText(shown_text(title))
        for key, size_mm in zip(self.sizes, SIZES_MM):
            key.setChecked(size_mm == self._size_mm)
        self.spacing.setText(f"{shown_number(self._spacing_mm)} mm")
        self.use.setText(self.tr("Keep for later") if self._running else self.tr("To the plan"))
        self.use.setEnabled(self.plan is not None)
        self.figures.setText(self._problem if self.plan is None else self._figures(self.plan))
        note = self.tr("Spacing of this survey: {spacing} mm. Nothing moves before START.")
        if self._running:
            note = self.tr("A survey is running. The plan is kept until it has ended.")
        present = "" if self._grid is None else shown_number(spacing_of(self._grid), ".4g")
        self.note.setText(note.format(spacing=present))

    def _figures(self, plan: FinerPlan) -> str:
        p = plan.parameters
        area = Message(
            "X {left:g} to {right:g} mm, Y {low:g} to {high:g} mm",
            **dict(left=p.x_start_mm, right=p.x_stop_mm, low=p.y_start_mm, high=p.y_stop_mm),
        )
        count = self.tr("{columns} x {rows} stops, {traces} traces").format(
            columns=p.x_points, rows=p.y_points, traces=p.total_points
        )
        duration_s = self._duration(p)
        time = "—" if duration_s is None else shown_text(duration(duration_s))
        return "\n".join([shown_text(area), count, self.tr("Time: {time}").format(time=time)])

    def _on_use(self) -> None:
        if self.plan is not None:
            self.hide()
            self.chosen.emit(self.plan)

    def _lay_out(self) -> None:
        self.title.setObjectName("title")
        self.spacing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        for label in (self.spacing, self.figures):
            label.setObjectName("figure")
        for label in (self.figures, self.note):
            label.setWordWrap(True)
        for key in self.sizes:
            key.setCheckable(True)
        grid, keys = QGridLayout(), QHBoxLayout()
        lines = (
            (self.size_title, self.sizes),
            (self.spacing_title, (self.closer, self.spacing, self.wider)),
        )
        for row, (title, widgets) in enumerate(lines):
            line = QHBoxLayout()
            for widget in widgets:
                line.addWidget(widget, 1)
            grid.addWidget(title, row, 0)
            grid.addLayout(line, row, 1)
        for key in (self.use, self.drop, self.close_button):
            keys.addWidget(key, 1)
        grid.setColumnStretch(1, 1)
        column = QVBoxLayout(self)
        column.addWidget(self.title)
        column.addLayout(grid)
        column.addWidget(self.figures, 1)
        column.addWidget(self.note)
        column.addLayout(keys)

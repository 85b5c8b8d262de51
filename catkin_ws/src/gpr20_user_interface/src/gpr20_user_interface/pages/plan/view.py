"""The CONTROL tab: the plan of the next survey in a few large tiles, and START."""

from __future__ import annotations

from typing import Dict, Iterable, List, Mapping, Optional

from PyQt5.QtCore import QEvent, QSize, Qt, pyqtSignal
from PyQt5.QtWidgets import QGridLayout, QPushButton, QSizePolicy, QVBoxLayout

from gpr20_operator.plan.form import PlanCheck, PlanForm
from gpr20_operator.plan.preview import SurveyPreview, short_figures, short_warning
from gpr20_operator.plan.start_lock import start_lock
from gpr20_operator.plan.tiles import (
    TILE_TITLES,
    VALUE_TILES,
    Tile,
    name_lines,
    tile_lines,
    tile_problem,
)
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.look.look import GAP_PX, TOUCH_PX, look_of
from gpr20_user_interface.look.translation import TranslatedWidget, shown_text
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.widgets import set_look


class PlanTile(QPushButton):
    """Shows values, or what is wrong with them; a touch opens their sheet.

    Args:
        name: Which rules of the style sheet apply.
        lines: How many lines there are below the title.
    """

    def __init__(self, name: str = "tile", lines: int = 3) -> None:
        super().__init__()
        self.setObjectName(name)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._level = ""
        self.title = ElidedLabel()
        self.title.setObjectName("tile_title")
        self.lines: List[ElidedLabel] = [ElidedLabel() for _ in range(lines)]
        self.problem = LinesLabel()
        self.problem.hide()
        self._layout = QVBoxLayout(self)
        self._layout.setSpacing(0)
        self._layout.addWidget(self.title)
        for line in self.lines:
            self._layout.addWidget(line)
        self._layout.addWidget(self.problem, 1)
        for label in (self.title, *self.lines, self.problem):
            # The touch is for the button.
            label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.pressed.connect(self._show_level)
        self.released.connect(self._show_level)

    def sizeHint(self) -> QSize:  # noqa: N802
        """Qt: it fills the place that it gets."""
        size_px = look_of(self).px(TOUCH_PX)
        return QSize(size_px, size_px)

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """Qt: it fills the place that it gets."""
        return self.sizeHint()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap_px = look_of(self).px(GAP_PX)
        self._layout.setContentsMargins(gap_px, gap_px // 2, gap_px, gap_px // 2)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange:
            self.restyle()
        elif event.type() == QEvent.Type.EnabledChange:
            self._show_level()

    def show_lines(self, title: str, *lines: str) -> None:
        """Show a title and lines."""
        self.title.show_text(title)
        for label, text in zip(self.lines, (*lines, *("",) * len(self.lines))):
            label.show_text(text)

    def show_problem(self, problem: str) -> None:
        """Show what is wrong instead of the lines, marked; an empty problem: nothing is."""
        self.show_reason(problem)
        self.show_level("wrong" if problem else "")

    def show_reason(self, reason: str) -> None:
        """Show a sentence instead of the lines; an empty reason: the lines."""
        self.setToolTip(reason)
        self.problem.show_text(reason)
        for line in self.lines:
            line.setVisible(not reason)
        self.problem.setVisible(bool(reason))

    def show_level(self, level: str) -> None:
        """Show how good the values are: "wrong", "doubtful", or empty."""
        self._level = level
        self._show_level()

    def _show_level(self) -> None:
        level = self._level
        if not self.isEnabled():
            level = "locked"
        elif self.isDown():
            level = "pressed"
        if self.property("level") != level:
            set_look(self, "level", level)
            # Their colours depend on the property of the tile.
            for label in (self.title, *self.lines, self.problem):
                self.style().unpolish(label)
                self.style().polish(label)


COLUMNS, ROWS = 4, 3


class ControlView(TranslatedWidget):
    """Shows the plan. A touch on a tile asks for its sheet; START says why it is locked."""

    # Carries the SurveyParameters.
    start_pressed = pyqtSignal(object)
    # Carries a Tile.
    tile_pressed = pyqtSignal(object)
    # The parameters or the soil have changed.
    plan_changed = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self.form = PlanForm(DOCUMENTED_TRAVEL)
        self.tiles: Dict[Tile, PlanTile] = {tile: PlanTile() for tile in Tile}
        self.profiles = PlanTile()
        self.figures = PlanTile()
        self.start = PlanTile("start")
        self._annotation = EMPTY
        self._preview: Optional[SurveyPreview] = None
        self._snapshot: Optional[Snapshot] = None
        self._check: PlanCheck = self.form.check()
        self._lay_out()
        self._connect()
        self.retranslate()

    @property
    def parameters(self) -> Optional[SurveyParameters]:
        """What will be measured; None while something is wrong."""
        return self._check.parameters

    @property
    def permittivity(self) -> Optional[float]:
        """Relative permittivity of the soil; None while it is wrong."""
        return self._check.permittivity

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        before, self._snapshot = self._snapshot, snapshot
        changed = self.form.propose_address(
            snapshot.defaults.vna_address if snapshot.defaults else ""
        )
        travel = snapshot.travel or DOCUMENTED_TRAVEL
        if travel != self.form.travel:
            self.form.travel, changed = travel, True
        if changed:
            self.show_plan()
        shown = None if before is None else before.survey_parameters
        if snapshot.survey_parameters is not None and snapshot.survey_parameters != shown:
            self.show_parameters(snapshot.survey_parameters)
        for tile in VALUE_TILES:
            self.tiles[tile].setEnabled(not snapshot.fields_locked)
        self.tiles[Tile.NAME].setEnabled(snapshot.replay is None)
        self.profiles.setEnabled(not snapshot.fields_locked)
        self._show_start()

    def show_parameters(self, parameters: SurveyParameters) -> None:
        """Take over the parameters of a profile, or of the survey that runs."""
        self.form.show_parameters(parameters)
        self.show_plan()

    def restore(self, texts: Mapping[str, str], following: Iterable[str]) -> None:
        """Take over the values of an earlier time."""
        self.form.restore(texts, following)
        self.show_plan()

    def show_plan(self) -> None:
        """Check the plan and show it."""
        self._check = self.form.check()
        for tile in VALUE_TILES:
            lines = (shown_text(line) for line in tile_lines(tile, self.form.texts))
            problem = tile_problem(tile, self._check)
            self.tiles[tile].show_lines(shown_text(TILE_TITLES[tile]), *lines)
            self.tiles[tile].show_problem("" if problem is None else shown_text(problem))
        self._show_start()
        self.plan_changed.emit()

    def show_annotation(self, annotation: Annotation) -> None:
        """Show name, operator and site of the next survey."""
        self._annotation = annotation
        lines = (shown_text(line) for line in name_lines(annotation))
        self.tiles[Tile.NAME].show_lines(shown_text(TILE_TITLES[Tile.NAME]), *lines)

    def show_preview(self, preview: Optional[SurveyPreview]) -> None:
        """Show the figures of the plan; None while it is wrong."""
        self._preview = preview
        lines = [shown_text(line) for line in short_figures(preview)]
        warning = short_warning(preview)
        if warning is not None:
            lines[1] = shown_text(warning)
        self.figures.show_lines(self.tr("Figures"), *lines)
        self.figures.show_level("doubtful" if warning is not None else "")
        self._show_start()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.profiles.show_lines(self.tr("Profiles"), self.tr("load or save"))
        self.show_annotation(self._annotation)
        self.show_preview(self._preview)
        self.show_plan()

    def restyle(self) -> None:
        """Take the sizes of the look."""
        gap_px = look_of(self).px(GAP_PX)
        self._grid.setSpacing(gap_px)
        self._grid.setContentsMargins(gap_px, gap_px, gap_px, gap_px)

    def _lay_out(self) -> None:
        self._grid = QGridLayout(self)
        for number, tile in enumerate(self.tiles.values()):
            self._grid.addWidget(tile, *divmod(number, COLUMNS))
        self._grid.addWidget(self.profiles, 1, COLUMNS - 1)
        self._grid.addWidget(self.figures, 2, 0, 1, 2)
        self._grid.addWidget(self.start, 2, 2, 1, 2)
        for column in range(COLUMNS):
            self._grid.setColumnStretch(column, 1)
        for row in range(ROWS):
            self._grid.setRowStretch(row, 1)

    def _connect(self) -> None:
        for tile, button in self.tiles.items():
            button.clicked.connect(lambda _checked, tile=tile: self.tile_pressed.emit(tile))
        self.start.clicked.connect(self._on_start)

    def _on_start(self) -> None:
        if self._check.parameters is not None:
            self.start_pressed.emit(self._check.parameters)

    def _show_start(self) -> None:
        lock = start_lock(self._snapshot, self._check)
        self.start.setEnabled(lock is None)
        lines = [shown_text(line) for line in short_figures(self._preview)]
        self.start.show_lines(self.tr("START"), lines[0] if lock is None else "")
        self.start.show_reason("" if lock is None else shown_text(lock))

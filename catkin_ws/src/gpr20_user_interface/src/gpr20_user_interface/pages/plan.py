"""The plan of the next survey: its values in a few large tiles, and START."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Dict, Optional

from PyQt5.QtCore import QPointF, QRectF, pyqtSignal
from PyQt5.QtWidgets import QWidget

from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.plan.fields import Tile
from gpr20_operator.plan.form import PlanCheck, PlanForm, SurveyPreview
from gpr20_operator.plan.texts import (
    resumable,
    resume_lines,
    short_size,
    start_lock,
    tile_lines,
    tile_problem,
)
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL, Answer, Request, StartPlan
from gpr20_operator.robot.notices import Refused
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_survey.plan.annotation import EMPTY, MAX_NAME_CHARACTERS, Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters, coordinate_limits_mm
from gpr20_survey.results.answers import SurveySummary
from gpr20_user_interface.look.look import GAP_PX
from gpr20_user_interface.look.translation import shown_number, shown_text
from gpr20_user_interface.low.settings_file import PlanMemory, PlanMemoryFailed, RememberedPlan
from gpr20_user_interface.pages.plan_sheets import AnnotationSheet, ValueSheet
from gpr20_user_interface.presenter import WindowPresenter
from gpr20_user_interface.widgets.ground_picture import AreaPicture
from gpr20_user_interface.widgets.tile import TileButton
from gpr20_user_interface.widgets.widgets import Page, grid

COLUMNS, ROWS = 3, 4
# How long to wait for the list of surveys, in refreshes, before it is requested again.
RETRY_REFRESHES = 40
_NUMBER_AT_END = re.compile(r"([0-9]{1,9})$", re.ASCII)


def next_name(name: str) -> str:
    """Return the name of the survey after one: "El Carmen 3" follows "El Carmen 2".

    The number keeps its leading zeros. A name without a number gets a 2; no name stays none.
    """
    if not name:
        return ""
    found = _NUMBER_AT_END.search(name)
    digits = "" if found is None else found.group(1)
    number = str(int(digits) + 1).zfill(len(digits)) if digits else " 2"
    return name[: len(name) - len(digits)][: MAX_NAME_CHARACTERS - len(number)] + number


class NextAnnotation:
    """Operator and site stay for the surveys that follow, and their names are numbered.

    Notes and position are for one survey.
    """

    def __init__(self) -> None:
        self.value = EMPTY

    def take_defaults(self, defaults: Annotation) -> None:
        """Fill the empty fields with those of the robot."""
        self.value = self.value.with_defaults(defaults)

    def note_started(self) -> None:
        """Note that a survey has started with this annotation."""
        named = next_name(self.value.name)
        self.value = replace(self.value, name=named, notes="", position=None)


class PlanPage(QWidget, Page):
    """Shows the plan; a touch on a tile opens its sheet, and START says why it is locked.

    Attributes:
        annotation: The sheet of name, operator, site, position and notes of a survey.
    """

    # Carries SurveyParameters, the permittivity of the soil, and an Annotation.
    start_pressed = pyqtSignal(object, float, object)
    # Carries the folder of the survey that ended early.
    resume_pressed = pyqtSignal(str)
    # Carries what did not succeed, a Refused, and the reason, a Message.
    refused = pyqtSignal(object, object)

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        traces: TracePresenter,
        memory: PlanMemory,
        storage: Imaging,
    ) -> None:
        super().__init__()
        self._survey, self._traces, self._memory = survey, traces, memory
        self._snapshot: Optional[Snapshot] = None
        self._offer: Optional[SurveySummary] = None
        self._waiting = 0
        # What the survey that runs measures.
        self._measured: Optional[SurveyParameters] = None
        self._previewed: Optional[SurveyPreview] = None
        self.form = PlanForm(DOCUMENTED_TRAVEL)
        self._check: PlanCheck = self.form.check()
        self.next_annotation = NextAnnotation()
        self.reach = AreaPicture()
        self.area = TileButton(picture=self.reach)
        self.tiles: Dict[Tile, TileButton] = {
            tile: self.area if tile is Tile.AREA else TileButton() for tile in Tile
        }
        self.start, self.resume = TileButton("start"), TileButton("start")
        self.values = ValueSheet(window, self.form)
        self.annotation = AnnotationSheet(window, storage)
        self._lay_out()
        self._connect()
        self.show_again()

    @property
    def parameters(self) -> Optional[SurveyParameters]:
        """What will be measured; None while something is wrong."""
        return self._check.parameters

    @property
    def permittivity(self) -> Optional[float]:
        """Relative permittivity of the soil; None while it is wrong."""
        return self._check.permittivity

    @property
    def plan_to_start(self) -> Optional[StartPlan]:
        """What START would measure now; None while something is wrong."""
        parameters, permittivity = self.parameters, self.permittivity
        if parameters is None or permittivity is None:
            return None
        refines = self._survey.refines(parameters)
        return StartPlan(parameters, self.next_annotation.value, refines, permittivity)

    def begin(self) -> None:
        """Start with what was planned last."""
        plan = self._memory.load()
        self.form.restore(plan.texts)
        self.next_annotation.value = plan.annotation
        self.show_plan()
        if self._memory.problem is not None:
            self.refused.emit(Refused.PLAN, self._memory.problem)

    def on_event(self, event: object) -> None:
        """Take what is known of a START."""
        if isinstance(event, Answer) and event.request is Request.START and event.success:
            self.note_started()
        elif isinstance(event, PlanMemoryFailed):
            self.refused.emit(Refused.PLAN, event.reason)

    def show_state(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        before, self._snapshot = self._snapshot, snapshot
        changed, robot = False, snapshot.robot
        if robot is not None and (before is None or robot != before.robot):
            changed = not snapshot.replay
            if changed:
                self.next_annotation.take_defaults(robot.site.annotation)
        travel = DOCUMENTED_TRAVEL if robot is None else robot.config.travel
        if travel != self.form.travel:
            self.form.travel, changed = travel, True
        if changed:
            self.show_plan()
        elif self._survey.preview is not self._previewed:
            self._show_tiles()
        measured = snapshot.job_parameters if snapshot.running else None
        if measured not in (None, self._measured):
            self.show_parameters(measured)
        self._measured = measured
        locked = snapshot.fields_locked
        for tile, button in self.tiles.items():
            named = tile is Tile.NAME
            button.setEnabled(not snapshot.replay if named else not locked)
        if locked:
            # An entry would replace the survey's parameters in the fields.
            self.values.hide()
        self._ask_for_surveys(snapshot)
        self._show_commands()
        if not self.values.isVisible() and not snapshot.replay:
            people = replace(self.next_annotation.value, notes="", position=None)
            self._memory.save(RememberedPlan(dict(self.form.texts), people))

    def note_started(self) -> None:
        """Note that this plan was started, here or from the web page."""
        self.next_annotation.note_started()
        self._show_tiles()

    def show_parameters(self, parameters: SurveyParameters) -> None:
        """Take over the parameters of a finer plan, or of the survey that runs.

        An address equal to the configured one follows later changes of the configuration.
        """
        robot = None if self._snapshot is None else self._snapshot.robot
        if robot is not None and parameters.vna_address == robot.vna_address:
            parameters = replace(parameters, vna_address="")
        self.form.show_parameters(parameters)
        self.show_plan()

    def show_plan(self) -> None:
        """Check the plan and show it."""
        self._check = self.form.check()
        self._survey.set_plan(self.parameters, self.permittivity or 1.0)
        self._show_tiles()
        self._show_commands()

    def show_notes(self) -> None:
        """Open the records of the survey that runs, or of the next one."""
        running = self._survey.snapshot.running_survey
        if running:
            self.annotation.read(running)
        else:
            self.annotation.show_annotation("", self.next_annotation.value)

    def show_again(self) -> None:
        """Show the same in another language, theme or size."""
        self._show_tiles()
        self._show_commands()

    def _show_tiles(self) -> None:
        known = self._previewed = self._survey.preview
        for tile, button in self.tiles.items():
            lines = [
                shown_text(line)
                for line in tile_lines(tile, self.form.texts, self.next_annotation.value)
            ]
            problem = tile_problem(tile, self._check)
            level = "wrong" if problem is not None else ""
            if tile is Tile.SPACING and known is not None and known.too_coarse and not level:
                most = self.tr("at most {spacing} mm")
                lines[1] = most.format(spacing=shown_number(known.quarter_wavelength_mm, ".3g"))
                level = "doubtful"
            sentence = "" if problem is None else shown_text(problem)
            button.show_texts(shown_text(tile.value), *lines, sentence=sentence, level=level)
        travel, parameters = self.form.travel, self.parameters
        (left, right), (bottom, top) = map(coordinate_limits_mm, (travel.x, travel.y))
        area_mm = QRectF()
        if parameters is not None:
            start = QPointF(parameters.x_start_mm, parameters.y_start_mm)
            area_mm = QRectF(start, QPointF(parameters.x_stop_mm, parameters.y_stop_mm))
        self.reach.show_area(area_mm, QRectF(QPointF(left, bottom), QPointF(right, top)))

    def _show_commands(self) -> None:
        """Show what can be started or resumed, and why not."""
        known, lock = self._survey.preview, start_lock(self._snapshot, self._check)
        offered = resumable(self._traces.past, self._snapshot)
        if (offered is None) is not (self._offer is None):
            self._place_start(offered is not None)
        self._offer = offered
        if offered is not None:
            lines = (shown_text(line) for line in resume_lines(self._traces.past, offered))
            self.resume.show_texts(self.tr("RESUME"), *lines)
        self.start.setEnabled(lock is None)
        reason = "" if lock is None else shown_text(lock)
        # What is done first is green.
        level = "" if offered is None else "second"
        size = shown_text(short_size(known))
        self.start.show_texts(self.tr("START"), size, sentence=reason, level=level)

    def _ask_for_surveys(self, snapshot: Snapshot) -> None:
        """Request the list of surveys, of which the last one may be resumed."""
        past = self._traces.past
        self._waiting = max(0, self._waiting - 1)
        wanted = (past.outdated or not past.read) and not self._waiting
        if wanted and snapshot.control_alive:
            past.outdated, self._waiting = False, RETRY_REFRESHES
            self._traces.list_surveys()

    def _on_tile(self, tile: Tile) -> None:
        if tile is Tile.NAME:
            self.show_notes()
        else:
            self.values.show_tile(tile)

    def _on_start(self) -> None:
        if self.parameters is not None and self.permittivity is not None:
            self.start_pressed.emit(self.parameters, self.permittivity, self.next_annotation.value)

    def _on_resume(self) -> None:
        if self._offer is not None:
            self.resume_pressed.emit(self._offer.folder)

    def _on_saved(self, annotation: Annotation) -> None:
        self.next_annotation.value = annotation
        self._show_tiles()

    def _connect(self) -> None:
        for tile, button in self.tiles.items():
            button.clicked.connect(lambda _checked, tile=tile: self._on_tile(tile))
        self.start.clicked.connect(self._on_start)
        self.resume.clicked.connect(self._on_resume)
        self.values.changed.connect(self.show_plan)
        self.annotation.saved.connect(self._on_saved)
        self.annotation.failed.connect(lambda reason: self.refused.emit(Refused.NOTES, reason))

    def _lay_out(self) -> None:
        self._grid = grid(margin=GAP_PX)
        self.setLayout(self._grid)
        self._grid.addWidget(self.area, 0, 0, ROWS - 1, 1)
        others = [button for tile, button in self.tiles.items() if tile is not Tile.AREA]
        for number, button in enumerate(others):
            row, column = divmod(number, COLUMNS - 1)
            self._grid.addWidget(button, row, 1 + column)
        for column in range(COLUMNS):
            self._grid.setColumnStretch(column, 1)
        for row in range(ROWS):
            self._grid.setRowStretch(row, 1)
        self._grid.addWidget(self.resume, ROWS - 1, 0, 1, COLUMNS - 1)
        self._place_start(False)

    def _place_start(self, offered: bool) -> None:
        """Give the last row to what is done first."""
        self.resume.setVisible(offered)
        column = COLUMNS - 1 if offered else 0
        self._grid.addWidget(self.start, ROWS - 1, column, 1, COLUMNS - column)
        # At once: nothing may lie over the other for a touch.
        self._grid.activate()

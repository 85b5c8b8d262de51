"""Connects CONTROL with the survey: the plan, START, profiles and notes."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Dict

from PyQt5.QtWidgets import QWidget

from gpr20_common.message import Message
from gpr20_operator.ground.trace_events import (
    AnnotationFailed,
    AnnotationRead,
    AnnotationStored,
)
from gpr20_operator.ground.traces import TraceSource
from gpr20_operator.plan.annotation_form import NextAnnotation
from gpr20_operator.plan.memory import PlanMemory, PlanMemoryFailed, RememberedPlan
from gpr20_operator.plan.presets import AREA_FIELDS
from gpr20_operator.plan.profiles import Profiles
from gpr20_operator.plan.tiles import Tile
from gpr20_operator.robot.events import AnnotationDefaults, Answer, Request
from gpr20_operator.robot.notices import Refused
from gpr20_operator.robot.snapshot import Snapshot
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.pages.plan.annotation_sheet import AnnotationSheet
from gpr20_user_interface.pages.plan.figures_sheet import FiguresSheet
from gpr20_user_interface.pages.plan.profiles_sheet import ProfilesView
from gpr20_user_interface.pages.plan.start_sheet import StartSheet
from gpr20_user_interface.pages.plan.value_sheet import ValueSheet
from gpr20_user_interface.pages.plan.view import ControlView
from gpr20_user_interface.widgets.page import Page

ShowRefusal = Callable[[Refused, Message], None]


class ControlBinding(Page):
    """Passes the operator's requests on, and opens the sheets of CONTROL.

    Attributes:
        values: The sheet of a tile.
        figures: The sheet of the figures.
        profiles: The sheet of the profiles.
        annotation: The sheet of the notes.
        next_annotation: What people add to the next survey.
    """

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        control: ControlView,
        profiles: Profiles,
        memory: PlanMemory,
        source: TraceSource,
        show_refusal: ShowRefusal,
        start_sheet: StartSheet,
    ) -> None:
        self._survey = survey
        self._control = control
        self._source = source
        self._show_refusal = show_refusal
        self._start_sheet = start_sheet
        self._memory = memory
        self._asked_area: Dict[str, str] = {}
        self.values = ValueSheet(window, control.form)
        self.figures = FiguresSheet(window)
        self.profiles = ProfilesView(window, profiles)
        self.annotation = AnnotationSheet(window)
        self.next_annotation = NextAnnotation()
        control.start_pressed.connect(self._on_start)
        control.plan_changed.connect(self.preview_plan)
        control.tile_pressed.connect(self._on_tile)
        control.figures.clicked.connect(lambda: self.figures.open())
        control.profiles.clicked.connect(lambda: self.profiles.show_profiles(control.parameters))
        self.values.changed.connect(control.show_plan)
        self.annotation.saved.connect(self._on_annotation_saved)
        self.profiles.loaded.connect(control.show_parameters)
        self.profiles.failed.connect(lambda reason: show_refusal(Refused.PROFILE, reason))

    def begin(self) -> None:
        """Start with what was planned last."""
        plan = self._memory.load()
        self._control.form.restore_proposal(plan.configured_address)
        self._control.restore(plan.texts, plan.following)
        self.values.arrow_step, self.values.last_area = plan.arrow_step, plan.last_area
        self._take_annotation(plan.annotation)
        if self._memory.problem is not None:
            self._show_refusal(Refused.PLAN, self._memory.problem)

    def on_event(self, event: object) -> None:
        """Take what is known of the notes."""
        if isinstance(event, AnnotationDefaults):
            self.next_annotation.take_defaults(event.annotation)
            self._control.show_annotation(self.next_annotation.value)
        elif isinstance(event, Answer) and event.request is Request.START and event.success:
            self.values.last_area = self._asked_area
            self.next_annotation.note_started()
            self._control.show_annotation(self.next_annotation.value)
        elif isinstance(event, PlanMemoryFailed):
            self._show_refusal(Refused.PLAN, event.reason)
        elif isinstance(event, AnnotationRead):
            self.annotation.show_annotation(event.survey, event.annotation)
        elif isinstance(event, AnnotationStored) and event.survey == self.annotation.survey:
            self.annotation.hide()
        elif isinstance(event, AnnotationFailed):
            self._show_refusal(Refused.NOTES, event.reason)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._control.refresh(snapshot)
        self._show_preview()
        self._start_sheet.refresh(snapshot)
        if snapshot.fields_locked:
            # An entry would replace the survey's parameters in the fields.
            profiles = self.profiles
            for overlay in (self.values, profiles.name_pad, profiles.confirm, profiles):
                overlay.hide()
        if not self.values.isVisible() and snapshot.replay is None:
            self._memory.save(self._plan())

    def preview_plan(self) -> None:
        """Preview what is planned."""
        parameters, permittivity = self._control.parameters, self._control.permittivity
        self._survey.set_plan(parameters, permittivity or 1.0)
        self._show_preview()

    def _show_preview(self) -> None:
        self._control.show_preview(self._survey.preview)
        self.figures.show_preview(self._survey.preview)

    def _plan(self) -> RememberedPlan:
        form, annotation = self._control.form, self.next_annotation.value
        return RememberedPlan(
            dict(form.texts),
            form.following,
            self.values.arrow_step,
            replace(annotation, notes="", position=None),
            self.values.last_area,
            form.proposed_address,
        )

    def _take_annotation(self, annotation: Annotation) -> None:
        self.next_annotation.value = annotation
        self._control.show_annotation(annotation)

    def _on_tile(self, tile: Tile) -> None:
        if tile is Tile.NAME:
            self.show_notes()
        else:
            self.values.show_tile(tile)

    def _on_start(self, parameters: SurveyParameters) -> None:
        self._asked_area = {name: self._control.form.texts[name] for name in AREA_FIELDS}
        self._start_sheet.ask_start(parameters, self.next_annotation.value)

    def show_notes(self) -> None:
        """Open the notes of the survey that runs, or of the next one."""
        running = self._survey.snapshot.running_survey
        if running:
            self._source.read_annotation(running)
        else:
            self.annotation.show_annotation("", self.next_annotation.value)

    def _on_annotation_saved(self, survey: str, annotation: Annotation) -> None:
        if survey:
            # The sheet stays open until the storage has it.
            self._source.annotate(survey, annotation)
        else:
            self.next_annotation.take(annotation)
            self._control.show_annotation(self.next_annotation.value)
            self.annotation.hide()

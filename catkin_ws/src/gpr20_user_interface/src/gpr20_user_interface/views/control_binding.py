"""Connects CONTROL with the survey: parameters, START, PAUSE, RESUME, profiles and notes."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtWidgets import QWidget

from gpr20_common.message import Message
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.events import AnnotationDefaults, Answer, Request
from gpr20_user_interface.mid.next_annotation import NextAnnotation
from gpr20_user_interface.mid.notices import Refused
from gpr20_user_interface.mid.profiles import Profiles
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.trace_events import (
    AnnotationFailed,
    AnnotationRead,
    AnnotationStored,
)
from gpr20_user_interface.mid.trace_presenter import TraceSource
from gpr20_user_interface.mid.window_presenter import WindowPresenter
from gpr20_user_interface.views.annotation_sheet import AnnotationSheet
from gpr20_user_interface.views.binding import Binding
from gpr20_user_interface.views.control_view import ControlView, PadRequest
from gpr20_user_interface.views.key_pad import DIGITS, KeyPad
from gpr20_user_interface.views.profiles_view import ProfilesView
from gpr20_user_interface.views.start_sheet import StartSheet

ShowRefusal = Callable[[Refused, Message], None]


class ControlBinding(Binding):
    """Passes the operator's requests on, and opens the sheets of CONTROL.

    Attributes:
        number_pad: The keys for a number.
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
        source: TraceSource,
        show_refusal: ShowRefusal,
        start_sheet: StartSheet,
    ) -> None:
        self._survey = survey
        self._control = control
        self._source = source
        self._show_refusal = show_refusal
        self._start_sheet = start_sheet
        self.number_pad = KeyPad(window, DIGITS)
        self.profiles = ProfilesView(window, profiles)
        self.annotation = AnnotationSheet(window)
        self.next_annotation = NextAnnotation()
        control.start_pressed.connect(self._on_start)
        control.pause_pressed.connect(survey.pause)
        control.resume_pressed.connect(start_sheet.ask_resume)
        control.parameters_changed.connect(self.on_parameters)
        control.pad_wanted.connect(self._on_pad_wanted)
        control.profiles.clicked.connect(lambda: self.profiles.show_profiles(control.parameters))
        control.notes.clicked.connect(self.show_notes)
        self.annotation.saved.connect(self._on_annotation_saved)
        self.profiles.loaded.connect(control.show_parameters)
        self.profiles.failed.connect(lambda reason: show_refusal(Refused.PROFILE, reason))

    def on_event(self, event: object) -> None:
        """Take what is known of the notes."""
        if isinstance(event, AnnotationDefaults):
            self.next_annotation.take_defaults(event.annotation)
        elif isinstance(event, Answer) and event.request is Request.START and event.success:
            self.next_annotation.note_started()
        elif isinstance(event, AnnotationRead):
            self.annotation.show_annotation(event.survey, event.annotation)
        elif isinstance(event, AnnotationStored) and event.survey == self.annotation.survey:
            self.annotation.hide()
        elif isinstance(event, AnnotationFailed):
            self._show_refusal(Refused.NOTES, event.reason)

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._control.refresh(snapshot)
        self._control.preview.show_preview(self._survey.preview)
        self._start_sheet.refresh(snapshot)
        if snapshot.fields_locked:
            # An entry would replace the survey's parameters in the fields.
            profiles = self.profiles
            for overlay in (self.number_pad, profiles.name_pad, profiles.confirm, profiles):
                overlay.hide()

    def on_parameters(self, parameters: Optional[SurveyParameters]) -> None:
        """Preview the parameters of the fields; None: they are wrong."""
        self._survey.set_parameters(parameters)
        self._control.preview.show_preview(self._survey.preview)

    def _on_start(self, parameters: SurveyParameters) -> None:
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
            self.next_annotation.value = annotation
            self.annotation.hide()

    def _on_pad_wanted(self, request: PadRequest) -> None:
        # A wrong value may remain while another field is corrected; START stays locked.
        self.number_pad.ask(
            request.edit.setText,
            request.title,
            request.hint,
            request.edit.text(),
            request.judge,
            strict=False,
        )

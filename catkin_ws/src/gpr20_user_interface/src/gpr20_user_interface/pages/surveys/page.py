"""Keeps the focused image fresh while MAP or RADAR is looked at."""

from __future__ import annotations

from typing import Callable

import numpy as np
from PyQt5.QtWidgets import QWidget

from gpr20_operator.ground.coverage import is_stored
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.jobs.images import ImagingPresenter, Wanted
from gpr20_operator.robot.survey_control import WindowPresenter
from gpr20_operator.robot.survey_model import Snapshot
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.pages.plan.start_sheet import StartSheet
from gpr20_user_interface.pages.surveys.candidates_sheet import CandidatesSheet
from gpr20_user_interface.pages.surveys.export_sheet import ExportSheet
from gpr20_user_interface.pages.surveys.view import PastSurveysView
from gpr20_user_interface.widgets.page import Page


class SurveysBinding(Page):
    """Passes the operator's requests about past surveys on.

    Attributes:
        candidates: The sheet of the candidates.
        export: The sheet of the export.
    """

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        past: PastSurveysView,
        traces: TracePresenter,
        start_sheet: StartSheet,
        imaging: ImagingPresenter,
        languages: Languages,
    ) -> None:
        self._past = past
        self.candidates = CandidatesSheet(window, imaging.search, lambda: languages.language.value)
        self.export = ExportSheet(window, imaging.export, lambda: languages.language.value)
        past.page_requested.connect(traces.source.list_surveys)
        past.open_requested.connect(traces.open_survey)
        past.notes_requested.connect(traces.source.read_annotation)
        past.candidates_requested.connect(self.candidates.show_survey)
        past.export_requested.connect(self.export.show_survey)
        past.resume_requested.connect(start_sheet.ask_resume_past)

    def on_event(self, event: object) -> None:
        """Show what the storage or the imaging node reports."""
        self._show()

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._show()

    def _show(self) -> None:
        self._past.refresh()
        self.candidates.refresh()
        self.export.refresh()


class ImagingBinding(Page):
    """Asks for the image of the survey on MAP and RADAR, at most every 10 s.

    Args:
        traces: Which survey they show.
        imaging: The imaging node.
        is_seen: Returns whether one of them is looked at.
        permittivity: Returns that of the ground, as it was chosen; 0: not known.
    """

    def __init__(
        self,
        traces: TracePresenter,
        imaging: ImagingPresenter,
        is_seen: Callable[[], bool],
        permittivity: Callable[[], float],
    ) -> None:
        self._traces = traces
        self._imaging = imaging
        self._is_seen = is_seen
        self._permittivity = permittivity
        self._replay = False

    def on_event(self, event: object) -> None:
        """Take an answer of the imaging node."""
        self._imaging.on_event(event)

    def refresh(self, snapshot: Snapshot) -> None:
        """Note whether a survey is running, and whether there is a robot at all."""
        self._replay = snapshot.replay is not None
        self._imaging.set_survey_runs(snapshot.running)

    def draw(self) -> None:
        """Ask for an image, if the last one is too old."""
        if self._replay or not self._is_seen():
            return
        shown = self._traces.shown
        states = shown.map.trace_states
        stored = 0 if states is None else int(np.count_nonzero(is_stored(states)))
        self._imaging.images.keep(Wanted(shown.survey_id, stored, self._permittivity()))

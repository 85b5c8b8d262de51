"""Connects SURVEYS with the storage, and with the search for candidates."""

from __future__ import annotations

from PyQt5.QtWidgets import QWidget

from gpr20_user_interface.mid.candidate_search import CandidateSearch
from gpr20_user_interface.mid.past_surveys import PastSurvey
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.trace_presenter import TracePresenter
from gpr20_user_interface.mid.window_presenter import WindowPresenter
from gpr20_user_interface.views.binding import Binding
from gpr20_user_interface.views.candidates_sheet import CandidatesSheet
from gpr20_user_interface.views.past_surveys_view import PastSurveysView
from gpr20_user_interface.views.start_sheet import StartSheet
from gpr20_user_interface.views.translation import Languages


class SurveysBinding(Binding):
    """Passes the operator's requests about past surveys on.

    Attributes:
        candidates: The sheet of the candidates.
    """

    def __init__(
        self,
        window: QWidget,
        survey: WindowPresenter,
        past: PastSurveysView,
        traces: TracePresenter,
        start_sheet: StartSheet,
        search: CandidateSearch,
        languages: Languages,
    ) -> None:
        self._survey = survey
        self._past = past
        self.candidates = CandidatesSheet(window, search, lambda: languages.language.value)
        past.page_requested.connect(traces.source.list_surveys)
        past.open_requested.connect(traces.open_survey)
        past.notes_requested.connect(traces.source.read_annotation)
        past.candidates_requested.connect(self._on_candidates)
        past.resume_requested.connect(start_sheet.ask_resume_past)

    def on_event(self, event: object) -> None:
        """Show what the storage or the search reports."""
        self.candidates.on_event(event)
        self._past.refresh()

    def refresh(self, snapshot: Snapshot) -> None:
        """Show what is known now."""
        self._past.refresh()
        self.candidates.refresh(snapshot.running)

    def _on_candidates(self, chosen: PastSurvey) -> None:
        defaults = self._survey.snapshot.defaults
        self.candidates.show_survey(chosen, "" if defaults is None else defaults.data)

"""Connects SURVEYS with the storage, and with the search for candidates and the export."""

from __future__ import annotations

from PyQt5.QtWidgets import QWidget

from gpr20_user_interface.mid.imaging_presenter import ImagingPresenter
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.trace_presenter import TracePresenter
from gpr20_user_interface.mid.window_presenter import WindowPresenter
from gpr20_user_interface.views.binding import Binding
from gpr20_user_interface.views.candidates_sheet import CandidatesSheet
from gpr20_user_interface.views.export_sheet import ExportSheet
from gpr20_user_interface.views.past_surveys_view import PastSurveysView
from gpr20_user_interface.views.start_sheet import StartSheet
from gpr20_user_interface.views.translation import Languages


class SurveysBinding(Binding):
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

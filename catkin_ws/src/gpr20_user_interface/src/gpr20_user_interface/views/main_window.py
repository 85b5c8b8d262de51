"""The frame of the window: the top bar, the tabs, and what lies over them."""

from __future__ import annotations

import enum
from typing import Callable, Dict, Optional

from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QTabWidget, QVBoxLayout, QWidget

from gpr20_common.message import Message
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.candidate_search import CandidateSearch
from gpr20_user_interface.mid.events import AnnotationDefaults, Answer, Request
from gpr20_user_interface.mid.message_source import Received
from gpr20_user_interface.mid.next_annotation import NextAnnotation
from gpr20_user_interface.mid.notices import (
    Refused,
    analyzer_notice,
    node_notice,
    refusal_notice,
    state_notice,
)
from gpr20_user_interface.mid.past_surveys import PastSurvey
from gpr20_user_interface.mid.profiles import Profiles
from gpr20_user_interface.mid.survey_model import Snapshot
from gpr20_user_interface.mid.trace_events import (
    AnnotationFailed,
    AnnotationRead,
    AnnotationStored,
)
from gpr20_user_interface.mid.trace_presenter import TracePresenter
from gpr20_user_interface.mid.window_presenter import WindowPresenter
from gpr20_user_interface.views.annotation_sheet import AnnotationSheet
from gpr20_user_interface.views.candidates_sheet import CandidatesSheet
from gpr20_user_interface.views.control_view import ControlView, PadRequest
from gpr20_user_interface.views.key_pad import DIGITS, KeyPad
from gpr20_user_interface.views.map_view import MapView
from gpr20_user_interface.views.notice import NoticeView
from gpr20_user_interface.views.past_surveys_view import PastSurveysView
from gpr20_user_interface.views.profiles_view import ProfilesView
from gpr20_user_interface.views.question import AnalyzerQuestion
from gpr20_user_interface.views.radar_view import RadarView
from gpr20_user_interface.views.status_view import StatusView
from gpr20_user_interface.views.style import STYLE_SHEET, new_button
from gpr20_user_interface.views.top_bar import TopBar
from gpr20_user_interface.views.translation import Languages, TranslatedWidget

WIDTH_PX = 800
HEIGHT_PX = 480
# Topics come at up to 50 Hz; figures that change more often cannot be read.
REFRESH_MS = 100
# A trace must be seen within a second; drawing more often than this costs a core and shows no more.
DRAW_MS = 250
# A robot may be started, or restarted with other limits, after the window; this also shows
# whether the master answers.
MASTER_CHECK_MS = 2000


class TabName(enum.Enum):
    """The tabs, in their order."""

    CONTROL = "control"
    STATUS = "status"
    MAP = "map"
    RADAR = "radar"
    SURVEYS = "surveys"


class MainWindow(TranslatedWidget):
    """Shows what its presenters hold and passes the operator's requests to them.

    Args:
        survey: The survey that runs, and the requests to the main control.
        traces: The traces, and the requests to the storage.
        profiles: Parameters that are stored under a name.
        languages: Languages of the window.
        search: The search for candidates in a stored survey.
    """

    def __init__(
        self,
        survey: WindowPresenter,
        traces: TracePresenter,
        profiles: Profiles,
        languages: Languages,
        search: CandidateSearch,
    ) -> None:
        super().__init__()
        self.setStyleSheet(STYLE_SHEET)
        self.survey = survey
        self.traces = traces
        self._languages = languages
        self._shown = traces.shown
        self.top_bar = TopBar()
        self.tabs = QTabWidget()
        self.control = ControlView()
        self.status = StatusView()
        self.map = MapView(traces.shown.map, traces.shown.radar)
        self.radar = RadarView(traces.shown.radar)
        self.past = PastSurveysView(traces.past)
        self.language_button = new_button(languages.use_next)
        self._pages: Dict[TabName, QWidget] = {
            TabName.CONTROL: self.control,
            TabName.STATUS: self.status,
            TabName.MAP: self.map,
            TabName.RADAR: self.radar,
            TabName.SURVEYS: self.past,
        }
        self.number_pad = KeyPad(self, DIGITS)
        self.profiles = ProfilesView(self, profiles)
        self.next_annotation = NextAnnotation()
        self.annotation = AnnotationSheet(self)
        self.candidates = CandidatesSheet(self, search, lambda: languages.language.value)
        self.notice = NoticeView(self)
        self.question = AnalyzerQuestion(self)
        self._timers = [
            self._timer(REFRESH_MS, self.refresh),
            self._timer(DRAW_MS, self.draw),
            self._timer(MASTER_CHECK_MS, survey.check_master),
        ]
        self._lay_out()
        self._connect()
        self.retranslate()
        self.resize(WIDTH_PX, HEIGHT_PX)

    def begin(self) -> None:
        """Refresh the window from now on."""
        self.survey.check_master()
        self.refresh()
        self._on_parameters(self.control.parameters)
        for timer in self._timers:
            timer.start()

    def end(self) -> None:
        """Leave the window as it is."""
        for timer in self._timers:
            timer.stop()
        self.survey.end()
        self.candidates.search.close()

    def on_event(self, event: object) -> None:
        """Take an event; show a refusal at once."""
        refusal = self.survey.on_event(event)
        if refusal is not None and refusal.other_analyzer:
            self._ask_about_analyzer(refusal.reason, refusal.other_analyzer)
        elif refusal is not None:
            self._show_refusal(Refused[refusal.request.name], refusal.reason)
        if isinstance(event, Answer):
            self.refresh()
        self._take_annotation(event)
        self.candidates.on_event(event)
        if self.survey.is_shown(event):
            self.traces.on_event(event.event if isinstance(event, Received) else event)
        self._show_opened()
        self.past.refresh()

    def refresh(self) -> None:
        """Show what is known of the robot and the survey now."""
        snapshot = self.survey.refresh()
        self.traces.note_state(snapshot)
        self._show_opened()
        self.map.set_carriage(self.traces.carriage_mm)
        self.past.refresh()
        self.candidates.refresh(snapshot.running)
        self.show_snapshot(snapshot)
        self.control.preview.show_preview(self.survey.preview)

    def draw(self) -> None:
        """Request the missing traces and draw what is new."""
        self.traces.refresh()
        self.map.refresh()
        self.radar.refresh()

    def show_snapshot(self, snapshot: Snapshot) -> None:
        """Show what is known at a moment."""
        self.top_bar.refresh(snapshot)
        self.control.refresh(snapshot)
        self.status.refresh(snapshot)
        if snapshot.fields_locked:
            # An entry would replace the survey's parameters in the fields.
            for overlay in (self.number_pad, self.profiles.name_pad, self.profiles):
                overlay.hide()

    def show_tab(self, name: TabName) -> None:
        """Bring a tab to the front."""
        self.tabs.setCurrentWidget(self._pages[name])

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.setWindowTitle(self.tr("GPR-20"))
        titles = {
            TabName.CONTROL: self.tr("CONTROL"),
            TabName.STATUS: self.tr("STATUS"),
            TabName.MAP: self.tr("MAP"),
            TabName.RADAR: self.tr("RADAR"),
            TabName.SURVEYS: self.tr("SURVEYS"),
        }
        for name, page in self._pages.items():
            self.tabs.setTabText(self.tabs.indexOf(page), titles[name])
        # The language that a touch changes to, by its own name.
        self.language_button.setText(self._languages.language.next.own_name)

    def _lay_out(self) -> None:
        for page in self._pages.values():
            self.tabs.addTab(page, "")
        self.tabs.setCornerWidget(self.language_button)
        self.tabs.tabBar().setExpanding(False)
        # Not by the style sheet, whose bold letters the tabs do not measure.
        font = self.tabs.tabBar().font()
        font.setBold(True)
        self.tabs.tabBar().setFont(font)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.top_bar)
        layout.addWidget(self.tabs, 1)

    def _connect(self) -> None:
        survey, control = self.survey, self.control
        self.top_bar.stop.pressed.connect(lambda: self._ask(survey.stop))
        control.start_pressed.connect(self._on_start)
        self.top_bar.replay.pause.clicked.connect(lambda: self._ask(survey.pause_replay))
        control.pause_pressed.connect(lambda: self._ask(survey.pause))
        control.resume_pressed.connect(lambda: self._ask(survey.resume))
        control.parameters_changed.connect(self._on_parameters)
        control.pad_wanted.connect(self._on_pad_wanted)
        control.profiles.clicked.connect(lambda: self.profiles.show_profiles(control.parameters))
        control.notes.clicked.connect(self._on_notes)
        self.annotation.saved.connect(self._on_annotation_saved)
        self.profiles.loaded.connect(control.show_parameters)
        self.profiles.failed.connect(lambda reason: self._show_refusal(Refused.PROFILE, reason))
        self.status.message.touched.connect(
            lambda state: self.notice.show_notice(state_notice(state))
        )
        self.status.health.node_touched.connect(
            lambda node: self.notice.show_notice(node_notice(node))
        )
        self.past.page_requested.connect(self.traces.source.list_surveys)
        self.past.open_requested.connect(self.traces.source.read_survey)
        self.past.notes_requested.connect(self.traces.source.read_annotation)
        self.past.candidates_requested.connect(self._on_candidates)
        self.past.resume_requested.connect(lambda folder: self._ask(lambda: survey.resume(folder)))
        # The operator has seen enough of a past survey.
        self.radar.back.clicked.connect(self._on_back_to_live)

    def _show_refusal(self, refused: Refused, reason: Message) -> None:
        self.notice.show_notice(refusal_notice(refused, reason))

    def _ask_about_analyzer(self, reason: Message, identity: str) -> None:
        # The status of the survey may have opened a notice with the same reason.
        self.notice.hide()
        self.question.ask(
            analyzer_notice(reason, identity),
            lambda: self._ask(lambda: self.survey.resume_with(identity)),
        )

    def _ask(self, ask: Callable[[], None]) -> None:
        ask()
        self.refresh()

    def _on_start(self, parameters: SurveyParameters) -> None:
        self._ask(lambda: self.survey.start(parameters, self.next_annotation.value))

    def _on_notes(self) -> None:
        running = self.survey.snapshot.running_survey
        if running:
            self.traces.source.read_annotation(running)
        else:
            self.annotation.show_annotation("", self.next_annotation.value)

    def _on_candidates(self, chosen: PastSurvey) -> None:
        defaults = self.survey.snapshot.defaults
        self.candidates.show_survey(chosen, "" if defaults is None else defaults.data)

    def _on_annotation_saved(self, survey: str, annotation: Annotation) -> None:
        if survey:
            # The sheet stays open until the storage has it.
            self.traces.source.annotate(survey, annotation)
        else:
            self.next_annotation.value = annotation
            self.annotation.hide()

    def _take_annotation(self, event: object) -> None:
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

    def _on_parameters(self, parameters: Optional[SurveyParameters]) -> None:
        self.survey.set_parameters(parameters)
        self.control.preview.show_preview(self.survey.preview)

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

    def _on_back_to_live(self) -> None:
        self.traces.show_live()
        self._show_opened()

    def _show_opened(self) -> None:
        """Follow another survey if another one was opened, or the running one again."""
        shown, folder = self.traces.shown, self.traces.opened_folder
        if shown is self._shown:
            return
        self._shown = shown
        self.map.show_models(shown.map, shown.radar)
        self.radar.show_model(shown.radar, folder)
        if folder:
            self.show_tab(TabName.RADAR)

    def _timer(self, period_ms: int, slot: Callable[[], None]) -> QTimer:
        timer = QTimer(self)
        timer.setInterval(period_ms)
        timer.timeout.connect(slot)
        return timer

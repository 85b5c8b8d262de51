"""The frame of the window: the top bar, the tabs, and what lies over them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, Dict, Optional, Tuple

from PyQt5.QtCore import QEvent, Qt, QTimer
from PyQt5.QtGui import QGuiApplication, QResizeEvent
from PyQt5.QtWidgets import QLayout, QStackedWidget, QWidget

from gpr20_common.low.clock import Clock
from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.jobs.job import Delivery
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.jobs.result import SurveyResult
from gpr20_operator.robot.events import Answer
from gpr20_operator.robot.remote_control import Arming
from gpr20_operator.robot.service_model import ServiceModel
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.look.look import (
    DESIGN_HEIGHT_PX,
    DESIGN_WIDTH_PX,
    SMALLEST_SCALE,
    Look,
    scale_for,
    style_sheet,
)
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.low.settings_file import PlanMemory
from gpr20_user_interface.pages.alerts import Alerts
from gpr20_user_interface.pages.ground import GroundPage
from gpr20_user_interface.pages.plan import PlanPage
from gpr20_user_interface.pages.result import ResultPage
from gpr20_user_interface.pages.robot import RobotPage
from gpr20_user_interface.pages.settings import RemotePage, SettingsPage, WindowMemory
from gpr20_user_interface.pages.survey import JobPage, SurveyTab
from gpr20_user_interface.pages.surveys import SurveysPage
from gpr20_user_interface.presenter import WindowPresenter
from gpr20_user_interface.touch.scrolling import scroll_everything
from gpr20_user_interface.widgets.bars import Rail, TabName, TopBar
from gpr20_user_interface.widgets.hold_sheet import StartSheet
from gpr20_user_interface.widgets.widgets import Overlay, Page, column, fit_layouts, row, say_again
from gpr20_user_interface.window.lock import TouchBinding

# Topics come at up to 50 Hz; figures that change more often than these cannot be read. 99 of 100
# traces are on the screen within 250 ms; drawing more often costs processor time.
REFRESH_MS = 200
# A robot may be started, or restarted with other limits, after the window; this also shows
# whether the master answers.
MASTER_CHECK_MS = 2000


@dataclass(frozen=True)
class Presenters:
    """The parts of the window without their widgets.

    Attributes:
        survey: The survey that runs, and the requests to the main control.
        traces: The traces, and the requests to the storage.
        imaging: Focused images, results and exports.
        service: Maintenance of the robot.
        plans: What the operator planned last.
        arming: Whether the web page may start and resume.
    """

    survey: WindowPresenter
    traces: TracePresenter
    imaging: Imaging
    service: ServiceModel
    plans: PlanMemory
    arming: Arming


class MainWindow(QWidget):
    """Shows what its presenters hold and passes the operator's requests to them.

    Args:
        presenters: What it shows and asks through.
        languages: Languages of the window.
        memory: What the operator has chosen for the window; None: the defaults.
        clock: Measures how long a button is held, and the time after a touch and a change.

    Attributes:
        look: Theme and scale now.
    """

    def __init__(
        self,
        presenters: Presenters,
        languages: Languages,
        memory: Optional[WindowMemory] = None,
        clock: Clock = Clock(),  # noqa: B008 (it has no state)
    ) -> None:
        super().__init__()
        memory = memory or WindowMemory()
        self.look = Look(memory.settings.theme)
        self.survey, self.traces = presenters.survey, presenters.traces
        self.plans = presenters.plans
        self._imaging = presenters.imaging
        self._make_tabs(presenters, languages)
        self._make_sheets(presenters, languages, memory, clock)
        self._connect_tabs()
        # The traces first: the others show what they have.
        self._bindings: Tuple[Page, ...] = (
            *(self.ground, self.alerts, self.survey_tab, self.job, self.control),
            *(self.start_sheet, self.past, self.result, self.remote, self.robot),
        )
        self._timers = [
            self._timer(REFRESH_MS, self.refresh),
            self._timer(MASTER_CHECK_MS, self.survey.check_master),
        ]
        self._lay_out()
        views = (self.top_bar, *self.rail.tabs.values())
        notices = (self.notice, self.start_sheet, self.stop_warning, self.top_bar.remote)
        self.touch_binding = TouchBinding(
            *(self, self.top_bar.stop, views, notices, lambda: memory.settings.dim_after_s, clock)
        )
        self.touch_binding.touches.touched.connect(self.remote.end)
        self.rail.settings.clicked.connect(lambda: self.settings.open())
        self.rail.lock.clicked.connect(lambda: self.touch_binding.set_locked(True))
        self._refresh_after_requests()
        scroll_everything(self)
        self._show_look()
        self.resize(DESIGN_WIDTH_PX, DESIGN_HEIGHT_PX)

    def show_on_screen(self, full_screen: bool) -> None:
        """Show the window, not larger than the screen; or without a frame on all of it."""
        screen = QGuiApplication.primaryScreen()
        if not full_screen:
            self.resize(self.size().boundedTo(screen.availableGeometry().size()))
            self.show()
            return

        def cover() -> None:
            now = QGuiApplication.primaryScreen()
            if now is not None:  # else it is being replaced by another one
                self.setGeometry(now.geometry())

        self.setWindowFlag(Qt.WindowType.FramelessWindowHint)
        # A screen that is rotated or replaced, or has another resolution.
        application = QGuiApplication.instance()
        if isinstance(application, QGuiApplication):
            application.primaryScreenChanged.connect(lambda _screen: cover())
        screen.geometryChanged.connect(lambda _geometry: cover())
        cover()
        self.showFullScreen()

    def begin(self) -> None:
        """Refresh the window from now on."""
        self.survey.check_master()
        self.control.begin()
        self.refresh()
        for timer in self._timers:
            timer.start()

    def end(self) -> None:
        """Leave the window as it is."""
        for timer in self._timers:
            timer.stop()
        self.remote.end()
        self._imaging.end()
        self.result.end()

    def on_event(self, event: object) -> None:
        """Take an event; show a refusal at once."""
        if isinstance(event, Delivery):
            event.deliver()
            return
        self.alerts.take_refusal(self.survey.on_event(event))
        if isinstance(event, Answer):
            self.refresh()
        for binding in self._bindings:
            binding.on_event(event)

    def refresh(self) -> None:
        """Show what is known of the robot and the survey now."""
        snapshot = self.survey.state()
        for binding in self._bindings:
            binding.show_state(snapshot)
        self.touch_binding.show_state(snapshot)
        # What START and the figures of the job say, the band does not say once more.
        ready = snapshot.can_start and self.control.plan_to_start is not None
        self.top_bar.show_state(snapshot, ready, self.job.isVisible())

    def show_tab(self, name: TabName) -> None:
        """Bring a tab to the front."""
        self.tabs.setCurrentWidget(self._pages[name])
        self.rail.show_chosen(name)

    def use_look(self, look: Look) -> None:
        """Change theme or scale."""
        if look != self.look:
            self.look = look
            self._show_look()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        """Qt: the window has another size; everything in it scales."""
        super().resizeEvent(event)
        size = event.size()
        self.use_look(replace(self.look, scale=scale_for(size.width(), size.height())))
        for overlay in self.findChildren(Overlay):
            if isinstance(overlay, Overlay):
                overlay.cover()
        self.touch_binding.band.show_state(self.touch_binding.band.locked)

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the window has changed."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            say_again(self)
            self._show_again()
            self.refresh()

    def _show_look(self) -> None:
        self.setStyleSheet(style_sheet(self.look))
        fit_layouts(self, self.look)
        self.rail.show_again()
        self.top_bar.band.show_again()
        self._show_again()

    def _show_again(self) -> None:
        for binding in self._bindings:
            binding.show_again()

    def _use_parameters(self, parameters: SurveyParameters) -> None:
        """Put the parameters of a plan into CONTROL, and bring it to the front."""
        self.control.show_parameters(parameters)
        # The job of the survey before is no longer of interest.
        self.survey_tab.show_plan(self.survey.snapshot)
        self.show_tab(TabName.SURVEY)

    def _show_result(self, folder: str) -> None:
        """Bring the result of a stored survey to the front."""
        self.survey_tab.show_result(folder, self.survey.snapshot)
        self.show_tab(TabName.SURVEY)

    def _make_tabs(self, presenters: Presenters, languages: Languages) -> None:
        traces = self.traces
        self.top_bar = TopBar()
        self.rail, self.tabs = Rail(), QStackedWidget()
        self.control = PlanPage(
            *(self, self.survey, traces, presenters.plans, self._imaging),
        )
        self.additions = AdditionsPresenter(
            self._imaging, lambda: self.control.next_annotation.value.operator
        )
        self.result = ResultPage(
            *(self, SurveyResult(self._imaging), traces.past, languages),
            lambda: self.control.next_annotation.value.operator,
        )
        self.past = SurveysPage(self, traces.past, self._imaging)
        self.job = JobPage(traces)
        self.survey_tab = SurveyTab(
            *(self.control, self.job, self.result, lambda survey: self.result.result.open(survey))
        )

    def _make_sheets(
        self, presenters: Presenters, languages: Languages, memory: WindowMemory, clock: Clock
    ) -> None:
        survey, traces = self.survey, self.traces
        self.start_sheet = StartSheet(self, survey, traces.past)
        self.alerts = Alerts(
            *(self, survey, self.top_bar),
            *(self.start_sheet.ask_resume, self.start_sheet.ask_resume_with, clock),
        )
        self.notice, self.stop_warning = self.alerts.notice, self.alerts.stop_warning
        self.values = self.control.values
        self.annotation = self.control.annotation
        self.robot = RobotPage(presenters.service, self.notice.show_notice)
        self.ground = GroundPage(
            *(self, survey, traces, self.additions),
            *(self._imaging, self.alerts.show_refusal),
        )
        self.settings = SettingsPage(
            *(self, languages),
            *(lambda theme: self.use_look(replace(self.look, theme=theme)), memory),
        )
        self.remote = RemotePage(
            *(self, presenters.arming, lambda: self.control.plan_to_start),
            *(self.top_bar.remote, self.settings.remote_button),
        )

    def _connect_tabs(self) -> None:
        traces, control, ground, past = self.traces, self.control, self.ground, self.past
        self.remote.survey_began.connect(control.note_started)
        self.job.notes_pressed.connect(control.show_notes)
        self.result.show_wanted.connect(ground.show_place_of)
        self.result.finer_wanted.connect(ground.measure_finer)
        self.result.plan_wanted.connect(lambda: self.survey_tab.show_plan(self.survey.snapshot))
        self.result.resume_wanted.connect(self.start_sheet.ask_resume_past)
        ground.finer_chosen.connect(lambda plan: self._use_parameters(plan.parameters))
        ground.wanted.connect(lambda: self.show_tab(TabName.GROUND))
        ground.view.surveys_wanted.connect(lambda: self.show_tab(TabName.SURVEYS))
        control.start_pressed.connect(self.start_sheet.ask_start)
        control.resume_pressed.connect(self.start_sheet.ask_resume_past)
        control.refused.connect(self.alerts.show_refusal)
        past.page_requested.connect(traces.list_surveys)
        past.open_requested.connect(traces.open_survey)
        past.notes_requested.connect(control.annotation.read)
        past.plan_requested.connect(lambda: self.show_tab(TabName.SURVEY))
        past.resume_requested.connect(self.start_sheet.ask_resume_past)
        past.result_requested.connect(self._show_result)

    def _lay_out(self) -> None:
        self.setWindowTitle("GPR-20")
        self._pages: Dict[TabName, QWidget] = {
            TabName.SURVEY: self.survey_tab,
            TabName.GROUND: self.ground.view,
            TabName.SURVEYS: self.past,
            TabName.ROBOT: self.robot,
        }
        for page in self._pages.values():
            self.tabs.addWidget(page)
        self.rail.chosen.connect(self.show_tab)
        self.show_tab(TabName.SURVEY)
        layout = column(self.top_bar, (row(self.rail, (self.tabs, 1), gap=0), 1), gap=0)
        # The window may be smaller than the design: then everything in it is smaller too.
        layout.setSizeConstraint(QLayout.SizeConstraint.SetNoConstraint)
        self.setLayout(layout)
        self.setMinimumSize(
            int(DESIGN_WIDTH_PX * SMALLEST_SCALE), int(DESIGN_HEIGHT_PX * SMALLEST_SCALE)
        )

    def _refresh_after_requests(self) -> None:
        """Show at once that a request was sent: a second touch must not send another."""
        for request in (
            self.top_bar.stop.pressed,
            self.top_bar.pause_pressed,
            self.start_sheet.hold.held,
        ):
            request.connect(lambda *_: self.refresh())

    def _timer(self, period_ms: int, slot: Callable[[], None]) -> QTimer:
        timer = QTimer(self)
        timer.setInterval(period_ms)
        timer.timeout.connect(slot)
        return timer

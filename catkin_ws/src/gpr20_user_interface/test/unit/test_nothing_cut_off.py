"""Every text of the tabs and dialogs fits, in each language and size of the screen."""

import itertools

import numpy as np
from finger import place_of
from layout_kit import LONG, assert_fits, assert_touchable, busiest, screen, seen, spoken
from map_kit import FINER, MARKER, focused
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QPushButton
from test_fault_messages import paused
from view_kit import (
    RESTING,
    SURVEY,
    depth_echo,
    description,
    make_grid,
    moving,
    past_survey,
    state_of,
    trace_at,
)
from window_helpers import click, show

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_operator.ground.additions import AdditionsRead, RelatedSurvey
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.records import RadarSettings
from gpr20_operator.ground.trace_events import SurveyDescribed, SurveysListed
from gpr20_operator.ground.traces import ShownBand
from gpr20_operator.jobs.imaging import ImageFocused
from gpr20_operator.robot.health import HealthReport
from gpr20_operator.robot.notices import (
    Refused,
    analyzer_notice,
    fault_notice,
    node_notice,
    refusal_notice,
)
from gpr20_operator.robot.robots import RobotReported, RobotsFound
from gpr20_operator.robot.service_events import AxisMoved, EndstopState, HeightTested
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_user_interface.look.look import TEXT_PX, TOUCH_PX
from gpr20_user_interface.window.rail import TabName

__all__ = ["screen", "spoken"]

WITH_DETAILS = Message("{reason}", reason=verbatim(LONG), details=LONG)
BAND = ShownBand(Message("PAST SURVEY: {name}", name="2026-11-21 05:10:00 UTC"), True)
OTHER_TABS = (TabName.MAP, TabName.RADAR, TabName.SURVEYS)
NOTICES = (
    *(refusal_notice(refused, WITH_DETAILS) for refused in Refused),
    fault_notice(paused(WITH_DETAILS)),
    node_notice(
        NodeHealth("height_sensor", HealthLevel.ERROR, WITH_DETAILS, {"a": LONG, "b": LONG})
    ),
)


def test_the_tabs_are_all_seen(spoken):
    assert_fits(spoken, spoken.rail)
    for button in spoken.rail.tabs.values():
        metrics = button.fontMetrics()
        assert metrics.horizontalAdvance(button.text()) <= button.width(), button.text()


def size_text(size):
    return f"{size.width()}x{size.height()}"


def tab_sizes(window):
    tabs = [window.tabs.widget(at) for at in range(window.tabs.count())]
    return ", ".join(f"{type(tab).__name__} {size_text(tab.minimumSizeHint())}" for tab in tabs)


def test_nothing_of_a_tab_is_cut_off(spoken):
    for code in SurveyState:
        tabs = [TabName.SURVEY, TabName.ROBOT]
        if code in (SurveyState.IDLE, SurveyState.SURVEYING, SurveyState.FAILED):
            tabs += OTHER_TABS
        for tab in tabs:
            spoken.show_tab(tab)
            show(spoken, busiest(code))
            spoken.notice.hide()
            assert_fits(spoken, spoken.top_bar, spoken.tabs)
        if code.running:
            assert_touchable(spoken, spoken.top_bar)
    if spoken.look.scale == 1.0:
        hint = spoken.minimumSizeHint()
        fits = hint.width() <= spoken.width() and hint.height() <= spoken.height()
        sizes = f"{size_text(hint)} of {size_text(spoken.size())}"
        remedy = "put what is new beside something, or behind a touch"
        assert fits, f"the window needs {sizes}; {remedy}; its tabs need: {tab_sizes(spoken)}"


def test_nothing_of_the_band_is_cut_off_but_its_remedy_which_a_touch_opens(spoken):
    motion = moving(*AxisId, owner="/a_program_with_a_long_name_1795493315529903")
    part = NodeHealth("vna_acquisition", HealthLevel.ERROR, WITH_DETAILS, {})
    for known, axes in itertools.product(
        (
            *({"master_alive": False}, {"alive": False}, {"interrupted": True}),
            *({"health": HealthReport((part,))}, {"still_s": 86399.0}),
        ),
        (RESTING, motion),
    ):
        # What is shown for the first time has its size with the next refresh.
        for _ in range(2):
            show(spoken, busiest(axes=axes, **known))
            QTest.qWait(1)
        spoken.notice.hide()
        message = spoken.top_bar.band.message
        assert message.whole and message.fontMetrics().lineSpacing() * 2 <= message.height()
        assert spoken.top_bar.band.more.isVisible() and not spoken.top_bar.band.title.is_cut
        assert_fits(spoken, spoken.top_bar, spoken.tabs)
        click(spoken.top_bar.band.message)
        assert_fits(spoken, spoken.notice)
        spoken.notice.hide()


def test_nothing_of_the_card_of_a_fault_and_of_the_stop_warning_is_cut_off(spoken):
    for code in (SurveyState.PAUSED, SurveyState.FAILED):
        show(spoken, busiest(SurveyState.SURVEYING))
        show(spoken, busiest(code, state=paused(verbatim(LONG))))
        assert spoken.notice.isVisible()
        assert_fits(spoken, spoken.top_bar, spoken.notice)
        click(spoken.notice.details_button)
        assert_fits(spoken, spoken.notice)
        assert spoken.notice.reason.fontMetrics().height() * 2 <= spoken.notice.height() / 3
        spoken.notice.hide()
    show(spoken, busiest(axes=()))
    click(spoken.top_bar.stop)
    assert spoken.stop_warning.isVisible()
    assert_fits(spoken, spoken.stop_warning)


def test_no_dialog_is_cut_off(spoken):
    for notice in NOTICES:
        spoken.notice.show_notice(notice)
        assert_dialog_fits(spoken, spoken.notice)
    spoken.question.ask(analyzer_notice(WITH_DETAILS, "Anritsu,MS2026C/2,62011033,1.23"), list)
    assert_dialog_fits(spoken, spoken.question)


def assert_dialog_fits(window, dialog):
    assert_fits(window, dialog)
    assert dialog.reason.height() >= 3 * dialog.reason.fontMetrics().height()
    dialog.details_button.click()
    assert_fits(window, dialog)
    assert dialog.details.height() >= window.look.px(TOUCH_PX)


def test_what_is_longer_than_its_place_is_scrolled_with_a_gloved_finger(spoken):
    spoken.notice.show_notice(refusal_notice(Refused.START, verbatim(LONG * 10)))
    QTest.qWait(1)
    bar = spoken.notice.reason.verticalScrollBar()
    assert bar.isVisible()
    assert bar.width() >= spoken.look.px(TOUCH_PX)
    QTest.mouseClick(bar, Qt.LeftButton, pos=bar.rect().center() + QPoint(0, bar.height() // 3))
    assert bar.value() > 0


def test_neither_the_settings_nor_the_list_of_robots_is_cut_off(spoken):
    names = frozenset(f"/{'w' * 20}{number}" for number in range(20))
    spoken.on_event(RobotsFound(names | {"/"}))
    try:
        for code in SurveyState:
            now = busiest(code)
            for name in names:
                spoken.on_event(RobotReported(name, now.state))
            show(spoken, now)
            show(spoken, now)
            assert spoken.top_bar.band.message.whole.startswith("/: ")
            spoken.rail.settings.click()
            assert_fits(spoken, spoken.top_bar, spoken.settings)
            spoken.settings.robot_button.click()
            show(spoken, now)
            assert_fits(spoken, spoken.top_bar, spoken.robots)
            spoken.robots.hide()
    finally:
        spoken.on_event(RobotsFound(frozenset()))
    sheet = spoken.settings
    for buttons in (sheet.languages, sheet.themes, sheet.dim_choices):
        for button in buttons.values():
            assert min(button.height(), button.width()) >= spoken.look.px(TOUCH_PX)


def fill_survey_tabs(window):
    """Let MAP and RADAR show a survey with all that can be drawn there."""
    grid = make_grid(x_stop_mm=583.33, x_start_mm=416.67, y_start_mm=683.33, y_stop_mm=783.33)
    show(window, busiest(state=state_of(SurveyState.FINISHED, LONG, SURVEY)))
    window.on_event(SurveyDescribed(description()))
    live = window.traces.live
    live.begin(grid)
    failures = {10: verbatim("the VNA did not answer within 90 s; check cable and address")}
    verdict = verbatim("INCOMPLETE: 11 of 40 planned traces are stored, 1 failed, 28 missing")
    live.map.set_coverage(
        CoverageRuns(SURVEY, 40, (0, 10, 11, 12), (1, 3, 1, 0), failures, verdict)
    )
    rng = np.random.default_rng(1)
    for index in range(10):
        noise = 1e-4 * (rng.standard_normal(501) + 1j * rng.standard_normal(501))
        live.take_trace(trace_at(grid, index, depth_echo(0.1, level=0.05) + noise))


def test_nothing_of_map_is_cut_off(spoken):
    fill_survey_tabs(spoken)
    spoken.show_tab(TabName.MAP)
    spoken.refresh()
    related = RelatedSurvey(FINER, "20261121T061000_7c9e6679", True, Area(120, 150, 60, 80))
    spoken.on_event(AdditionsRead(SURVEY, (MARKER,), (related,)))
    spoken.on_event(ImageFocused(focused()))
    for button, sheet in (
        (spoken.map.next_problem, spoken.map),
        (spoken.map.next_candidate, spoken.map),
        (spoken.map.finer, spoken.map_binding.finer),
        (spoken.map.markers, spoken.map_binding.markers),
        (spoken.map.trace, spoken.map_binding.trace),
    ):
        button.click()
        spoken.draw()
        assert sheet.isVisible()
        assert_fits(spoken, sheet, padding_px=2)
        for one in seen(sheet, QPushButton):
            assert one.height() >= round(TOUCH_PX * spoken.look.scale), one.text()
        if sheet is not spoken.map:
            sheet.hide()


def test_nothing_of_radar_is_cut_off(spoken):
    fill_survey_tabs(spoken)
    spoken.show_tab(TabName.RADAR)
    spoken.refresh()
    view = spoken.radar
    for band in (None, BAND):
        spoken.radar_page.band.show_band(band)
        view.presenter.settings = RadarSettings(depth_m=0.455)
        view.enlarge(None)
        view.refresh()
        assert_radar_fits(spoken, [view.line_plot, view.slice_plot], 0.15)
        assert view.slice_plot.notice
        view.presenter.set_depth(0.1)
        for plot in (view.trace_plot, view.line_plot, view.slice_plot):
            view.enlarge(plot)
            assert_radar_fits(spoken, [plot], 0.2)
            assert view.readout.endswith(" dB")
        view.enlarge(None)
        view.presenter.change(permittivity=80.5)
        view.begin_fit()
        assert view.use.isVisible()
        assert_radar_fits(spoken, [view.line_plot], 0.15)
        view.presenter.end_hyperbola()
        view.refresh()
    spoken.radar.settings.click()
    sheet = spoken.radar_binding.sheet
    for _ in range(2):
        assert_fits(spoken, sheet, padding_px=4)
        for key in (sheet.polarization, sheet.axis, sheet.scale, sheet.background, sheet.follow):
            key.click()


def assert_radar_fits(window, plots, least_part):
    """Check the texts, and that plots are large enough and apart from everything else."""
    view = window.radar
    assert_fits(window, view, padding_px=4)
    for button in seen(view, QPushButton):
        assert min(button.height(), button.width()) >= window.look.px(TOUCH_PX), button.text()
    for plot in plots:
        assert plot.area().height() >= least_part * window.height()
    parts = (view.trace_plot, view.line_plot, view.slice_plot, view.bar, view.top_bar, view.note)
    shown = [place_of(window, one) for one in parts if one.isVisible()]
    for number, one in enumerate(shown):
        assert not any(one.intersects(other) for other in shown[number + 1 :])


def test_nothing_of_the_list_of_surveys_is_cut_off(spoken):
    spoken.show_tab(TabName.SURVEYS)
    verdict = verbatim("INCOMPLETE: 11 of 40 planned traces are stored, 1 failed, 28 missing")
    spoken.on_event(SurveysListed("", (past_survey(verdict=verdict),), True))
    spoken.past.table.selectRow(0)
    show(spoken, busiest(SurveyState.IDLE))
    assert_fits(spoken, spoken.past, padding_px=2)
    for button in seen(spoken.past, QPushButton):
        assert min(button.height(), button.width()) >= spoken.look.px(TOUCH_PX), button.text()


def test_nothing_of_robot_is_cut_off(spoken):
    spoken.show_tab(TabName.ROBOT)
    spoken.on_event(EndstopState(AxisId.X, True))
    overview = spoken.robot.overview
    for _ in range(2):  # folded, and then all
        for code in (SurveyState.SURVEYING, SurveyState.FINISHED):
            show(spoken, busiest(code))
            spoken.draw()
            show(spoken, busiest(code))
            assert_fits(spoken, spoken.robot, padding_px=2)
        click(overview.fold_button)
    for one in (overview.fold_button, overview.check_button, overview.enter_button):
        assert min(one.height(), one.width()) >= spoken.look.px(TOUCH_PX), one.text()


def test_nothing_of_the_service_is_cut_off(spoken):
    spoken.show_tab(TabName.ROBOT)
    show(spoken, busiest(SurveyState.FINISHED))
    spoken.robot.overview.entered.emit()
    assert spoken.robot.in_service
    view = spoken.robot.service
    spoken.on_event(EndstopState(AxisId.X, True))
    spoken.on_event(EndstopState(AxisId.Y, False))
    spoken.on_event(
        AxisMoved(False, Message("the axis is at the end of its range; move it the other way"))
    )
    spoken.refresh()
    assert_fits(spoken, view)
    for button in (*view.axes.rows[2].buttons, view.switch_button, view.leave_button):
        assert min(button.width(), button.height()) >= spoken.look.px(TOUCH_PX), button.text()
        assert button.fontInfo().pixelSize() >= spoken.look.px(TEXT_PX), button.text()
    click(view.switch_button)
    spoken.on_event(HeightTested(0.123, 0.001, 1.234))
    identity = "Anritsu,MS2026C/2,6200412345,1.23"
    accuracy = "MODERATE_TEMPERATURE"
    spoken.on_event(AnalyzerTest("192.168.100.100", identity, accuracy, 4000, 12.345, -123.4))
    spoken.refresh()
    assert_fits(spoken, view)
    click(view.instruments.daily)
    assert_fits(spoken, view)
    for button in view.instruments.answers:
        assert min(button.width(), button.height()) >= spoken.look.px(TOUCH_PX), button.text()

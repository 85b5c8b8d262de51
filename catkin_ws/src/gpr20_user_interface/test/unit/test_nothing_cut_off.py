"""Every text of the tabs, sheets and dialogs fits, in each language and size of the screen."""

from dataclasses import replace

import pytest

pytest.importorskip("PyQt5")

from pseudo_language import PSEUDO, write_pseudo_catalogue
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAbstractButton, QLabel, QLineEdit
from window_helpers import application, close, new_window, show, snapshot

from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import VARIABLE
from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import ControlState, CurrentPosition, Progress, TargetPosition
from gpr20_user_interface.mid.notices import (
    Refused,
    analyzer_notice,
    node_notice,
    refusal_notice,
    state_notice,
)
from gpr20_user_interface.mid.parameter_form import default_parameters
from gpr20_user_interface.mid.plan_form import PLAN_FIELDS
from gpr20_user_interface.mid.plan_tiles import VALUE_TILES
from gpr20_user_interface.mid.robot_health import (
    EXPECTED_NODES,
    Alarm,
    AlarmKind,
    HealthReport,
)
from gpr20_user_interface.mid.robots import RobotReported, RobotsFound
from gpr20_user_interface.mid.survey_preview import SurveyPreview
from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.lines_label import LinesLabel
from gpr20_user_interface.views.look import BORDER_PX, TEXT_PX, TOUCH_PX, look_of
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.palette import Theme
from gpr20_user_interface.views.style_sheet import TAB_PADDING_PX
from gpr20_user_interface.views.touch_edit import TouchEdit
from gpr20_user_interface.views.translation import Languages

__all__ = ["application"]

# These leave out what has no room, and say so.
CUT = (ElidedLabel, LinesLabel)

LONG = "the VNA at 192.168.100.100 does not answer; check its cable and its address. " * 8
WITH_DETAILS = Message("{reason}", reason=verbatim(LONG), details=LONG)
LARGEST = SurveyPreview(
    stops=500000,
    traces=1000000,
    x_spacing_mm=0.1234,
    y_spacing_mm=0.1234,
    frequency_step_hz=1.350675e6,
    depth_m=110.98,
    resolution_m=0.02776,
    quarter_wavelength_mm=0.1,
    cost=SurveyCost(99 * 86400.0 + 86399.0, 123456 * 10**6),
)


SIZES = ((480, 320), (800, 480), (1280, 800))
# The colours change no size: each theme once with each size.
SCREENS = [
    (size, language, theme)
    for size in SIZES
    for language, theme in ((Language.ENGLISH, Theme.SUN), (Language.SPANISH, Theme.NIGHT))
]
# A language of somebody else's, on the robot's screen.
SCREENS.append(((800, 480), PSEUDO, Theme.SUN))


@pytest.fixture(scope="module", params=SCREENS, ids=lambda screen: f"{screen[0]}-{screen[1].value}")
def screen(request, application, tmp_path_factory):
    """One window for all tests on a screen."""
    size, language, theme = request.param
    own_folder = tmp_path_factory.mktemp("translations")
    if language == PSEUDO:
        write_pseudo_catalogue(own_folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(own_folder))
        languages = Languages(application, language)
        window = new_window(languages, profiles=tmp_path_factory.mktemp("profiles"))
        window.use_look(replace(window.look, theme=theme))
        window.show()
        window.resize(*size)
        yield window
        close(window)


@pytest.fixture
def spoken(screen):
    for overlay in screen.findChildren(Overlay):
        overlay.hide()
    screen.survey.preview = LARGEST
    screen.show_tab(TabName.CONTROL)
    show(screen, busiest())
    # The changes of language, size and theme are events.
    QTest.qWait(1)
    return screen


def busiest(**other):
    level = HealthLevel.STALE
    values = {"calibration": "MODERATE_POWER"}
    nodes = tuple(
        NodeHealth(name, level, verbatim(LONG), values) for name in (*EXPECTED_NODES, "simulator")
    )
    values = {
        "state": ControlState(SurveyState.SURVEYING, verbatim(LONG), "id", True),
        "progress": Progress("id", 99.99, 1000000, 999999, 10**7),
        "current": CurrentPosition(650.0, 800.0, -90.0),
        "target": TargetPosition(650.0, 800.0, -90.0),
        "height_m": 0.123,
        "health": HealthReport(nodes),
        **other,
    }
    return snapshot(SurveyState.SURVEYING, **values)


def assert_fits(window):
    QTest.qWait(1)
    assert (window.width(), window.height()) in SIZES
    for kind in (QLabel, QAbstractButton, QLineEdit):
        for widget in window.findChildren(kind):
            if widget.isVisible() and not isinstance(widget, CUT):
                assert_inside(window, widget)
                assert_text_fits(widget)


def assert_inside(window, widget):
    corner = widget.mapTo(window, widget.rect().bottomRight())
    assert corner.x() < window.width() and corner.y() < window.height(), widget.text()


def assert_text_fits(widget):
    if isinstance(widget, QLabel) and widget.wordWrap():
        assert widget.heightForWidth(widget.width()) <= widget.height(), widget.text()
    else:
        text = widget.text().replace("&", "")
        if isinstance(widget, QLineEdit):
            text = text or widget.placeholderText()
        frame_px = 0 if isinstance(widget, QLabel) else 2 * look_of(widget).px(BORDER_PX)
        if isinstance(widget, TouchEdit) and widget.property("fit") == "small":
            return  # its beginning is seen: test_touch_edit.py
        lines = text.splitlines() or [""]
        metrics = widget.fontMetrics()
        needed_px = max(map(metrics.horizontalAdvance, lines)) + frame_px
        assert needed_px <= widget.contentsRect().width(), text
        assert len(lines) * metrics.height() <= widget.height(), text


@pytest.mark.parametrize("code", [SurveyState.IDLE, SurveyState.SURVEYING, SurveyState.FAILED])
@pytest.mark.parametrize("tab", [TabName.MAP, TabName.RADAR, TabName.SURVEYS, TabName.SERVICE])
def test_nothing_of_the_other_tabs_is_cut_off(spoken, tab, code):
    spoken.show_tab(tab)
    show(spoken, busiest(state=ControlState(code, verbatim(LONG), "id", True)))
    spoken.notice.hide()
    assert_fits(spoken)


def test_the_settings_are_not_cut_off(spoken):
    spoken.settings.button.click()
    assert_fits(spoken)
    sheet = spoken.settings.sheet
    for buttons in (sheet.languages, sheet.themes, sheet.dim_choices):
        for button in buttons.values():
            assert min(button.height(), button.width()) >= spoken.look.px(TOUCH_PX)


def test_neither_the_name_of_the_robot_nor_the_list_of_robots_is_cut_off(spoken):
    names = frozenset(f"/{'w' * 20}{number}" for number in range(20))
    spoken.on_event(RobotsFound(names | {"/"}))
    try:
        for code in SurveyState:
            state = ControlState(code, verbatim(LONG), "id", True)
            for name in names:
                spoken.on_event(RobotReported(name, state))
            show(spoken, busiest(state=state))
            show(spoken, busiest(state=state))
            assert spoken.top_bar.message.whole.startswith("/: ")
            spoken.settings.button.click()
            assert_fits(spoken)
            spoken.settings.sheet.robot_button.click()
            show(spoken, busiest(state=state))
            assert_fits(spoken)
            spoken.robots.sheet.hide()
    finally:
        spoken.on_event(RobotsFound(frozenset()))


def test_the_start_sheet_is_not_cut_off(spoken):
    show(spoken, busiest(state=ControlState(SurveyState.IDLE, verbatim(LONG), "id", True)))
    spoken.control.start.click()
    assert spoken.start_sheet.isVisible()
    assert_fits(spoken)


def test_text_has_the_size_of_the_design(spoken):
    for label in spoken.findChildren(QLabel):
        if label.isVisible() and label.text():
            assert label.font().pixelSize() >= spoken.look.px(TEXT_PX), label.text()


@pytest.mark.parametrize("tab", [TabName.CONTROL, TabName.STATUS])
@pytest.mark.parametrize("code", list(SurveyState))
def test_nothing_of_a_tab_is_cut_off(spoken, tab, code):
    spoken.show_tab(tab)
    show(spoken, busiest(state=ControlState(code, verbatim(LONG), "id", True)))
    assert_fits(spoken)


@pytest.mark.parametrize("kind", list(AlarmKind))
def test_no_alarm_is_cut_off(spoken, kind):
    show(spoken, busiest(alarm=Alarm(kind, 86399.0, verbatim(LONG))))
    # What is shown for the first time has its size with the next refresh.
    QTest.qWait(1)
    show(spoken, busiest(alarm=Alarm(kind, 86399.0, verbatim(LONG))))
    message = spoken.top_bar.message
    assert message.whole and message.fontMetrics().lineSpacing() * 2 <= message.height()
    assert_fits(spoken)


NOTICES = {
    **{refused.value: refusal_notice(refused, WITH_DETAILS) for refused in Refused},
    "state": state_notice(ControlState(SurveyState.PAUSED, WITH_DETAILS, "id", True)),
    "node": node_notice(
        NodeHealth("height_sensor", HealthLevel.ERROR, WITH_DETAILS, {"a": LONG, "b": LONG})
    ),
}


@pytest.mark.parametrize("name", list(NOTICES))
def test_no_dialog_is_cut_off(spoken, name):
    spoken.notice.show_notice(NOTICES[name])
    assert_fits(spoken)
    reason = spoken.notice.reason
    assert reason.height() >= 3 * reason.fontMetrics().height()
    if NOTICES[name].details:
        spoken.notice.details_button.click()
        assert_fits(spoken)
        assert spoken.notice.details.height() >= spoken.look.px(TOUCH_PX)


def test_no_question_is_cut_off(spoken):
    spoken.question.ask(analyzer_notice(WITH_DETAILS, "Anritsu,MS2026C/2,62011033,1.23"), list)
    assert_fits(spoken)
    reason = spoken.question.reason
    assert reason.height() >= 3 * reason.fontMetrics().height()
    spoken.question.details_button.click()
    assert_fits(spoken)
    assert spoken.question.details.height() >= spoken.look.px(TOUCH_PX)


def test_no_problem_of_a_tile_is_cut_off(spoken):
    show(spoken, busiest(state=ControlState(SurveyState.IDLE, verbatim(LONG), "id", True)))
    for name in PLAN_FIELDS:
        before = spoken.control.form.texts[name]
        spoken.control.form.set_text(name, "-7,5")
        spoken.control.show_plan()
        assert spoken.control.start.problem.isVisible()
        assert_fits(spoken)
        spoken.control.form.set_text(name, before)


def test_what_is_longer_than_its_place_is_scrolled_with_a_gloved_finger(spoken):
    spoken.notice.show_notice(refusal_notice(Refused.START, verbatim(LONG * 10)))
    QTest.qWait(1)
    bar = spoken.notice.reason.verticalScrollBar()
    assert bar.isVisible()
    assert bar.width() >= spoken.look.px(TOUCH_PX)
    QTest.mouseClick(bar, Qt.LeftButton, pos=bar.rect().center() + QPoint(0, bar.height() // 3))
    assert bar.value() > 0


@pytest.mark.parametrize("tile", VALUE_TILES)
def test_no_sheet_of_a_tile_is_cut_off(spoken, tile):
    show(spoken, busiest(state=ControlState(SurveyState.IDLE, verbatim(LONG), "id", True)))
    spoken.values.last_area = {"x_start_mm": "1", "x_stop_mm": "2"}
    spoken.values.show_tile(tile)
    for name in list(spoken.values.fields):
        spoken.values.choose(name)
        assert_fits(spoken)
        spoken.values.keys.press("7")
        assert_fits(spoken)


def test_no_figure_is_cut_off(spoken):
    spoken.control.figures.click()
    assert_fits(spoken)


def test_no_number_pad_is_cut_off(spoken):
    hint = "WGS 84, -180 to 180, east positive; empty if not known"
    spoken.annotation.number_pad.ask(
        *(lambda _text: None, "Longitude", hint, "-74.1"), judge=lambda _text: "", strict=False
    )
    assert_fits(spoken)


def test_neither_profiles_nor_their_keys_are_cut_off(spoken):
    for number in range(20):
        spoken.profiles._save(f"{'a' * 30}{number:02d}")
    spoken.profiles.show_profiles(default_parameters())
    spoken.profiles.names.setCurrentRow(0)
    assert_fits(spoken)
    spoken.profiles.delete.click()
    assert_fits(spoken)
    spoken.profiles.save.click()
    assert_fits(spoken)


def test_neither_notes_nor_their_keys_are_cut_off(spoken):
    sheet = spoken.annotation
    longest = Annotation("W" * 40, "W" * 40, "W " * 2000, Wgs84Position(-89.123456, -179.123456))
    for survey in ("", "20261121T051000_7c9e6679"):
        sheet.show_annotation(survey, longest)
        assert_fits(spoken)
    sheet.fields["latitude"].setText("-100.123456")
    assert sheet.problem.text()
    assert_fits(spoken)
    for name, field in sheet.fields.items():
        field.tapped.emit()
        assert_fits(spoken)
        pad = sheet.number_pad if sheet.number_pad.isVisible() else sheet.text_pad
        if pad is sheet.text_pad:
            pad.shift.click()
            assert_fits(spoken)
            assert min(key.height() for key in pad.keys) >= spoken.look.px(TOUCH_PX), name
        pad.hide()


def test_tabs_are_all_seen(spoken):
    bar = spoken.tabs.tabBar()
    for index in range(bar.count()):
        text, area = bar.tabText(index), bar.tabRect(index)
        needed_px = bar.fontMetrics().horizontalAdvance(text) + 2 * spoken.look.px(TAB_PADDING_PX)
        assert needed_px <= area.width(), text
        # Otherwise there are small arrows that move the tabs.
        assert area.right() < bar.width(), text

"""Every text of the frame, CONTROL, STATUS and the dialogs fits at 800x480 in each language."""

import pytest

pytest.importorskip("PyQt5")

from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAbstractButton, QLabel, QLineEdit
from window_helpers import application, show, snapshot, window

from gpr20_common.catalogue import Language
from gpr20_common.message import Message, verbatim
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import (
    ControlState,
    CurrentPosition,
    HealthLevel,
    NodeHealth,
    Progress,
    TargetPosition,
)
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
    CALIBRATION,
    EXPECTED_NODES,
    Alarm,
    AlarmKind,
    HealthReport,
)
from gpr20_user_interface.mid.survey_preview import SurveyPreview
from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.lines_label import LinesLabel
from gpr20_user_interface.views.look import BORDER_PX, TOUCH_PX
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.touch_edit import TouchEdit
from gpr20_user_interface.views.translation import Languages

__all__ = ["application", "window"]

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


@pytest.fixture(params=list(Language))
def spoken(request, application, window):
    languages = Languages(application, request.param)
    window.survey.preview = LARGEST
    show(window, busiest())
    # The change of language is an event.
    QTest.qWait(1)
    yield window
    languages.close()


def busiest(**other):
    level = HealthLevel.STALE
    values = {CALIBRATION: "MODERATE_POWER"}
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
    assert (window.width(), window.height()) == (800, 480)
    for kind in (QLabel, QAbstractButton, QLineEdit):
        for widget in window.findChildren(kind):
            if widget.isVisible() and not isinstance(widget, CUT):
                assert_inside(window, widget)
                assert_text_fits(widget)


def assert_inside(window, widget):
    corner = widget.mapTo(window, widget.rect().bottomRight())
    assert corner.x() < 800 and corner.y() < 480, widget.text()


def assert_text_fits(widget):
    if isinstance(widget, QLabel) and widget.wordWrap():
        assert widget.heightForWidth(widget.width()) <= widget.height(), widget.text()
    else:
        text = widget.text().replace("&", "")
        if isinstance(widget, QLineEdit):
            text = text or widget.placeholderText()
        frame_px = 0 if isinstance(widget, QLabel) else 2 * BORDER_PX
        if isinstance(widget, TouchEdit) and widget.property("fit") == "small":
            return  # its beginning is seen: test_touch_edit.py
        lines = text.splitlines() or [""]
        metrics = widget.fontMetrics()
        needed_px = max(map(metrics.horizontalAdvance, lines)) + frame_px
        assert needed_px <= widget.contentsRect().width(), text
        assert len(lines) * metrics.height() <= widget.height(), text


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
        assert spoken.notice.details.height() >= TOUCH_PX


def test_no_question_is_cut_off(spoken):
    spoken.question.ask(analyzer_notice(WITH_DETAILS, "Anritsu,MS2026C/2,62011033,1.23"), list)
    assert_fits(spoken)
    reason = spoken.question.reason
    assert reason.height() >= 3 * reason.fontMetrics().height()
    spoken.question.details_button.click()
    assert_fits(spoken)
    assert spoken.question.details.height() >= TOUCH_PX


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
    assert bar.width() >= TOUCH_PX
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


def test_neither_profiles_nor_their_keys_are_cut_off(spoken, tmp_path):
    for number in range(20):
        (tmp_path / f"{'a' * 30}{number:02d}.yaml").touch()
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
            assert min(key.height() for key in pad.keys) >= TOUCH_PX, name
        pad.hide()


def test_tabs_are_all_seen(spoken):
    bar = spoken.tabs.tabBar()
    for index in range(bar.count()):
        text = bar.tabText(index)
        assert bar.fontMetrics().horizontalAdvance(text) + 28 <= bar.tabRect(index).width(), text

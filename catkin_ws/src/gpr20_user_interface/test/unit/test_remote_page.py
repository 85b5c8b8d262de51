"""Remote control on the touchscreen: a hold allows it, every page shows it, any touch ends it."""

import pytest
from finger import AFTER_S, Finger, place_of
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from view_kit import snapshot
from window_helpers import show, start, wishes

from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, NodeHealth
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import StartPlan
from gpr20_operator.robot.remote_control import (
    REMOTE_LIMIT_S,
    Arming,
    WebStatusReported,
)
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.widgets.bars import TabName

WEB = WebStatusReported("192.168.1.10", 8443, "AB12 CD34", 3, "Ana")
ANNOTATION = Annotation("Ana", "El Carmen", "wet", name="El Carmen 2")


class Field:
    """A window with a web page, and what it sends to it."""

    def __init__(self, opened, clock):
        self.clock, self.sent = clock, []
        self.arming = Arming(clock, self.sent.append)
        self.window = opened(arming=self.arming)
        self.window.on_event(WEB)
        self.say(SurveyState.CONFIGURED)
        self.finger = Finger(self.window, self.clock)
        self.sheet, self.mark = self.window.remote, self.window.top_bar.remote

    def say(self, code, **changes):
        show(self.window, snapshot(code, **changes))

    def open(self):
        self.window.settings.remote_button.click()
        self.finger.wait(AFTER_S)

    def allow(self):
        self.open()
        self.finger.hold(self.sheet.hold)
        assert self.arming.armed


@pytest.fixture
def field(opened, clock):
    return Field(opened, clock)


def test_the_sheet_says_where_the_page_is_and_who_is_there(field):
    assert not field.mark.isVisible()
    field.finger.tap(field.window.rail.settings)
    field.finger.wait(AFTER_S)
    field.finger.tap(field.window.settings.remote_button)
    assert field.sheet.isVisible() and not field.window.settings.isVisible()
    texts = [value.text() for _name, value in field.sheet._rows if value.isVisible()]
    assert texts == ["https://192.168.1.10:8443", "AB12 CD34", "3 browsers", "Ana"]
    # Without a page there is nothing to hold.
    assert field.sheet.hold.isVisible()
    gone = HealthReport((NodeHealth("web", HealthLevel.STALE, verbatim("ended"), {}),))
    field.say(SurveyState.CONFIGURED, health=gone)
    assert not field.sheet.hold.isVisible() and "web:=true" in field.sheet.doubt.text()
    field.window.on_event(WEB)
    field.say(SurveyState.CONFIGURED, alive=False)
    assert not field.sheet.hold.isVisible() and field.sheet.doubt.text()


def test_a_tap_allows_nothing_and_the_release_of_the_hold_does_not_end_it(field):
    field.open()
    field.finger.tap(field.sheet.hold, 0.9)
    assert not field.arming.armed and not field.mark.isVisible()
    place = place_of(field.window, field.sheet.hold).center()
    field.finger.press(place)
    field.finger.wait(1.1)
    assert field.arming.armed and not field.sheet.isVisible()
    field.finger.move(place + QPoint(5, 5))
    field.finger.release(place)
    field.finger.wait(3.0)
    assert field.arming.armed and field.sent[-1].armed


def test_every_page_shows_how_long_it_is_allowed(field):
    field.allow()
    for name in TabName:
        field.window.show_tab(name)
        field.say(SurveyState.CONFIGURED)
        assert field.mark.isVisible() and field.mark.text().startswith("REMOTE\n")
    field.clock.advance(18.5)
    field.say(SurveyState.CONFIGURED)
    assert field.mark.text() == "REMOTE\n9:42"
    field.window.settings.open()
    assert not place_of(field.window, field.mark).intersects(
        place_of(field.window, field.window.settings)
    )
    field.clock.advance(REMOTE_LIMIT_S)
    field.say(SurveyState.CONFIGURED)
    assert not field.mark.isVisible() and not field.sent[-1].armed


def test_any_touch_ends_it_also_one_that_does_nothing_else(field):
    window = field.window
    stop = place_of(window, window.top_bar.stop).center()
    for place in (QPoint(400, 300), place_of(window, field.mark).center(), QPoint(1, 479), stop):
        field.allow()
        field.finger.press(place)
        assert not (field.arming.armed or field.mark.isVisible() or field.sent[-1].armed)
        field.finger.release(place)
        field.finger.wait(AFTER_S)
        window.alerts._on_stop_warning_closed()
    assert wishes(window) == ["stop"]
    for end in (lambda: QTest.keyClick(window.windowHandle(), Qt.Key_Space), window.end):
        field.allow()
        end()
        assert not field.arming.armed and not field.sent[-1].armed


def test_the_plan_is_what_start_on_the_window_would_send(field):
    window = field.window
    window.control.show_parameters(default_parameters())
    window.control.next_annotation.value = ANNOTATION
    window.survey.finer = type("Finer", (), {"refined_by": lambda _self, _plan: "coarse id"})()
    field.say(SurveyState.CONFIGURED)
    shown = field.sent[-1].plan
    assert shown == StartPlan(window.control.parameters, ANNOTATION, "coarse id", 4.0)
    field.finger.wait(AFTER_S)
    start(window)
    assert wishes(window) == [shown.parameters] and window.survey.annotations == [ANNOTATION]
    window.control.form.set_texts({**window.control.form.texts, "x_spacing_mm": "-"})
    window.control.show_plan()
    field.say(SurveyState.CONFIGURED)
    assert field.sent[-1].plan is None
    # A survey that the page has started uses up its name and notes.
    window.control.show_parameters(default_parameters())
    window.control.next_annotation.value = ANNOTATION
    field.say(SurveyState.CONFIGURED)
    field.allow()
    field.say(SurveyState.SURVEYING)
    field.say(SurveyState.SURVEYING)
    field.say(SurveyState.FINISHED)
    assert field.arming.armed
    annotation = field.sent[-1].plan.annotation
    assert (annotation.name, annotation.notes) == ("El Carmen 3", "")

"""Settings, languages and remote control: remembered, damage is said; any touch ends control."""

from pathlib import Path

import pytest
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from tutorial_code import code_blocks
from view_kit import make_grid, snapshot
from window_helpers import AFTER_S, Finger, click, place_of, show, start, wishes

from gpr20_common.catalogue import VARIABLE, Language
from gpr20_operator.palette import Theme
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import StartPlan
from gpr20_operator.robot.remote_control import Arming, WebStatusReported
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.low.settings_file import SettingsFile
from gpr20_user_interface.pages.settings import WindowMemory, WindowSettings
from gpr20_user_interface.widgets.bars import TabName

TUTORIAL = Path(__file__).parents[5] / "docs/extend/language.md"


def test_each_choice_takes_effect_at_once_and_at_the_next_start(opened, tmp_path, monkeypatch):
    # A language of this computer, as the tutorial adds it.
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    (tmp_path / "pt.po").write_text(code_blocks(TUTORIAL, "po")["pt.po"], encoding="utf-8")
    memory = WindowMemory(SettingsFile(tmp_path / "window.yaml"))
    window = opened(memory=memory)
    window.traces.live.begin(make_grid())
    show(window, snapshot(SurveyState.IDLE))
    sheet = window.settings
    click(window.rail.settings)
    assert sheet.languages[Language.ENGLISH].isChecked()
    click(sheet.languages[Language("pt", "Português")])
    QTest.qWait(1)  # the change of language is an event
    assert (sheet.title.text(), window.top_bar.stop.text()) == ("Definições", "STOP")
    click(sheet.themes[Theme.NIGHT])
    click(sheet.dim_choices[10])
    click(sheet.languages[Language.SPANISH])
    QTest.qWait(1)
    assert (sheet.title.text(), window.top_bar.stop.text()) == ("Ajustes", "DETENER")
    window.show_tab(TabName.GROUND)
    assert "Sin eco no significa sin mina." in window.ground.view.note.text()
    assert window.look.theme is Theme.NIGHT and memory.close(10.0)

    remembered = WindowMemory(SettingsFile(tmp_path / "window.yaml"))
    assert remembered.settings == WindowSettings(Language.SPANISH, Theme.NIGHT, 10)
    assert opened(memory=remembered).look.theme is Theme.NIGHT


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

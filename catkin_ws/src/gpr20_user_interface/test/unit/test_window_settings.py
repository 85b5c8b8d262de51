"""Settings, languages and remote control: remembered, damage is said; any touch ends control."""

import random
import subprocess
from pathlib import Path

import pytest
from fault_kit import raises_fault
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtTest import QTest
from run_seed import draws
from tutorial_code import code_blocks
from view_kit import make_grid, snapshot
from window_helpers import AFTER_S, Finger, click, place_of, show, start, until, wishes

from gpr20_common.catalogue import (
    VARIABLE,
    Language,
    language_from_environment,
    languages,
    read_catalogue,
)
from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, NodeHealth
from gpr20_operator import faults
from gpr20_operator.palette import Theme
from gpr20_operator.plan.fields import Tile, default_parameters
from gpr20_operator.robot.events import StartPlan
from gpr20_operator.robot.remote_control import (
    Arming,
    WebStatusReported,
)
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.low.settings_file import SettingsFile
from gpr20_user_interface.pages.settings import (
    WindowMemory,
    WindowSettings,
    settings_from,
    values_of,
)
from gpr20_user_interface.widgets.bars import TabName


def test_a_damaged_file_never_gives_settings_that_nobody_chose():
    draw = random.Random(15)
    junk = [None, True, -1, 3, 2.5, "", "fr", "SUN", [], {}, "sun\x00", 10**30]
    for _ in range(draws(125)):
        values = values_of(WindowSettings())
        name = draw.choice(list(values))
        values[name] = draw.choice(junk)
        with raises_fault(faults.SETTINGS_LOST.as_warning()):
            settings_from(values)


def test_what_cannot_be_written_is_reported_and_holds_until_the_end(tmp_path):
    (tmp_path / "file").touch()
    problems = []
    memory = WindowMemory(SettingsFile(tmp_path / "file" / "window.yaml"), problems.append)
    # Neither can it be read: the defaults hold.
    assert memory.settings == WindowSettings() and len(problems) == 1
    memory.change(theme=Theme.NIGHT)
    assert memory.close(10.0)
    assert memory.settings.theme is Theme.NIGHT
    assert len(problems) == 2


def test_each_choice_takes_effect_at_once_and_at_the_next_start(opened, tmp_path):
    memory = WindowMemory(SettingsFile(tmp_path / "window.yaml"))
    window = opened(memory=memory)
    window.traces.live.begin(make_grid())
    window.show_tab(TabName.ROBOT)
    show(window, snapshot(SurveyState.IDLE))
    sheet, asking = window.settings, window.start_sheet
    asking.ask_resume()
    asked = asking.title.text()
    asking.hide()
    click(window.rail.settings)
    assert sheet.isVisible() and sheet.languages[Language.ENGLISH].isChecked()
    click(sheet.themes[Theme.NIGHT])
    click(sheet.dim_choices[10])
    click(sheet.languages[Language.SPANISH])
    QTest.qWait(1)  # the change of language is an event
    assert sheet.title.text() == "Ajustes" and window.look.theme is Theme.NIGHT
    assert window.top_bar.stop.text() == "DETENER"
    assert window.control.tiles[Tile.SOIL].title.text() == "Suelo"
    asking.ask_resume()
    assert asking.title.text() not in ("", asked)
    asking.hide()
    assert "cables alejados" in window.robot.overview.hint.text()
    window.show_tab(TabName.GROUND)
    assert "Sin eco no significa sin mina." in window.ground.view.note.text()
    click(sheet.close_button)
    assert not sheet.isVisible() and memory.close(10.0)

    remembered = WindowMemory(SettingsFile(tmp_path / "window.yaml"))
    assert remembered.settings == WindowSettings(Language.SPANISH, Theme.NIGHT, 10)
    window = opened(memory=remembered, language=remembered.settings.language)
    assert window.look.theme is Theme.NIGHT
    click(window.rail.settings)
    assert window.settings.languages[Language.SPANISH].isChecked()


ROOT = Path(__file__).parents[5]
PAGE = ROOT / "docs/extend/language.md"
TRANSLATIONS = ROOT / "scripts/translations.sh"
PORTUGUESE = Language("pt", "Português")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The catalogues of this computer."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    (tmp_path / "pt.po").write_text(code_blocks(PAGE, "po")["pt.po"], encoding="utf-8")
    return tmp_path


def test_the_languages_are_the_catalogues_found_and_what_one_lacks_is_english(folder):
    assert languages() == [Language.ENGLISH, Language.SPANISH, PORTUGUESE]
    portuguese = read_catalogue(PORTUGUESE)
    assert portuguese.template("START") == "INICIAR"
    assert portuguese.template("Colours") == "Colours"
    missing = Message("{path} does not exist", path="/nowhere")
    assert portuguese.text(missing) == "/nowhere não existe"
    assert language_from_environment({"LANG": "pt_BR.UTF-8"}) == PORTUGUESE
    (folder / "es.po").write_text('msgid "START"\nmsgstr "¡YA!"\n')
    spanish = read_catalogue(Language.SPANISH)
    # Other words on this computer; the rest is that of the project.
    assert (spanish.template("START"), spanish.template("Settings")) == ("¡YA!", "Ajustes")
    # A translation with other values than its template is not used.
    entries = {"one {a}": "um {c}", "two {a}": "dois {", "three {a} {b}": "três {b} {a}"}
    lines = [f'msgid "{template}"\nmsgstr "{text}"\n' for template, text in entries.items()]
    (folder / "fr.po").write_text("\n".join(lines))
    catalogue = read_catalogue(Language("fr", "Français"))
    shown = [catalogue.text(Message(one, a=1, b=2)) for one in entries]
    assert shown == ["one 1", "two 1", "três 2 1"]


def test_the_window_uses_another_language_and_keeps_its_own_for_a_damaged_one(opened, folder):
    memory = WindowMemory(SettingsFile(folder / "window.yaml"))
    window = opened(memory=memory)
    sheet = window.settings
    click(window.rail.settings)
    click(sheet.languages[PORTUGUESE])
    assert until(lambda: window.control.start.title.text() == "INICIAR")
    assert sheet.labels[1].text() == "Colours"
    assert memory.close(30.0)
    assert WindowMemory(SettingsFile(folder / "window.yaml")).settings.language == PORTUGUESE
    (folder / "es.po").write_text('msgid "START"\nmsgstr\n')
    click(sheet.languages[Language.SPANISH])
    assert f"{folder}/es.po" in sheet.hint.text()
    assert sheet.languages[PORTUGUESE].isChecked() and memory.settings.language == PORTUGUESE


@pytest.mark.release
def test_the_commands_of_the_page_begin_check_and_update_a_catalogue(tmp_path):
    path = tmp_path / "fr.po"

    def run(*arguments):
        command = [str(TRANSLATIONS), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    path.write_text('msgid ""\nmsgstr ""\n"X-Language-Name: Français\\n"\n')
    assert run(path).returncode == 0
    assert '\nmsgid "START"\n' in path.read_text()
    with path.open("a") as file:
        file.write('\nmsgid "no program has this"\nmsgstr "rien"\n')
    checked = run("--check", path)
    assert checked.returncode != 0 and "not used" in checked.stderr
    assert run(path).returncode == 0
    assert "no program has this" not in path.read_text()


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
    for left_s, text in ((600.0, "REMOTE\n10:00"), (581.5, "REMOTE\n9:42"), (0.0, "")):
        field.clock.advance(field.arming.remaining_s - left_s)
        for name in TabName:
            field.window.show_tab(name)
            field.say(SurveyState.CONFIGURED)
            assert field.mark.isVisible() is bool(text) is field.sent[-1].armed
            assert not text or field.mark.text() == text


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

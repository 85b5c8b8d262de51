"""Files of settings: what is chosen by a touch is remembered, what is damaged is said."""

import os
import random

import pytest
from fault_kit import raises_fault
from PyQt5.QtTest import QTest
from run_seed import draws
from view_kit import make_grid, past_survey, snapshot
from window_helpers import click, show

from gpr20_common.catalogue import Language
from gpr20_operator import faults
from gpr20_operator.errors import SettingsError
from gpr20_operator.files.settings_file import MAX_BYTES, SettingsFile
from gpr20_operator.ground.trace_events import SurveysListed
from gpr20_operator.palette import Theme
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.settings import (
    DIM_CHOICES_MIN,
    WindowMemory,
    WindowSettings,
    settings_from,
    values_of,
)
from gpr20_user_interface.window.rail import TabName


@pytest.fixture
def path(tmp_path):
    return tmp_path / "gpr20" / "window.yaml"


def test_values_are_read_as_they_were_written(path):
    assert SettingsFile(path).read() == {}
    values = {"site": "El Carmen, Peña: №1", "soil": 4.5, "list": [0.0, 90.0], "none": None}
    SettingsFile(path).write(values)
    assert SettingsFile(path).read() == values
    SettingsFile(path).write({"a": 1})
    assert SettingsFile(path).read() == {"a": 1}
    assert os.listdir(str(path.parent)) == ["window.yaml"]


def test_a_damaged_file_is_refused_with_its_name(path):
    path.parent.mkdir()
    for text in ("", "[1]", "{1: 2}", "a: [", "\x00", "#" * (MAX_BYTES + 1)):
        path.write_text(text)
        with raises_fault(faults.SETTINGS_DAMAGED, "window.yaml"):
            SettingsFile(path).read()
    for make in (os.mkdir, os.mkfifo):
        path.rmdir() if path.is_dir() else path.unlink()
        make(str(path))
        with raises_fault(faults.SETTINGS_DAMAGED, "window.yaml"):
            SettingsFile(path).read()
    # Nor does random damage raise anything else.
    path.unlink()
    draw = random.Random(7)
    SettingsFile(path).write({"vna_address": "10.0.0.2", "list": [1, 2.5], "deep": {"a": "ñ"}})
    whole = path.read_bytes()
    for _ in range(draws(75)):
        damaged = bytearray(whole)
        for _ in range(draw.randint(1, 6)):
            damaged[draw.randrange(len(damaged))] = draw.randrange(256)
        path.write_bytes(bytes(damaged[: draw.randint(0, len(damaged))]))
        try:
            assert isinstance(SettingsFile(path).read(), dict)
        except SettingsError as error:
            assert str(path) in str(error)


def test_a_damaged_file_never_gives_settings_that_nobody_chose():
    draw = random.Random(15)
    junk = [None, True, -1, 3, 2.5, "", "fr", "SUN", [], {}, "sun\x00", 10**30]
    for _ in range(draws(125)):
        values = values_of(WindowSettings())
        name = draw.choice(list(values))
        values[name] = draw.choice(junk)
        with raises_fault(faults.SETTINGS_DAMAGED):
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


def test_the_last_of_many_changes_is_what_is_remembered(tmp_path):
    file = SettingsFile(tmp_path / "window.yaml")
    memory = WindowMemory(file)
    draw = random.Random(3)
    for _ in range(20):
        memory.change(dim_after_min=draw.choice(DIM_CHOICES_MIN), theme=draw.choice(list(Theme)))
    assert memory.close(10.0)
    assert WindowMemory(file).settings == memory.settings


def test_each_choice_takes_effect_at_once_and_at_the_next_start(opened, tmp_path):
    file = SettingsFile(tmp_path / "window.yaml")
    memory = WindowMemory(file)
    window = opened(memory=memory)
    window.on_event(SurveysListed("", (past_survey(),), True))
    window.traces.live.begin(make_grid())
    window.show_tab(TabName.ROBOT)
    show(window, snapshot(SurveyState.IDLE))
    hint, title = window.robot.overview.hint.text(), window.top_bar.band.title.whole
    sheet = window.settings
    click(window.rail.settings)
    assert sheet.isVisible()
    assert sheet.languages[Language.ENGLISH].isChecked()
    click(sheet.languages[Language.SPANISH])
    click(sheet.themes[Theme.NIGHT])
    click(sheet.dim_choices[10])
    QTest.qWait(1)  # the change of language is an event
    assert sheet.title.text() == "Ajustes"
    assert window.robot.overview.hint.text() not in ("", hint)
    assert window.top_bar.band.title.whole not in ("", title)
    window.show_tab(TabName.GROUND)
    assert "Sin eco no significa sin mina." in window.ground.view.note.text()
    assert window.ground.view.set_marker.text() == "Poner\nmarca"
    window.ground.layers.background.click()
    assert window.ground.layers.background.text() == "Fondo\nincluido"
    assert window.look.theme is Theme.NIGHT
    click(sheet.close_button)
    assert not sheet.isVisible()
    assert memory.close(10.0)

    remembered = WindowMemory(file)
    assert remembered.settings == WindowSettings(Language.SPANISH, Theme.NIGHT, 10)
    window = opened(memory=remembered, language=remembered.settings.language)
    assert window.look.theme is Theme.NIGHT
    click(window.rail.settings)
    assert window.settings.languages[Language.SPANISH].isChecked()

"""Settings, plans and languages on the disk: remembered, and damage is said."""

import random
import subprocess
from pathlib import Path

import pytest
from fault_kit import raises_fault
from PyQt5.QtTest import QTest
from run_seed import draws
from tutorial_code import code_blocks
from view_kit import make_grid, snapshot
from window_helpers import click, show, until

from gpr20_common.catalogue import (
    VARIABLE,
    Language,
    language_from_environment,
    languages,
    read_catalogue,
)
from gpr20_common.message import Message
from gpr20_operator import faults
from gpr20_operator.palette import Theme
from gpr20_operator.plan.fields import Tile
from gpr20_operator.settings_file import SettingsFile
from gpr20_survey.plan.survey_state import SurveyState
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

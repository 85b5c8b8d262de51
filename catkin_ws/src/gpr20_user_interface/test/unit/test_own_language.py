"""A language of somebody else's: the tutorial docs/extend/language.md, and a pseudo-language."""

import subprocess
from pathlib import Path

import pytest
from pseudo_language import PSEUDO, write_pseudo_catalogue
from tutorial_code import code_blocks
from window_helpers import click, close, opened_window, until

from gpr20_analysis.commands import main as gpr20
from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import VARIABLE, languages, read_catalogue
from gpr20_operator.files.settings_file import SettingsFile
from gpr20_user_interface.look.settings import WindowMemory
from gpr20_user_interface.terminal.survey_arguments import terminal_language

ROOT = Path(__file__).parents[5]
PAGE = ROOT / "docs/extend/language.md"
TRANSLATIONS = ROOT / "scripts/translations.sh"
PORTUGUESE = Language("pt", "Português")
LEFT_OUT = "Colours"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The catalogues of this computer."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    (tmp_path / "pt.po").write_text(code_blocks(PAGE, "po")["pt.po"], encoding="utf-8")
    write_pseudo_catalogue(tmp_path, leave_out=LEFT_OUT)
    return tmp_path


def test_the_languages_are_the_catalogues_found_and_what_one_lacks_is_english(folder, capsys):
    assert languages() == [Language.ENGLISH, Language.SPANISH, PORTUGUESE, PSEUDO]
    portuguese = read_catalogue(PORTUGUESE)
    assert portuguese.template("START") == "INICIAR"
    assert portuguese.template("Colours") == "Colours"
    assert gpr20.main(["info", "/nowhere", "--language", "pt"]) == 3
    assert "/nowhere não existe" in capsys.readouterr().err
    assert terminal_language([], {"LANG": "pt_BR.UTF-8"}) == PORTUGUESE
    (folder / "es.po").write_text('msgid "START"\nmsgstr "¡YA!"\n')
    spanish = read_catalogue(Language.SPANISH)
    # Other words on this computer; the rest is that of the project.
    assert (spanish.template("START"), spanish.template("Settings")) == ("¡YA!", "Ajustes")


def test_a_translation_with_other_values_than_its_template_is_not_used(folder):
    entries = {"one {a}": "um {b}", "two {a:.3f}": "dois {a}", "three {a}": "três {a} {a}"}
    entries.update({"four {a}": "quatro {", "five {a} {b}": "cinco {b} {a}"})
    lines = [f'msgid "{template}"\nmsgstr "{text}"\n' for template, text in entries.items()]
    (folder / "pt.po").write_text("\n".join(lines))
    catalogue = read_catalogue(PORTUGUESE)
    used = {template for template in entries if catalogue.template(template) != template}
    assert used == {"five {a} {b}"}


@pytest.fixture
def window(application, folder):
    memory = WindowMemory(SettingsFile(folder / "window.yaml"))
    window = opened_window(application, profiles=folder, memory=memory)
    window.memory = memory
    yield window
    close(window)


def test_the_window_offers_and_uses_it_and_remembers_it(window, folder):
    sheet = window.settings
    click(window.rail.settings)
    assert sheet.languages[PSEUDO].text() == PSEUDO.own_name
    click(sheet.languages[PSEUDO])
    assert until(lambda: sheet.title.text().startswith("Séttîñgš"))
    assert sheet.labels[1].text() == LEFT_OUT
    assert window.memory.close(30.0)
    assert WindowMemory(SettingsFile(folder / "window.yaml")).settings.language == PSEUDO


def test_a_damaged_catalogue_is_named_and_the_window_keeps_its_language(window, folder):
    (folder / "pt.po").write_text('msgid "START"\nmsgstr\n')
    sheet = window.settings
    click(window.rail.settings)
    click(sheet.languages[PORTUGUESE])
    assert f"{folder}/pt.po" in sheet.hint.text()
    assert sheet.languages[Language.ENGLISH].isChecked()
    assert window.memory.settings.language == Language.ENGLISH


@pytest.mark.release
def test_the_commands_of_the_page_begin_check_and_update_a_catalogue(tmp_path):
    path = tmp_path / "fr.po"

    def run(*arguments):
        command = [str(TRANSLATIONS), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    assert run("--new", path, "Français").returncode == 0
    assert "X-Language-Name: Français" in path.read_text()
    with path.open("a") as file:
        file.write('\nmsgid "no program has this"\nmsgstr "rien"\n')
    checked = run("--check", path)
    assert checked.returncode != 0 and "not used" in checked.stderr
    assert run(path).returncode == 0
    assert "no program has this" not in path.read_text()

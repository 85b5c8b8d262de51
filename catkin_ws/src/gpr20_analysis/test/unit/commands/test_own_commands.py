"""Commands of other packages: the page docs/extend/command.md, and what they may not do."""

import re
import sys
from pathlib import Path

import pytest
from command_kit import install
from tutorial_code import code_blocks

from gpr20_analysis import entry_points, faults
from gpr20_analysis.commands import command
from gpr20_analysis.commands.main import main

PAGE = Path(__file__).parents[6] / "docs/extend/command.md"
CODE = {**code_blocks(PAGE, "python"), **code_blocks(PAGE, "toml")}
ENTRY = "[gpr20.commands]\ncorners = my_commands:CORNERS\n"
SUMMARY = "print 100 % of the corners"


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder with the package of the page, as pip installs it."""
    folder = tmp_path / "site"
    install(folder, ENTRY, "my-commands", summary=SUMMARY)
    (folder / "my_commands.py").write_text(CODE["my_commands.py"])
    monkeypatch.syspath_prepend(folder)
    yield folder
    sys.modules.pop("my_commands", None)


@pytest.fixture
def without_others(monkeypatch):
    """Nothing is installed that adds a command."""
    for module in (command, entry_points):
        monkeypatch.setattr(module, "additions", lambda group: [])


def refused(arguments, capsys, *shown):
    """Call gpr20, which refuses; check the names in the one or two lines that it prints."""
    assert main(arguments) == command.REFUSED
    error = capsys.readouterr().err
    assert "Traceback" not in error and len(error.splitlines()) <= 2
    for one in shown:
        assert one in error, error


def test_the_commands_of_the_page_run(site, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in re.findall(r"^gpr20 (\w+ survey.mcap)$", PAGE.read_text(), re.MULTILINE):
        assert main(line.split()) == command.DONE
    assert re.search(r"^x: \S+ to \S+ m\ny: \S+ to \S+ m$", capsys.readouterr().out, re.MULTILINE)


def test_the_entry_point_is_that_of_the_page():
    assert 'commands"]\ncorners = "my_commands:CORNERS"' in CODE["pyproject.toml"]


def test_help_shows_the_summary_of_the_package_and_imports_nothing_of_it(site, capsys):
    assert main(["--help"]) == command.DONE
    printed = capsys.readouterr().out
    assert re.search(rf"corners +{SUMMARY}", printed)
    assert "my_commands" not in sys.modules


def test_a_command_explains_itself(site, capsys):
    assert main(["corners", "--help"]) == command.DONE
    assert "Print the corners of a survey." in capsys.readouterr().out


def test_two_packages_with_one_command_are_named_and_neither_runs(site, refusals, capsys):
    install(site, "[gpr20.commands]\ncorners = other:CORNERS\n", "other")
    refused(["corners", "x"], capsys, "my-commands 1.0, my_commands:", "other 1.0, other:CORNERS")
    assert refusals == [faults.ADDITION.code]
    assert main(["--help"]) == command.DONE


def test_no_package_replaces_a_command_of_gpr20(site, capsys):
    install(site, "[gpr20.commands]\nverify = no_such_module:X\n", "other", summary="not this one")
    assert main(["verify", "--help"]) == main(["--help"]) == command.DONE
    assert "not this one" not in capsys.readouterr().out


@pytest.mark.parametrize(
    "code, shown",
    [
        ("1 / 0", "ZeroDivisionError"),
        ("import no_such_library", "no_such_library"),
        ("", "AttributeError"),
        ("CORNERS = 'print'", "str"),
    ],
)
def test_a_command_that_cannot_be_used_is_refused_with_the_reason(
    site, refusals, capsys, code, shown
):
    (site / "my_commands.py").write_text(code)
    refused(["corners", "x"], capsys, "corners", "my-commands 1.0, my_commands:CORNERS", shown)
    assert refusals == [faults.ADDITION.code]
    # The others are not touched by it.
    assert main(["info", "--help"]) == main(["--help"]) == command.DONE


@pytest.mark.parametrize("name", command.COMMANDS.wings)
def test_a_command_of_an_absent_package_names_the_package(without_others, refusals, capsys, name):
    package = command.COMMANDS.wings[name]
    refused([name, "x"], capsys, f"pip install 'catkin_ws/src/{package}'")
    assert refusals == [faults.LIBRARY.code]
    assert main(["--help"]) == command.DONE
    assert re.search(rf"{name} +.*{package}", capsys.readouterr().out)


def test_an_unknown_command_is_refused(site):
    assert main(["no_such_command"]) == command.REFUSED

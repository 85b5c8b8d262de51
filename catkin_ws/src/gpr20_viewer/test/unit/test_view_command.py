"""How gpr20 finds the command view; nothing here needs Qt."""

import ast
import subprocess
import sys
from pathlib import Path

from command_kit import install

from gpr20_analysis.commands import command
from gpr20_analysis.commands.main import main
from gpr20_viewer.view_command import COMMAND

PACKAGE = Path(__file__).resolve().parents[2]
# What only the window needs.
HEAVY = ("PyQt5", "pyqtgraph", "OpenGL")


def test_help_of_gpr20_says_what_the_command_is_for(installed, capsys):
    assert main(["--help"]) == 0
    assert "look at a survey in a window" in capsys.readouterr().out


def test_the_command_explains_itself_without_the_libraries_of_the_window(installed, tmp_path):
    program = (
        f"import sys; sys.path[:0] = {[str(tmp_path / 'site'), *sys.path]}\n"
        "from gpr20_analysis.commands.main import main\n"
        "assert main(['view', '--help']) == 0\n"
        f"assert not set({HEAVY}) & set(sys.modules)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert "--picks FILE" in ended.stdout


def test_gpr20_names_the_package_of_the_command_where_it_is_not_installed():
    assert command.COMMANDS.wings["view"] == PACKAGE.name


def test_pip_and_catkin_install_the_same_entry_point_and_summary(installed):
    (call,) = (
        node
        for node in ast.walk(ast.parse((PACKAGE / "setup.py").read_text()))
        if isinstance(node, ast.keyword) and node.arg == "entry_points"
    )
    ((group, entries),) = ast.literal_eval(call.value).items()
    assert installed == "\n".join([f"[{group}]", *entries, ""])
    assert command.load("view") is COMMAND
    text = (PACKAGE / "package.xml").read_text()
    assert f"<description>{command.summaries()['view']}</description>" in text


def test_the_command_of_a_package_in_two_places_is_one(installed, tmp_path, monkeypatch):
    install(tmp_path / "second", installed, "gpr20_viewer", "2.0")
    monkeypatch.syspath_prepend(tmp_path / "second")
    assert command.load("view") is COMMAND

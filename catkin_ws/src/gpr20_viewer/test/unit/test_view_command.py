"""How gpr20 finds the command view; nothing here needs Qt."""

import ast
import subprocess
import sys
from pathlib import Path

from command_kit import install

from gpr20_analysis.commands import command
from gpr20_viewer.view_command import COMMAND

PACKAGE = Path(__file__).resolve().parents[2]
# What only the window needs.
HEAVY = ("PyQt5", "pyqtgraph", "OpenGL")


def test_the_command_explains_itself_without_the_libraries_of_the_window(installed, tmp_path):
    program = (
        f"import sys; sys.path[:0] = {[str(tmp_path / 'site'), *sys.path]}\n"
        "from gpr20_analysis.commands.main import main\n"
        "assert main(['--help']) == main(['view', '--help']) == 0\n"
        f"assert not set({HEAVY}) & set(sys.modules)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert "look at a survey in a window" in ended.stdout and "--picks FILE" in ended.stdout


def test_pip_and_catkin_install_the_same_command_once(installed, tmp_path, monkeypatch):
    assert command.COMMANDS.wings["view"] == PACKAGE.name
    (call,) = (
        node
        for node in ast.walk(ast.parse((PACKAGE / "setup.py").read_text()))
        if isinstance(node, ast.keyword) and node.arg == "entry_points"
    )
    ((group, entries),) = ast.literal_eval(call.value).items()
    assert installed == "\n".join([f"[{group}]", *entries, ""])
    text = (PACKAGE / "package.xml").read_text()
    assert f"<description>{command.summaries()['view']}</description>" in text
    install(tmp_path / "second", installed, "gpr20_viewer", "2.0")
    monkeypatch.syspath_prepend(tmp_path / "second")
    assert command.load("view") is COMMAND

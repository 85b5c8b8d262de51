from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from gpr20_launch.low import needed_modules
from gpr20_launch.low.needed_modules import what_to_install

CHECK = Path(__file__).resolve().parents[2] / "nodes" / "check_launch"
SOURCES = Path(__file__).resolve().parents[2] / "src"


def test_nothing_is_said_where_nothing_is_missing():
    assert what_to_install(lambda module: True) is None


def test_what_is_missing_is_named_with_the_commands_that_install_it(monkeypatch):
    monkeypatch.delenv("CMAKE_PREFIX_PATH", raising=False)
    missing = {"actionlib_msgs", "yaml", "vxi11", "mcap"}
    said = what_to_install(lambda module: module not in missing)
    assert f"{sys.executable} (Python 3." in said
    assert "lacks the modules actionlib_msgs, yaml, mcap, vxi11." in said
    assert "sudo apt-get install python3-actionlib-msgs python3-yaml\n" in said
    assert "python3 -m pip install mcap python-vxi11\n" in said


def test_packages_of_ros_have_the_names_of_the_ros_that_was_sourced(monkeypatch):
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"/home/user/install:{needed_modules.NOETIC}")
    said = what_to_install(lambda module: module != "diagnostic_updater")
    assert "sudo apt-get install ros-noetic-diagnostic-updater\n" in said
    assert "pip" not in said


def test_a_launch_without_them_is_refused_with_one_text_and_no_traceback():
    ended = subprocess.run(
        # Neither the packages of the system nor those of an environment.
        [sys.executable, "-S", str(CHECK)],
        env={"PYTHONPATH": str(SOURCES)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 1
    assert "This robot cannot be launched: " in ended.stderr
    assert "lacks the modules actionlib, " in ended.stderr
    assert "Traceback" not in ended.stderr

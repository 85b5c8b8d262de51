"""The process of the window: how it ends without a display, a master or a name of its own."""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("rospy")

from gpr20_common.message import Message
from gpr20_operator.errors import MasterUnavailableError
from gpr20_user_interface.high import user_interface

PROGRAM = Path(__file__).resolve().parents[2] / "nodes" / "user_interface"
PLATFORM = ("QT_QPA_PLATFORM", "WAYLAND_DISPLAY")


def test_without_a_display_it_says_how_to_run_without_a_window():
    kept = {name: value for name, value in os.environ.items() if name not in PLATFORM}
    command = [sys.executable, str(PROGRAM)]
    ended = subprocess.run(
        command, env={**kept, "DISPLAY": ""}, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 3 and "ui:=false" in ended.stdout + ended.stderr


def test_it_ends_without_a_master_or_as_a_replay_in_the_namespace_of_a_robot(monkeypatch, capsys):
    monkeypatch.setattr(user_interface, "check_display", lambda: None)

    def run(replay):
        return user_interface._run(argparse.Namespace(replay=replay, wait_for_display=False))

    # Two windows of one name: the master would end that of the robot.
    asked = []
    there = SimpleNamespace(lookupNode=asked.append)
    monkeypatch.setattr(user_interface.rosgraph, "Master", lambda _name: there)
    assert run(replay=True) == 2 and asked == ["/main_control"]
    assert "a robot has the namespace" in capsys.readouterr().err

    def join(*_given):
        raise MasterUnavailableError(Message("no ROS master answers"))

    monkeypatch.setattr(user_interface, "join_graph", join)
    assert run(replay=False) == 1

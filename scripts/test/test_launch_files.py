"""What the launch files make of their arguments, read as roslaunch reads them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from case_kit import each_case
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

LAUNCH = Path(__file__).resolve().parents[2] / "launch/survey.launch"


@pytest.fixture(autouse=True)
def no_check(tmp_path, monkeypatch):
    """Read the files without their check of the robot, which has its own tests."""
    (tmp_path / "rosrun").write_text("#!/bin/sh\n")
    (tmp_path / "rosrun").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")


def nodes_of(*arguments: str):
    config = ROSLaunchConfig()
    XmlLoader(resolve_anon=True).load(str(LAUNCH), config, argv=list(arguments))
    return {node.name: node for node in config.nodes}


@each_case("robot, is_real", [("gpr20", True), ("simulated", False)])
def test_the_window_of_the_real_robot_covers_its_screen_and_comes_back(robot, is_real):
    nodes = nodes_of(f"robot:={robot}", "web:=true")
    window = nodes.pop("user_interface")
    assert window.respawn is is_real
    assert f"_full_screen:={is_real}" in window.args
    assert ("--wait-for-display" in window.args) is is_real
    assert "_language:=auto" in window.args
    # Every other node comes back too, and the watchdog finds it by its arguments.
    assert {name for name, node in nodes.items() if not node.respawn} == set()
    unwatched = {name for name, node in nodes.items() if "configuration:=/launch" not in node.args}
    assert unwatched == {"watchdog", "visualization"}
    other = (f"full_screen:={str(not is_real).lower()}", "language:=es")
    window = nodes_of(f"robot:={robot}", *other)["user_interface"]
    assert f"_full_screen:={not is_real}" in window.args
    assert ("--wait-for-display" in window.args) is is_real
    assert "_language:=es" in window.args
    without = nodes_of(f"robot:={robot}", "ui:=false")
    assert without.keys() == nodes.keys() - {"web"}

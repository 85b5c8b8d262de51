"""What the launch files make of their arguments, read as roslaunch reads them."""

from __future__ import annotations

import functools
from pathlib import Path

import pytest
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

LAUNCH = Path(__file__).resolve().parents[2] / "launch"


# Several tests ask about the same launch; each takes a second to read.
@functools.lru_cache(maxsize=None)
def all_nodes(file: str, *arguments: str):
    config = ROSLaunchConfig()
    XmlLoader(resolve_anon=True).load(str(LAUNCH / file), config, argv=list(arguments))
    return tuple(config.nodes)


def nodes_of(file: str, *arguments: str):
    return {node.name: node for node in all_nodes(file, *arguments)}


@pytest.mark.parametrize("robot, comes_back", [("gpr20", True), ("simulated", False)])
def test_the_window_of_the_real_robot_comes_back_by_itself(robot, comes_back):
    nodes = nodes_of("survey.launch", f"robot:={robot}")
    assert nodes["user_interface"].respawn is comes_back


@pytest.mark.parametrize("robot", ["gpr20", "simulated"])
def test_every_node_of_the_robot_comes_back_by_itself(robot):
    nodes = nodes_of("survey.launch", f"robot:={robot}", "ui:=false")
    assert "user_interface" not in nodes
    assert {name for name, node in nodes.items() if not node.respawn} == set()


@pytest.mark.parametrize(
    "arguments, covers_screen, waits",
    [
        (("robot:=gpr20",), True, True),
        (("robot:=gpr20", "full_screen:=false"), False, True),
        (("robot:=simulated",), False, False),
        (("robot:=simulated", "full_screen:=true"), True, False),
    ],
)
def test_the_window_covers_the_screen_of_the_real_robot(arguments, covers_screen, waits):
    window = nodes_of("survey.launch", *arguments)["user_interface"]
    assert f"_full_screen:={covers_screen}" in window.args
    assert ("--wait-for-display" in window.args) is waits


def test_the_window_keeps_its_language_unless_the_launch_names_one():
    window = nodes_of("survey.launch", "robot:=simulated")["user_interface"]
    assert "_language:=auto" in window.args
    assert "_language:=es" in nodes_of("survey.launch", "language:=es")["user_interface"].args


@pytest.mark.parametrize("robot, chooses", [("gpr20", False), ("simulated", True)])
def test_stop_on_a_real_robot_is_always_its_own(robot, chooses):
    window = nodes_of("survey.launch", f"robot:={robot}")["user_interface"]
    assert f"_choose_robot:={chooses}" in window.args


@pytest.mark.parametrize("file", ["survey.launch", "server.launch"])
def test_the_web_page_runs_where_the_surveys_are_only_if_it_is_asked_for(file):
    assert "web" not in nodes_of(file)
    page = nodes_of(file, "web:=true")["web"]
    assert (page.package, page.type, page.respawn, page.required) == (
        *("gpr20_web", "web", True, False),
    )
    # As the watchdog finds it, and with the section of its own launch.
    assert page.args.startswith("configuration:=/launch")


@pytest.mark.parametrize("file", ["survey.launch", "robot.launch", "server.launch"])
def test_every_node_of_a_robot_is_in_its_namespace(file):
    nodes = all_nodes(file, "ns:=robot7")
    assert {node.namespace.split("/")[1] for node in nodes} == {"robot7"}

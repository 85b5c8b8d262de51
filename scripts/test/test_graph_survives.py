"""Surveys continue through a ROS master that is killed, and beside a second launch.

GPR20_MASTER_KILLS is how many surveys have their master killed (2).
"""

from __future__ import annotations

import os
import random
import time

import pytest
from fault_kit import raises_fault
from robot_kit import MASTER, NODES, LaunchedRobot, free_port
from run_seed import SEED
from user_shell import has_bag, printed_by
from wait_kit import wait_until

pytest.importorskip("rosgraph")

import rosgraph

from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files.durable_files import locked

KILLS = int(os.environ.get("GPR20_MASTER_KILLS", "2"))
SIDE = 4
TRACES = 2 * SIDE * SIDE
AREA = ("--x-points", str(SIDE), "--y-points", str(SIDE))
LIMIT_S = 60.0
NAME = "/test_graph_survives"


@pytest.fixture
def robot(tmp_path, monkeypatch):
    # The kit sets both in the environment.
    monkeypatch.setenv("ROS_MASTER_URI", "")
    monkeypatch.setenv("GPR20_STATE", "")
    robot = LaunchedRobot(tmp_path, "time_scale:=20", apart=True)
    try:
        robot.start()
        log = tmp_path / "launch.log"
        wait_until(lambda: log.read_text(errors="replace").count(" is ready") > len(NODES) - 2)
        yield robot
    finally:
        robot.stop()


def registrations():
    """Return what the master knows: kind, name and node of each; nothing while none answers."""
    try:
        state = rosgraph.Master(NAME).getSystemState()
    except (OSError, rosgraph.MasterException):
        return set()
    return {
        (kind, name, node)
        for kind, entries in enumerate(state)
        for name, nodes in entries
        for node in nodes
    }


def folders(robot):
    return sorted(one.parent for one in robot.data.glob("*/survey.json"))


def stored(robot, surveys):
    """Return how many traces the last of so many surveys has."""
    found = folders(robot)
    return len(list(found[-1].glob("traces/*.json"))) if len(found) == surveys else 0


def check_complete(folder):
    wait_until(lambda: has_bag(folder))
    found = verify_survey(folder)
    assert (found.status, found.faults) == (COMPLETE, []), found.verdict
    assert len(list(folder.glob("traces/*.json"))) == TRACES


@pytest.mark.timeout(300 + 60 * KILLS)
def test_a_survey_continues_under_a_master_that_comes_back_empty(robot):
    draw, known = random.Random(SEED), registrations()
    for number in range(1, KILLS + 1):
        client = robot.client(*AREA)
        moment = draw.randrange(TRACES - 4)
        wait_until(lambda: stored(robot, number) > moment, alive=[client])  # noqa: B023
        begun_s = time.monotonic()
        assert robot.kill(MASTER)
        if number % 2 == 0:
            # It finds its configuration when the others have filled the master.
            assert robot.kill("height_sensor")
        wait_until(lambda: known <= registrations(), limit_s=LIMIT_S)
        print(f"{number}: killed after {moment} traces, filled {time.monotonic() - begun_s:.1f} s")
        assert client.wait(LIMIT_S) == 0
        check_complete(folders(robot)[-1])
    nodes = printed_by("rosnode", "list").split()
    assert {name.replace("-", "/") for name in NODES} <= {name[1:] for name in nodes}
    assert "success: False" in printed_by("rosservice", "call", "/stop_survey")
    assert "code:" in printed_by("timeout", "30", "rostopic", "echo", "-n", "1", "/control_status")


@pytest.mark.timeout(600)
def test_a_survey_goes_on_beside_a_second_launch_that_finds_an_empty_master(robot):
    client, uri = robot.client("--x-points=40", "--y-points=40"), f"http://127.0.0.1:{free_port()}"
    wait_until(lambda: stored(robot, 1) > 2, alive=[client])
    # A simulated robot is the same one under a master of the same run.
    run = rosgraph.Master(NAME).getParam("/run_id")
    launch = ("gpr20", "survey.launch", "ui:=false", f"data:={robot.data}", "--run_id", run)
    said = printed_by("timeout", "-s", "INT", "400", "roslaunch", *launch, ROS_MASTER_URI=uri)
    assert "cannot start: another process drives this axis" in said
    before, (folder,) = stored(robot, 1), folders(robot)
    with raises_fault("survey.locked", error=SurveyRefusedError), locked(folder):
        pass
    wait_until(lambda: stored(robot, 1) > before + 2, alive=[client])
    assert "success: True" in printed_by("rosservice", "call", "/stop_survey")
    assert client.wait(LIMIT_S) != 0
    assert verify_survey(folder).faults == []

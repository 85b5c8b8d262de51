"""Launches that cannot start, that end in the middle of a survey, and that leave nodes behind."""

from __future__ import annotations

import os
import re
import signal
import subprocess

import psutil
import pytest
from robot_kit import WATCHDOG, LaunchedRobot, free_port
from user_shell import printed_by

LIMIT_S = 120.0
OTHERS = signal.SIGHUP, signal.SIGTERM


@pytest.fixture
def robot(tmp_path, monkeypatch, request):
    # The kit sets both in the environment.
    monkeypatch.setenv("ROS_MASTER_URI", "")
    monkeypatch.setenv("GPR20_STATE", "")
    robot = LaunchedRobot(tmp_path, "time_scale:=20", **getattr(request, "param", {}))
    yield robot
    robot.stop()
    for process in robot.processes().values():
        process.kill()


def test_a_launch_ends_when_a_node_cannot_start(tmp_path):
    command = ["roslaunch", "-p", free_port(), "gpr20", "survey.launch", "robot:=gpr20"]
    said = printed_by(*command, "ui:=false", f"data:={tmp_path}", status=None)
    refusals = re.findall(r"(\S+) cannot start: this computer has no", said)
    assert refusals and len(refusals) == len(set(refusals)), "each node says it once"
    assert "ends the launch, because it cannot start" in said
    assert "restarting process" not in said
    # Python says that of a log that ROS has closed before the last message.
    assert "Traceback" not in said or "Logging error" in said


def test_nodes_that_outlive_their_roslaunch_are_named_with_the_command_that_ends_them(robot):
    robot.start()
    roslaunch = psutil.Process(next(iter(robot.processes().values())).ppid())
    children = roslaunch.children()
    # The watchdog is no node, and ends with its roslaunch. The next launch uses master and rosout.
    shared = [one for one in children if re.search("rosmaster|rosout", " ".join(one.cmdline()))]
    assert len(shared) == 2
    nodes = [one for one in children if one not in (robot.processes()[WATCHDOG], *shared)]
    roslaunch.kill()
    roslaunch.wait(LIMIT_S)
    master = os.environ["ROS_MASTER_URI"]
    said = printed_by("roslaunch", "gpr20", "survey.launch", "ui:=false", status=None)
    assert f"a robot is running on {master}: " in said
    (command,) = re.findall(r"can be resumed: (kill [\d ]+)", said)
    assert {int(word) for word in command.split()[1:]} == {one.pid for one in nodes}
    subprocess.run(command.split(), check=True)
    _ended, alive = psutil.wait_procs(nodes, LIMIT_S)
    assert alive == []
    for one in shared:
        one.kill()


@pytest.mark.parametrize(
    "number", [signal.SIGINT, *(pytest.param(one, marks=pytest.mark.release) for one in OTHERS)]
)
@pytest.mark.parametrize("robot", [{"apart": True}], indirect=True)
def test_a_service_or_terminal_that_ends_ends_launch_and_master_as_ctrl_c_does(robot, number):
    robot.start()
    started = robot.processes()
    # As systemd does: the signal goes to the main process alone.
    roslaunch = psutil.Process(started["main_control"].ppid())
    roslaunch.parent().send_signal(number)
    _ended, alive = psutil.wait_procs([roslaunch, *started.values()], LIMIT_S)
    assert alive == []

"""The web page of a launch: whatever happens to it, the survey continues."""

from __future__ import annotations

import socket
import subprocess
import time

import psutil
import pytest
from robot_kit import WATCHDOG, LaunchedRobot, free_port

LIMIT_S = 120.0


@pytest.fixture
def port():
    return free_port()


@pytest.fixture
def robot(tmp_path, monkeypatch, port):
    # The kit sets both in the environment.
    monkeypatch.setenv("ROS_MASTER_URI", "")
    monkeypatch.setenv("GPR20_STATE", "")
    config = tmp_path / "robot"
    config.mkdir()
    (config / "web.yaml").write_text(f"port: {port}\nfolder: {tmp_path}/web\n")
    robot = LaunchedRobot(tmp_path, "time_scale:=20", "web:=true", f"config:={config}")
    yield robot
    robot.stop()


def wait_for(condition, what):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, f"no {what} within {LIMIT_S} s"
        time.sleep(0.05)


def answers(port):
    try:
        socket.create_connection(("127.0.0.1", port), 1.0).close()
    except OSError:
        return False
    return True


def page_of(robot):
    """Return the process of the page; None while there is none."""
    launch = psutil.Process(robot.processes()[WATCHDOG].ppid())
    return next((one for one in launch.children() if one.name() == "web"), None)


def is_watched(robot, page):
    """Return whether the watchdog has asked the node, whose connection it keeps."""
    ports = {one.laddr.port for one in page.connections() if one.status == psutil.CONN_LISTEN}
    asked = robot.processes()[WATCHDOG].connections()
    return any(one.raddr and one.raddr.port in ports for one in asked)


def test_a_page_that_hangs_is_restarted_beside_a_survey_that_ends_whole(robot, port):
    robot.start()
    wait_for(lambda: answers(port), "page")
    client = robot.client("--x-points", "6", "--y-points", "6", stdout=subprocess.DEVNULL)
    first = page_of(robot)
    wait_for(lambda: is_watched(robot, first), "question of the watchdog")
    first.suspend()
    wait_for(lambda: not first.is_running() and page_of(robot) not in (None, first), "other page")
    assert client.wait(LIMIT_S) == 0
    wait_for(lambda: answers(port), "answer of the other page")
    log = (robot.data.parent / "launch.log").read_text()
    assert "PAUSED" not in log and "FAILED" not in log, log


def test_a_port_that_is_taken_keeps_only_the_page_away(robot, port):
    with socket.create_server(("127.0.0.1", port)):
        robot.start()
        points = ("--x-points", "3", "--y-points", "3")
        assert robot.client(*points, stdout=subprocess.DEVNULL).wait(LIMIT_S) == 0
    wait_for(lambda: answers(port), "page")
    assert "cannot listen" in (robot.data.parent / "launch.log").read_text()

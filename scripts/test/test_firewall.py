"""Two machines behind the guide's firewall rules: a survey runs, and nobody else gets in."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from network_namespaces import (
    ROBOT,
    ROBOT_STRANGER,
    SERVER,
    SERVER_STRANGER,
    relayed,
    two_machines,
)
from user_shell import Terminal, is_ready, user_environment, wait_until

pytestmark = [
    pytest.mark.real_time,
    pytest.mark.takes(60),
    pytest.mark.skipif(os.geteuid() != 0, reason="network namespaces need root"),
]

PORT = 11311
SURVEY = "rosrun gpr20_user_interface run_survey --wait 60 --x-points 5 --y-points 5"
# Nodes of each machine; each of them has a server for calls and one for topics.
NODES = {"server": 4, "robot": 5}


def test_the_rules_of_the_guide_shut_out_everybody_but_the_other_machine():
    with two_machines() as (server, robot):
        listener = subprocess.Popen(
            [*server.prefix, sys.executable, "-m", "http.server", str(PORT)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            wait_until(
                lambda: robot.reached(ROBOT_STRANGER, SERVER, [PORT]), listener, limit_s=20.0
            )
            server.shut_out_others()
            assert robot.reached(ROBOT, SERVER, [PORT])
            assert server.reached(SERVER, SERVER, [PORT])
            assert not robot.reached(ROBOT_STRANGER, SERVER, [PORT])
        finally:
            listener.kill()
            listener.wait()


def is_loopback(address):
    return address.startswith("127.")


def open_ports(machine):
    return {port for address, port in machine.listening() if not is_loopback(address)}


def test_a_survey_runs_on_two_machines_and_a_third_one_reaches_none_of_their_ports(tmp_path):
    environment = user_environment(
        tmp_path / "surveys", GPR20_ROBOT=ROBOT, GPR20_SERVER=SERVER, ROS_HOME=str(tmp_path / "ros")
    )
    with two_machines() as (server, robot), (tmp_path / "printed.log").open("wb") as log:
        for machine in (server, robot):
            machine.shut_out_others()
        on_server = Terminal(log, environment, server.prefix)
        on_robot = Terminal(log, environment, robot.prefix)
        try:
            control = on_server.start("roslaunch gpr20 server.launch time_scale:=50")
            axes = on_robot.start("roslaunch --wait gpr20 robot.launch time_scale:=50 ui:=false")
            wait_until(lambda: is_ready(tmp_path / "printed.log"), control, axes)
            # The simulated VNA is behind the loopback of the robot, which a real one is not.
            wait_until(lambda: simulated_vna(robot), control, axes)
            with relayed(simulated_vna(robot), server, robot, tmp_path):
                assert on_robot.run(SURVEY) == 0
                assert_closed_to_strangers(server, robot)
        finally:
            on_robot.close()
            on_server.close()
    (survey,) = tmp_path.glob("surveys/*/survey.json")
    assert json.loads(survey.read_text())["outcome"] == "finished"
    assert len(list(survey.parent.glob("traces/*.json"))) == 5 * 5 * 2


def simulated_vna(robot):
    """Return the ports of the simulated VNA, as soon as it listens: core and abort channel."""
    ports = [port for address, port in robot.listening() if is_loopback(address)]
    return ports if len(ports) == 2 else []


def assert_closed_to_strangers(server, robot):
    ports = open_ports(server)
    # The master, and two servers of every node.
    assert len(ports) >= 1 + 2 * NODES["server"]
    assert PORT in ports
    assert robot.reached(ROBOT, SERVER, ports) == ports
    assert robot.reached(ROBOT_STRANGER, SERVER, ports) == set()
    ports = open_ports(robot)
    assert len(ports) >= 2 * NODES["robot"]
    assert server.reached(SERVER, ROBOT, ports) == ports
    assert server.reached(SERVER_STRANGER, ROBOT, ports) == set()

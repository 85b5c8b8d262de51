"""Two machines behind the guide's firewall rules: a survey runs, and nobody else gets in."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter

import pytest
from network_namespaces import (
    ROBOT,
    ROBOT_STRANGER,
    SERVER,
    SERVER_STRANGER,
    two_machines,
)
from two_machine_survey import CLIENT, is_loopback, launched, outcome, stored_traces
from user_shell import wait_until

pytestmark = [
    pytest.mark.real_time,
    pytest.mark.takes(60),
    pytest.mark.skipif(os.geteuid() != 0, reason="network namespaces need root"),
]

PORT = 11311
SURVEY = f"{CLIENT} --x-points 5 --y-points 5"
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


def open_ports(machine):
    return {port for address, port in machine.listening() if not is_loopback(address)}


def test_a_survey_runs_on_two_machines_and_a_third_one_reaches_none_of_their_ports(tmp_path):
    with two_machines() as (server, robot):
        for machine in (server, robot):
            machine.shut_out_others()
        with launched(server, robot, tmp_path) as (_on_server, on_robot):
            assert on_robot.run(SURVEY) == 0
            assert_closed_to_strangers(server, robot)
    assert outcome(tmp_path) == "finished"
    assert stored_traces(tmp_path) == Counter(range(5 * 5 * 2))


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

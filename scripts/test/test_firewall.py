"""Two machines behind the firewall of docs/install.md: a survey runs, nobody else gets in."""

from __future__ import annotations

from collections import Counter

import pytest
from network_namespaces import (
    CLIENT,
    ROBOT,
    ROBOT_STRANGER,
    SERVER,
    SERVER_STRANGER,
    firewall_commands,
    launched,
    outcome,
    stored_traces,
    two_machines,
)

pytestmark = [pytest.mark.release, pytest.mark.needs("network namespaces", "firewall")]

PORT = 11311
SURVEY = f"{CLIENT} --x-points 5 --y-points 5"
# Nodes of each machine; each of them has a server for calls and one for topics.
NODES = {"server": 4, "robot": 5}


def test_a_survey_runs_on_two_machines_and_a_third_one_reaches_none_of_their_ports(tmp_path):
    with two_machines() as (server, robot), launched(server, robot, tmp_path) as terminals:
        # Without the rules, everybody reaches them.
        assert robot.reached(ROBOT_STRANGER, SERVER, [PORT])
        for machine in (server, robot):
            machine.shut_out_others(firewall_commands())
        assert terminals[1].run(SURVEY) == 0
        # The master, and two servers of every node.
        least = 1 + 2 * NODES["server"]
        assert PORT in closed_to_strangers(server, SERVER, robot, ROBOT, ROBOT_STRANGER, least)
        least = 2 * NODES["robot"]
        closed_to_strangers(robot, ROBOT, server, SERVER, SERVER_STRANGER, least)
    assert outcome(tmp_path) == "finished"
    assert stored_traces(tmp_path) == Counter(range(5 * 5 * 2))


def closed_to_strangers(machine, address, other, friend, stranger, at_least):
    """Return the ports of a machine; of the addresses of the other one only a friend's reaches."""
    ports = {port for local, port in machine.listening() if not local.startswith("127.")}
    assert len(ports) >= at_least
    assert other.reached(friend, address, ports) == ports
    assert other.reached(stranger, address, ports) == set()
    return ports

"""Two machines behind the firewall of docs/install.md: a survey runs, nobody else gets in."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

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
    remote_shell_rule,
    stored_traces,
    two_machines,
)
from wait_kit import wait_until

pytestmark = [pytest.mark.release, pytest.mark.needs("network namespaces", "firewall")]

PORT = 11311
SURVEY = f"{CLIENT} --x-points 5 --y-points 5"
# Nodes of each machine; each of them has a server for calls and one for topics.
NODES = {"server": 4, "robot": 5}


@contextlib.contextmanager
def listening(machine, address):
    """Let a program listen on every address of a machine."""
    listener = subprocess.Popen(
        [*machine.prefix, sys.executable, "-m", "http.server", str(PORT)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        wait_until(lambda: machine.reached(address, address, [PORT]), listener, limit_s=20.0)
        yield
    finally:
        listener.kill()
        listener.wait()


def what_works(server, robot):
    """Return what the server's firewall lets through, with a program listening on both."""
    attempts = {
        "from the robot": (robot, ROBOT, SERVER),
        "from itself": (server, "127.0.0.1", "127.0.0.1"),
        "answers of the VNA": (server, SERVER, ROBOT_STRANGER),
        "from a third machine": (robot, ROBOT_STRANGER, SERVER),
    }
    with ThreadPoolExecutor() as pool:
        reached = pool.map(lambda one: one[0].reached(one[1], one[2], [PORT]), attempts.values())
        return dict(zip(attempts, map(bool, reached)))


WANTED = {
    "from the robot": True,
    "from itself": True,
    "answers of the VNA": True,
    "from a third machine": False,
}


def test_the_commands_of_the_page_shut_out_everybody_but_the_other_machine(tmp_path):
    with two_machines() as (server, robot), listening(server, SERVER), listening(robot, ROBOT):
        assert what_works(server, robot)["from a third machine"]
        server.shut_out_others(firewall_commands())
        assert what_works(server, robot) == WANTED
        # The line for a remote shell admits that alone.
        rule = remote_shell_rule(ROBOT_STRANGER)
        server.shut_out_others([rule])
        assert what_works(server, robot) == WANTED
        server.shut_out_others([rule.replace("dport 22", f"dport {PORT}")])
        assert robot.reached(ROBOT_STRANGER, SERVER, [PORT])
        # They work as the lines of a file, as the page says.
        rules = [line.replace("nft ", "", 1).replace("'", "") for line in firewall_commands()]
        (tmp_path / "nftables.conf").write_text("\n".join(["flush ruleset", *rules]) + "\n")
        server.shut_out_others([f"nft -f {tmp_path}/nftables.conf"])
        assert what_works(server, robot) == WANTED


def test_a_survey_runs_on_two_machines_and_a_third_one_reaches_none_of_their_ports(tmp_path):
    with two_machines() as (server, robot):
        for machine in (server, robot):
            machine.shut_out_others(firewall_commands())
        with launched(server, robot, tmp_path) as (_on_server, on_robot):
            assert on_robot.run(SURVEY) == 0
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

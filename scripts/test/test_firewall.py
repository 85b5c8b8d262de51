"""Two machines behind the firewall of docs/install.md: a survey runs, nobody else gets in."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import install_page
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
    pytest.mark.release,
    pytest.mark.needs("network namespaces", "firewall"),
]

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


@contextlib.contextmanager
def two_listening_machines():
    """Yield two machines without a firewall; a program listens on both."""
    with two_machines() as (server, robot), listening(server, SERVER), listening(robot, ROBOT):
        yield server, robot


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


def test_the_commands_of_the_page_shut_out_everybody_but_the_other_machine():
    with two_listening_machines() as (server, robot):
        assert what_works(server, robot)["from a third machine"]
        server.shut_out_others(install_page.firewall())
        assert what_works(server, robot) == WANTED


@pytest.mark.parametrize("line", range(len(install_page.firewall())))
def test_every_command_of_the_page_is_needed(line):
    commands = install_page.firewall()
    del commands[line]
    with two_listening_machines() as (server, robot):
        try:
            server.shut_out_others(commands)
        except subprocess.CalledProcessError:
            return
        assert what_works(server, robot) != WANTED


def test_the_line_for_a_remote_shell_admits_that_alone():
    with two_listening_machines() as (server, robot):
        rule = install_page.remote_shell_rule(ROBOT_STRANGER)
        server.shut_out_others([*install_page.firewall(), rule])
        assert what_works(server, robot) == WANTED
        server.shut_out_others([rule.replace("dport 22", f"dport {PORT}")])
        assert robot.reached(ROBOT_STRANGER, SERVER, [PORT])


def test_the_commands_work_as_the_lines_of_a_file_as_the_page_says(tmp_path):
    rules = [line.replace("nft ", "", 1).replace("'", "") for line in install_page.firewall()]
    (tmp_path / "nftables.conf").write_text("\n".join(rules) + "\n")
    with two_listening_machines() as (server, robot):
        server.load_rules(tmp_path / "nftables.conf")
        assert what_works(server, robot) == WANTED


def open_ports(machine):
    return {port for address, port in machine.listening() if not is_loopback(address)}


def test_a_survey_runs_on_two_machines_and_a_third_one_reaches_none_of_their_ports(tmp_path):
    with two_machines() as (server, robot):
        for machine in (server, robot):
            machine.shut_out_others(install_page.firewall())
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

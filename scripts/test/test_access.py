"""Who can reach a running system: nobody by default; of two machines see test_firewall.py."""

from __future__ import annotations

import contextlib
import ipaddress

import psutil
from robot_kit import free_port
from user_shell import Terminal, is_ready, user_environment
from wait_kit import wait_until

# A word of the command line of each process of the system.
NODES = ["x_axis-axis_driver", "y_axis-axis_driver", "z_axis-axis_driver", "name:=height_sensor"]
NODES += ["name:=simulator", "name:=vna_acquisition", "name:=vna_processing", "name:=imaging"]
NODES += ["name:=main_control", "rosmaster", "name:=rosout", "name:=user_interface", "run_survey"]
SURVEY = "rosrun gpr20_user_interface run_survey --wait 60 --x-stop 200"


def processes_below(*parents):
    """Return the command lines of these processes and of all that came from them, by process."""
    found = {}
    for parent in parents:
        root = psutil.Process(parent.pid)
        for process in [root, *root.children(recursive=True)]:
            try:
                found[process] = " ".join(process.cmdline())
            except (psutil.NoSuchProcess, psutil.ZombieProcess):
                continue
    return found


def reachable_at(processes):
    """Yield (command line, address) of everything that listens by TCP or receives by UDP."""
    for process, command_line in processes.items():
        try:
            connections = process.net_connections(kind="inet")
        except (psutil.NoSuchProcess, psutil.ZombieProcess):
            continue
        for one in connections:
            if one.status in (psutil.CONN_LISTEN, psutil.CONN_NONE) and one.laddr:
                yield command_line, one.laddr.ip


def test_a_running_survey_can_be_reached_from_this_machine_alone(tmp_path):
    port = free_port()
    environment = user_environment(
        tmp_path / "surveys",
        QT_QPA_PLATFORM="offscreen",
        ROS_MASTER_URI=f"http://127.0.0.1:{port}",
    )
    with (tmp_path / "printed.log").open("wb") as log, contextlib.ExitStack() as stack:
        terminal = Terminal(log, environment)
        stack.callback(terminal.close)
        system = terminal.start(f"roslaunch -p {port} gpr20 survey.launch time_scale:=20")
        wait_until(lambda: is_ready(tmp_path / "printed.log"), alive=[system])
        client = terminal.start(SURVEY)
        stored = (tmp_path / "surveys").glob
        wait_until(lambda: len(list(stored("*/traces/*.json"))) >= 2, alive=[system, client])
        processes = processes_below(system, client)
        found = list(reachable_at(processes))
    for word in NODES:
        assert any(word in line for line in processes.values()), word
    others = [one for one in found if not ipaddress.ip_address(one[1]).is_loopback]
    assert others == []
    # A node of ROS has two servers, one for calls and one for topics.
    assert len(found) >= 2 * len(NODES)

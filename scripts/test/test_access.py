"""Who can reach a running system: nobody by default, two machines where they are configured."""

from __future__ import annotations

import ipaddress
import json

import psutil
import pytest
from robot_kit import free_port
from user_shell import Terminal, is_ready, user_environment, wait_until

# A word of the command line of each process of the system.
ROBOT = ["x_axis-axis_driver", "y_axis-axis_driver", "z_axis-axis_driver", "name:=height_sensor"]
ROBOT += ["name:=simulator"]
SERVER = ["name:=vna_acquisition", "name:=vna_processing", "name:=imaging"]
SERVER += ["name:=main_control"]
MASTER = ["rosmaster", "name:=rosout"]
# The simulated robot cannot be on another machine, but it can be at another address of this one.
ROBOT_ADDRESS = "127.0.0.3"
SERVER_ADDRESS = "127.0.0.2"
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


@pytest.fixture
def terminal_of(tmp_path):
    """Make terminals of a user whose surveys go to `tmp_path`; all are closed in the end."""
    opened = []
    with (tmp_path / "printed.log").open("wb") as log:

        def make(**exported):
            environment = user_environment(
                tmp_path / "surveys", QT_QPA_PLATFORM="offscreen", **exported
            )
            opened.append(Terminal(log, environment))
            return opened[-1]

        yield make
        for terminal in reversed(opened):
            terminal.close()
    # Shown if the test has failed.
    print((tmp_path / "printed.log").read_text(errors="replace"))


def stored_traces(tmp_path):
    return list(tmp_path.glob("surveys/*/traces/*.json"))


def assert_all_there(processes, words):
    for word in words:
        assert any(word in line for line in processes.values()), word


def launched(terminal, port):
    """Start all at once, in the way of the README."""
    return [terminal.start(f"roslaunch -p {port} gpr20 survey.launch time_scale:=20")]


def launched_beside_a_master(terminal, port):
    """Start a master by hand, and the robot in a namespace."""
    master = terminal.start(f"roscore -p {port}")
    robot = terminal.start("roslaunch --wait gpr20 survey.launch time_scale:=20 ns:=robot1")
    return [master, robot]


@pytest.mark.parametrize(
    ("launch", "survey"),
    [
        (launched, SURVEY),
        pytest.param(launched_beside_a_master, f"{SURVEY} __ns:=robot1", marks=pytest.mark.release),
    ],
)
def test_a_running_survey_can_be_reached_from_this_machine_alone(
    tmp_path, terminal_of, launch, survey
):
    port = free_port()
    terminal = terminal_of(ROS_MASTER_URI=f"http://127.0.0.1:{port}")
    system = launch(terminal, port)
    wait_until(lambda: is_ready(tmp_path / "printed.log"), *system)
    client = terminal.start(survey)
    wait_until(lambda: len(stored_traces(tmp_path)) >= 2, *system, client)

    processes = processes_below(*system, client)
    assert_all_there(processes, MASTER + ROBOT + SERVER + ["name:=user_interface", "run_survey"])
    found = list(reachable_at(processes))
    others = [one for one in found if not ipaddress.ip_address(one[1]).is_loopback]
    assert others == []
    # A node of ROS has two servers, one for calls and one for topics.
    assert len(found) >= 2 * len(ROBOT + SERVER)


@pytest.mark.release
def test_a_survey_runs_on_two_machines_each_bound_to_its_own_address(tmp_path, terminal_of):
    port = free_port()
    exported = {
        "GPR20_ROBOT": ROBOT_ADDRESS,
        "GPR20_SERVER": SERVER_ADDRESS,
        "ROS_MASTER_URI": f"http://{SERVER_ADDRESS}:{port}",
    }
    on_server = terminal_of(**exported, ROS_IP=SERVER_ADDRESS)
    on_robot = terminal_of(**exported, ROS_IP=ROBOT_ADDRESS)
    server = on_server.start(f"roslaunch -p {port} gpr20 server.launch time_scale:=50")
    robot = on_robot.start("roslaunch --wait gpr20 robot.launch time_scale:=50")
    wait_until(lambda: is_ready(tmp_path / "printed.log"), server, robot)
    client = on_robot.start(SURVEY.replace("--x-stop 200", "--x-points 5 --y-points 5"))
    wait_until(lambda: stored_traces(tmp_path), server, robot, client)

    for system, address, words in (
        (server, SERVER_ADDRESS, MASTER + SERVER),
        (robot, ROBOT_ADDRESS, [*ROBOT, "name:=user_interface"]),
    ):
        processes = processes_below(system)
        assert_all_there(processes, words)
        ros = {ip for line, ip in reachable_at(processes) if "name:=simulator" not in line}
        assert ros == {address}

    assert client.wait(60) == 0
    (survey,) = tmp_path.glob("surveys/*/survey.json")
    assert json.loads(survey.read_text())["outcome"] == "finished"
    assert len(stored_traces(tmp_path)) == 5 * 5 * 2

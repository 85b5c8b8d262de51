"""The simulated robot on two machines: launch it, survey with it, and read what was recorded."""

from __future__ import annotations

import contextlib
import json
import re
from collections import Counter

import install_page
from network_namespaces import ROBOT, SERVER, relayed
from user_shell import Terminal, is_ready, user_environment
from wait_kit import wait_until

TIME_SCALE = 50
CLIENT = "rosrun gpr20_user_interface run_survey --wait 60"


@contextlib.contextmanager
def launched(server, robot, folder):
    """Yield a terminal on each machine, with both launch files running.

    Args:
        server: The machine of the master, the VNA, the storage and the survey.
        robot: The machine of the axes and the height sensor.
        folder: For surveys and everything that is printed.
    """
    environment = user_environment(
        folder / "surveys", GPR20_ROBOT=ROBOT, GPR20_SERVER=SERVER, ROS_HOME=str(folder / "ros")
    )
    _both, launch_server, launch_robot = install_page.two_machine_commands()
    with (folder / "printed.log").open("wb") as log:
        on_server = Terminal(log, environment, server.prefix)
        on_robot = Terminal(log, environment, robot.prefix)
        try:
            control = on_server.start(simulated(launch_server))
            axes = on_robot.start(f"{simulated(launch_robot)} ui:=false")
            wait_until(lambda: is_ready(folder / "printed.log"), alive=[control, axes])
            # The simulated VNA is behind the loopback of the robot, which a real one is not.
            wait_until(lambda: simulated_vna(robot), alive=[control, axes])
            with relayed(simulated_vna(robot), server, robot):
                yield on_server, on_robot
        finally:
            on_robot.close()
            on_server.close()


def simulated(command):
    """Return the page's command for the real robot as one for the simulated robot."""
    assert "robot:=gpr20" in command
    return command.replace("robot:=gpr20", f"time_scale:={TIME_SCALE}")


def simulated_vna(robot):
    """Return the ports of the simulated VNA, as soon as it listens: core and abort channel."""
    ports = [port for address, port in robot.listening() if address.startswith("127.")]
    return ports if len(ports) == 2 else []


def survey_folder(folder):
    """Return the folder of the one survey; None before there is one."""
    found = [one.parent for one in folder.glob("surveys/*/survey.json")]
    assert len(found) <= 1
    return found[0] if found else None


def stored_traces(folder):
    """Return the indices of the stored traces of the one survey, each as often as it is stored."""
    survey = survey_folder(folder)
    names = [] if survey is None else [one.name for one in survey.glob("traces/*.json")]
    return Counter(int(name.split("_")[0]) for name in names)


def statuses(folder):
    """Return (state, message) of each status that the main control has logged."""
    text = (folder / "printed.log").read_text(errors="replace")
    return re.findall(r"\[INFO\] \[[\d.]+\]: ([A-Z]+): (.*)", text)


def outcome(folder):
    return json.loads((survey_folder(folder) / "survey.json").read_text())["outcome"]

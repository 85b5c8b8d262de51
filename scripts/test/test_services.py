"""The command lines of the units: a survey runs under them, and ends as `systemctl stop` ends it.

systemd itself is not needed: the test reads the unit, and does what systemd does with it.
"""

from __future__ import annotations

import json
import signal
import subprocess

import machine_tree
import psutil
import pytest
from robot_kit import free_port
from user_shell import Terminal, is_ready, user_environment, wait_until

pytestmark = [pytest.mark.real_time, pytest.mark.takes(60)]

CLIENT = "rosrun gpr20_user_interface run_survey --wait 60"
UNIT = "gpr20-robot"


def test_stopping_the_service_stores_the_survey_that_runs_as_interrupted(tmp_path):
    machine = machine_tree.one_machine(tmp_path / "machine")
    machine.install("--data", str(tmp_path / "surveys"))
    environment = service_environment(machine, tmp_path)
    limit_s = float(*machine.unit_values(UNIT, "TimeoutStopSec"))
    with (tmp_path / "printed.log").open("wb") as log:
        service = start(machine, environment, log)
        client = Terminal(log, environment)
        try:
            wait_until(lambda: is_ready(tmp_path / "printed.log"), service)
            survey = client.start(f"{CLIENT} --x-points 40 --y-points 40")
            wait_until(lambda: len(traces(tmp_path)) >= 5, service, survey)
            below = psutil.Process(service.pid).children(recursive=True)
            # KillMode=mixed: the signal goes to the main process alone.
            service.send_signal(getattr(signal, *machine.unit_values(UNIT, "KillSignal")))
            assert service.wait(limit_s) == 0
            assert psutil.wait_procs(below, timeout=0)[1] == []
            survey.wait(limit_s)
        finally:
            client.close()
            service.kill()
            service.wait()
    (folder,) = (tmp_path / "surveys").iterdir()
    description = json.loads((folder / "survey.json").read_text("utf-8"))
    assert description["outcome"] == "interrupted"
    for trace in traces(tmp_path):
        json.loads(trace.read_text("utf-8"))


def service_environment(machine, folder):
    """Return the variables of the unit, and those that make it the simulated robot's."""
    settings = {**machine.settings(), "GPR20_LAUNCH_ARGUMENTS": "robot:=simulated time_scale:=50"}
    settings.update(ROS_LOG_DIR=str(folder / "log"), HOME=str(folder / "home"))
    settings.update(GPR20_CONFIG="", ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}")
    (folder / "home").mkdir()
    return user_environment(folder / "surveys", **settings)


def start(machine, environment, log):
    """Start the unit as systemd does."""
    return subprocess.Popen(
        machine.unit_command(UNIT),
        env=environment,
        cwd=environment["HOME"],
        stdout=log,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )


def traces(folder):
    return list(folder.glob("surveys/*/traces/*.json"))

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

pytestmark = pytest.mark.real_time

CLIENT = "rosrun gpr20_user_interface run_survey --wait 60"
UNIT = "gpr20-robot"
SIDE = 8
TRACES = 2 * SIDE * SIDE
LIMIT_S = 60.0


def test_a_survey_whose_service_is_stopped_is_resumed_under_the_next_one(tmp_path):
    machine = machine_tree.one_machine(tmp_path / "machine")
    machine.install("--data", str(tmp_path / "surveys"))
    environment = service_environment(machine, tmp_path)
    with (tmp_path / "printed.log").open("wb") as log:
        service = start(machine, environment, log)
        client = Terminal(log, environment)
        try:
            wait_until(lambda: is_ready(tmp_path / "printed.log"), service)
            survey = client.start(f"{CLIENT} --x-points {SIDE} --y-points {SIDE}")
            wait_until(lambda: len(traces(tmp_path)) >= 5, service, survey)
            stop(machine, service)
            survey.wait(LIMIT_S)
            (folder,) = (tmp_path / "surveys").glob("[!.]*")
            assert outcome(folder) == "interrupted"
            before = {path: path.read_bytes() for path in traces(tmp_path)}
            assert 5 <= len(before) < TRACES
            service = start(machine, environment, log)
            assert client.run(f"{CLIENT} --resume {folder.name}") == 0
            stop(machine, service)
        finally:
            client.close()
            service.kill()
            service.wait()
    assert outcome(folder) == "finished"
    stored = [json.loads(path.read_text("utf-8")) for path in traces(tmp_path)]
    assert len(stored) == TRACES
    assert before == {path: path.read_bytes() for path in before}


def stop(machine, service):
    """Stop the unit as systemd does; it ends in time, and nothing of it is left."""
    below = psutil.Process(service.pid).children(recursive=True)
    # KillMode=mixed: the signal goes to the main process alone.
    service.send_signal(getattr(signal, *machine.unit_values(UNIT, "KillSignal")))
    assert service.wait(float(*machine.unit_values(UNIT, "TimeoutStopSec"))) == 0
    assert psutil.wait_procs(below, timeout=0)[1] == []


def outcome(folder):
    return json.loads((folder / "survey.json").read_text("utf-8"))["outcome"]


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

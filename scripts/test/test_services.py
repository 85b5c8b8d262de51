"""The command lines of the units: a survey runs under them, and ends as `systemctl stop` ends it.

systemd itself is not needed: the test reads the unit, and does what systemd does with it.
"""

from __future__ import annotations

import signal
import subprocess
from collections import Counter

import psutil
import pytest
from network_namespaces import CLIENT, outcome, stored_traces, survey_folder
from robot_kit import free_port
from user_shell import ROOT, Terminal, is_ready, unit_values, user_environment
from wait_kit import wait_until

pytestmark = pytest.mark.release
UNIT = "gpr20"
SIDE = 8
TRACES = 2 * SIDE * SIDE
LIMIT_S = 60.0


def test_a_survey_whose_service_is_stopped_is_resumed_under_the_next_one(tmp_path):
    environment = service_environment(tmp_path)
    with (tmp_path / "printed.log").open("wb") as log:
        service = start(environment, log)
        client = Terminal(log, environment)
        try:
            wait_until(lambda: is_ready(tmp_path / "printed.log"), alive=[service])
            survey = client.start(f"{CLIENT} --x-points {SIDE} --y-points {SIDE}")
            wait_until(lambda: sum(stored_traces(tmp_path).values()) >= 5, alive=[service, survey])
            stop(service)
            survey.wait(LIMIT_S)
            folder = survey_folder(tmp_path)
            assert outcome(tmp_path) == "interrupted"
            before = {path: path.read_bytes() for path in folder.glob("traces/*.json")}
            assert 5 <= len(before) < TRACES
            service = start(environment, log)
            assert client.run(f"{CLIENT} --resume {folder.name}") == 0
            stop(service)
        finally:
            client.close()
            service.kill()
            service.wait()
    assert outcome(tmp_path) == "finished"
    assert stored_traces(tmp_path) == Counter(range(TRACES))
    assert before == {path: path.read_bytes() for path in before}


def stop(service):
    """Stop the unit as systemd does; it ends in time, and nothing of it is left."""
    below = psutil.Process(service.pid).children(recursive=True)
    # KillMode=mixed: the signal goes to the main process alone.
    service.send_signal(getattr(signal, *unit_values(UNIT, "KillSignal")))
    assert service.wait(float(*unit_values(UNIT, "TimeoutStopSec"))) == 0
    assert psutil.wait_procs(below, timeout=0)[1] == []


def service_environment(folder):
    """Return the variables of the unit; its settings are those of one simulated machine."""
    (folder / "robot.conf").write_text(
        f"GPR20_ROLE=both\nGPR20_DATA={folder}/surveys\n"
        "GPR20_LAUNCH_ARGUMENTS=robot:=simulated time_scale:=50\n"
    )
    settings = dict(ROS_LOG_DIR=str(folder / "log"), HOME=str(folder / "home"), GPR20_CONFIG="")
    settings.update(ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}")
    settings.update(
        GPR20_ENVIRONMENT=str(folder / "robot.conf"), GPR20_PREFIX=str(ROOT / "catkin_ws/devel")
    )
    (folder / "home").mkdir()
    return user_environment(folder / "surveys", **settings)


def start(environment, log):
    """Start the unit as systemd does, with the program of this checkout."""
    (command,) = unit_values(UNIT, "ExecStart")
    installed, *arguments = command.split()
    return subprocess.Popen(
        [str(ROOT / installed.replace("/opt/gpr20/current/", "")), *arguments],
        env=environment,
        cwd=environment["HOME"],
        stdout=log,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )

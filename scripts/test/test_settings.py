"""What an installed robot runs follows its file of settings, or says which line is wrong."""

from __future__ import annotations

import os
import subprocess

import pytest
from case_kit import each_case
from user_shell import ROOT

SHIPPED = (ROOT / "deploy/common/etc/gpr20/environment").read_text("utf-8")
SIMULATED = "GPR20_LAUNCH_ARGUMENTS=robot:=simulated"
FAKE = '#!/bin/sh\nprintf "<%s>" "$@"\n'


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    """A function that runs gpr20-run with settings and a roslaunch that prints its arguments."""
    folder = tmp_path_factory.mktemp("machine")
    program = folder / "roslaunch"
    program.write_text(FAKE)
    program.chmod(0o755)
    prefix = folder / "setup.bash"
    prefix.write_text(f"export PATH={folder}:$PATH\n")

    def run(text, *arguments, **variables):
        file = folder / "environment"
        file.write_bytes(text.encode())
        own = {name: one for name, one in os.environ.items() if not name.startswith("GPR20_")}
        own.update({"GPR20_ENVIRONMENT": str(file), "GPR20_PREFIX": str(folder), **variables})
        command = [str(ROOT / "deploy/gpr20-run"), *(arguments or ["robot"])]
        return subprocess.run(command, env=own, capture_output=True, text=True, check=False)

    return run


def test_what_is_shipped_runs_the_simulated_robot_and_the_real_one_must_be_named(machine):
    done = machine(SHIPPED)
    assert done.stdout == "<gpr20><survey.launch><robot:=simulated><ui:=false>", done.stderr
    assert "<robot:=gpr20>" in machine(SHIPPED.replace("=robot:=simulated", "=robot:=gpr20")).stdout
    done = machine(SHIPPED.replace("=robot:=simulated", "="))
    assert done.returncode == 2 and done.stdout == ""
    assert "must name the robot" in done.stderr


WEB = SHIPPED.replace("GPR20_WEB=", "GPR20_WEB=192.168.1.0/24")
TWO = {"GPR20_ROBOT": "10.20.0.1", "GPR20_SERVER": "10.20.0.2", "ROS_IP": "127.0.0.1"}


def test_the_web_page_runs_beside_the_surveys_if_a_network_may_reach_it(machine):
    assert "<web:=true>" in machine(WEB).stdout
    assert "<web:=true>" in machine(WEB, "server", **TWO).stdout
    # The robot of a PC waits for its master.
    assert machine(SHIPPED, **TWO).stdout.startswith("<--wait><gpr20><robot.launch>")
    for done in (machine(SHIPPED), machine(SHIPPED, "server", **TWO)):
        assert done.returncode == 0 and "web" not in done.stdout, done.stderr


WRONG = [
    (f" {SIMULATED}", "is not NAME=value"),
    (f"export {SIMULATED}", "is not NAME=value"),
    (f"{SIMULATED} # real later", "has a comment behind it"),
    ('GPR20_LAUNCH_ARGUMENTS="robot:=simulated" # x', "has a quote"),
    (f"{SIMULATED} ", "begins or ends with a space"),
    (f"{SIMULATED}\r", "carriage return"),
    (f"{SIMULATED}\n{SIMULATED}", "is set in line"),
    (SIMULATED.replace("ARGUMENTS", "ARGUMENT"), "is unknown"),
    (SIMULATED.replace("robot", "Robot"), "'Robot:=simulated'"),
    (SIMULATED.replace("simulated", "simulation"), "must name the robot"),
    (f"{SIMULATED} robot:=gpr20", "has robot more than once"),
    (f"{SIMULATED} fast", "'fast'"),
]


@each_case("line, reason", WRONG)
def test_a_line_that_is_not_understood_starts_nothing(machine, line, reason):
    done = machine(SHIPPED.replace(SIMULATED, line))
    assert done.returncode == 2 and done.stdout == "", done.stdout
    assert reason in done.stderr


def test_what_is_no_file_starts_nothing_and_is_not_waited_for(machine, tmp_path):
    os.mkfifo(str(tmp_path / "pipe"))
    for name, reason in (
        ("none", "none cannot be read"),
        ("", "it must be a file"),
        ("pipe", "it must be a file"),
    ):
        done = machine(SHIPPED, GPR20_ENVIRONMENT=str(tmp_path / name))
        assert done.returncode == 2 and done.stdout == ""
        assert reason in done.stderr

"""What an installed robot runs follows its file of settings, or says which line is wrong."""

from __future__ import annotations

import os
import re
import shlex
import subprocess

import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from user_shell import ROOT, unit_values

SHIPPED = (ROOT / "deploy/root/etc/gpr20/robot.conf").read_text("utf-8")
BOTH = SHIPPED.replace("GPR20_ROLE=", "GPR20_ROLE=both")
SIMULATED = "GPR20_LAUNCH_ARGUMENTS=robot:=simulated"
# It takes the place of gpr20-run, itself or beside a master: systemd signals that process alone.
FAKE = """#!/bin/sh
grep -q 'PPid:.%d$' /proc/$$/status /proc/$PPID/status && printf "<%%s>" "$@"
"""


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    """A function that runs gpr20-run with settings and a roslaunch that prints its arguments."""
    folder = tmp_path_factory.mktemp("machine")
    program = folder / "roslaunch"
    program.write_text(FAKE % os.getpid())
    program.chmod(0o755)
    prefix = folder / "setup.bash"
    prefix.write_text(f"export PATH={folder}:$PATH\n")

    def run(text, *arguments, **variables):
        file = folder / "robot.conf"
        file.write_bytes(text.encode())
        own = {name: one for name, one in os.environ.items() if not name.startswith("GPR20_")}
        own.update({"GPR20_ENVIRONMENT": str(file), "GPR20_PREFIX": str(folder), **variables})
        command = [str(ROOT / "deploy/gpr20-run"), *(arguments or ["start"])]
        return subprocess.run(command, env=own, capture_output=True, text=True, check=False)

    return run


def test_one_machine_runs_the_simulated_robot_and_the_real_one_must_be_named(machine):
    done = machine(BOTH)
    assert done.stdout == "<gpr20><survey.launch><robot:=simulated><ui:=false>", done.stderr
    assert "<robot:=gpr20>" in machine(BOTH.replace("=robot:=simulated", "=robot:=gpr20")).stdout
    done = machine(BOTH.replace("=robot:=simulated", "="))
    assert done.returncode == 2 and done.stdout == ""
    assert "must name the robot" in done.stderr


TWO = {"GPR20_ROBOT": "10.20.0.1", "GPR20_SERVER": "10.20.0.2", "ROS_IP": "127.0.0.1"}
# What is started; or why nothing is.
ROLES = [
    ("both", {}, "<gpr20><survey.launch>"),
    ("robot", TWO, "<--wait><gpr20><robot.launch>"),
    ("server", TWO, "<gpr20><server.launch>"),
    ("", {}, "GPR20_ROLE is ''"),
    ("analysis", {}, "GPR20_ROLE is 'analysis'"),
    ("Robot", TWO, "GPR20_ROLE is 'Robot'"),
    ("both", TWO, "GPR20_ROLE is 'both'"),
    ("robot", {}, "both addresses"),
    ("server", {"GPR20_SERVER": "10.20.0.2"}, "both addresses"),
]


@each_case("role, addresses, wanted", ROLES)
def test_a_computer_starts_what_its_role_is_and_nothing_without_one(
    machine, role, addresses, wanted
):
    done = machine(SHIPPED, GPR20_ROLE=role, **addresses)
    assert done.stdout.startswith(wanted) if wanted.startswith("<") else wanted in done.stderr
    assert (done.returncode == 0) == (done.stdout != "") == wanted.startswith("<")


CONDITIONS = [
    ("GPR20_ROLE=both", "gpr20 gpr20-window"),
    ('GPR20_ROLE="robot"', "gpr20 gpr20-window"),
    ("GPR20_ROLE=server", "gpr20"),
    ("GPR20_ROLE=analysis", ""),
    ("GPR20_ROLE=", ""),
    ("#GPR20_ROLE=both", ""),
]


@each_case("line, units", CONDITIONS)
def test_systemd_starts_the_units_of_the_role(tmp_path, line, units):
    settings = tmp_path / "robot.conf"
    settings.write_text(SHIPPED.replace("GPR20_ROLE=", line))
    started = []
    for unit in ("gpr20", "gpr20-window"):
        (condition,) = unit_values(unit, "ExecCondition")
        command = condition.replace("/etc/gpr20/robot.conf", str(settings))
        if subprocess.run(shlex.split(command), check=False).returncode == 0:
            started.append(unit)
    assert started == units.split()


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
    done = machine(BOTH.replace(SIMULATED, line))
    assert done.returncode == 2 and done.stdout == "", done.stdout
    assert reason in done.stderr


LINES = st.sampled_from(
    [SIMULATED, *(line for line, _reason in WRONG), "", "# robot:=gpr20", "GPR20_ROBOT="]
)


@settings(max_examples=draws(6))
@given(st.lists(LINES, max_size=4))
def test_no_lines_that_never_name_the_real_robot_start_it(machine, lines):
    done = machine("\n".join(["GPR20_ROLE=both", *lines]))
    assert "robot:=gpr20" not in done.stdout
    started = done.stdout != ""
    assert started == (done.returncode == 0)
    if started:
        assert re.findall("<robot:=(.*?)>", done.stdout) == ["simulated"]

"""The files that the install scripts write: the programs that read them accept them."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
from pathlib import Path

import install_page
import machine_tree
import pytest
from machine_tree import ADMIN
from network_namespaces import two_machines
from user_shell import ROOT, wait_until

from gpr20_survey.axes.realtime_priority import PULSE_PRIORITY

UNITS = {
    machine_tree.robot: ["gpr20-firewall", "gpr20-robot", "gpr20-window"],
    machine_tree.one_machine: ["gpr20-robot", "gpr20-window"],
    machine_tree.server: ["gpr20-firewall", "gpr20-server"],
}
needs_network = pytest.mark.needs("network namespaces", "firewall")


@pytest.fixture(scope="module", params=UNITS, ids=lambda make: make.__name__)
def installed(request, tmp_path_factory):
    made = request.param(tmp_path_factory.mktemp("machine"))
    made.install()
    return request.param, made


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    made = machine_tree.robot(tmp_path_factory.mktemp("robot"))
    made.install()
    return made


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    made = machine_tree.server(tmp_path_factory.mktemp("server"))
    made.install()
    return made


def program(name):
    """Return the path of a program; skip the test without it."""
    found = shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def printed_by(*command):
    """Return what a command printed; it must succeed."""
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_every_unit_starts_at_boot(installed):
    make, machine = installed
    wanted = machine.folder / "etc/systemd/system/multi-user.target.wants"
    assert sorted(one.stem for one in wanted.iterdir()) == UNITS[make]
    for link in wanted.iterdir():
        assert link.resolve().is_file()


def test_systemd_accepts_every_unit(installed, tmp_path):
    analyze = program("systemd-analyze")
    make, machine = installed
    for name in UNITS[make]:
        text = (machine.folder / f"etc/systemd/system/{name}.service").read_text("utf-8")
        # Not every computer has a screen's programs.
        for path in ("/usr/bin/xinit", "/usr/sbin/nft"):
            text = text if Path(path).exists() else text.replace(path, shutil.which("true"))
        (tmp_path / f"{name}.service").write_text(text)
    units = [str(tmp_path / f"{name}.service") for name in UNITS[make]]
    printed = printed_by(analyze, "verify", "--man=no", *units)
    assert "gpr20" not in printed, printed


def test_systemd_would_refuse_a_misspelled_key(tmp_path):
    text = (ROOT / "deploy/systemd/gpr20-firewall.service").read_text("utf-8")
    unit = tmp_path / "gpr20-wrong.service"
    unit.write_text(text.replace("RemainAfterExit", "RemainAfter"))
    command = [program("systemd-analyze"), "verify", "--man=no", str(unit)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "RemainAfter" in done.stdout + done.stderr


def test_no_placeholder_is_left(installed):
    _make, machine = installed
    for path in machine.folder.rglob("*"):
        if path.is_file() and not path.is_symlink():
            assert re.findall(r"@[A-Z_]+@", path.read_text("utf-8")) == [], path


def test_the_programs_of_the_units_exist_in_the_checkout(installed):
    make, machine = installed
    for name in UNITS[make]:
        for word in machine.unit_command(name):
            if word.startswith(str(ROOT)):
                assert os.access(word, os.X_OK), word


def test_the_axes_get_the_real_time_priority_that_they_ask_for(robot):
    assert robot.unit_values("gpr20-robot", "LimitRTPRIO") == [str(PULSE_PRIORITY)]
    assert robot.unit_values("gpr20-robot", "LimitMEMLOCK") == ["infinity"]
    limits = (robot.folder / "etc/security/limits.d/gpr20.conf").read_text("utf-8")
    assert f"@gpr20 - rtprio {PULSE_PRIORITY}\n@gpr20 - memlock unlimited\n" in limits


@pytest.mark.parametrize("name", ["robot", "server"])
def test_services_run_without_root_and_end_as_by_ctrl_c(request, name):
    machine, unit = request.getfixturevalue(name), f"gpr20-{name}"
    assert machine.unit_values(unit, "User") == ["gpr20"]
    assert machine.unit_values(unit, "CapabilityBoundingSet") == [""]
    assert machine.unit_values(unit, "NoNewPrivileges") == ["yes"]
    assert machine.unit_values(unit, "Restart") == ["always"]
    assert machine.unit_values(unit, "KillMode") == ["mixed"]
    assert machine.unit_values(unit, "KillSignal") == ["SIGINT"]
    # roslaunch kills a node after 17 s.
    assert int(*machine.unit_values(unit, "TimeoutStopSec")) > 60


def rules_after(commands):
    """Return the ruleset of a new network namespace after commands of a shell."""
    script = "\n".join([*commands, "nft list ruleset"])
    return printed_by("unshare", "--net", "bash", "-ec", script)


@needs_network
def test_the_firewall_has_the_rules_of_the_page(robot):
    program("nft")
    file = robot.folder / "etc/gpr20/firewall.nft"
    own = rules_after([*install_page.firewall(), install_page.remote_shell_rule(ADMIN[1])])
    assert rules_after([f"nft -c -f {file}", f"nft -f {file}"]) == own
    # Loaded again, they replace themselves; stopped, nothing is left.
    assert rules_after([f"nft -f {file}", f"nft -f {file}"]) == own
    (stop,) = robot.unit_values("gpr20-firewall", "ExecStop")
    assert rules_after([f"nft -f {file}", stop]) == ""


@needs_network
def test_the_firewall_leaves_the_rules_of_others(robot):
    program("nft")
    load = f"nft -f {robot.folder}/etc/gpr20/firewall.nft"
    others = rules_after(["nft add table inet other"])
    assert others in rules_after(["nft add table inet other", load])


def test_logrotate_accepts_its_file(robot, tmp_path):
    logrotate = program("logrotate")
    text = (robot.folder / "etc/logrotate.d/gpr20").read_text("utf-8")
    logs = tmp_path / "log/run"
    logs.mkdir(parents=True)
    log = logs / "node.log"
    log.write_text("x\n" * 2**21)
    # Of a user that exists, and in a folder of this test.
    text = re.sub(r"^ *su .*\n", "", text, flags=re.M).replace("/var/log/gpr20", f"{tmp_path}/log")
    (tmp_path / "conf").write_text(text)
    (tmp_path / "conf").chmod(0o644)
    state = tmp_path / "state"
    printed = printed_by(
        logrotate, "--verbose", "--force", "--state", str(state), tmp_path / "conf"
    )
    assert "error" not in printed
    assert log.stat().st_size == 0
    assert (logs / "node.log.1.gz").stat().st_size < 2**16


@pytest.mark.parametrize("name", ["robot", "server"])
def test_chrony_accepts_its_file(request, name):
    chronyd = program("chronyd")
    file = request.getfixturevalue(name).folder / "etc/chrony/conf.d/gpr20.conf"
    printed = printed_by(chronyd, "-p", "-f", str(file))
    wanted = {"robot": "server 10.20.0.2", "server": "allow 10.20.0.1"}
    assert wanted[name] in printed


@needs_network
def test_the_robot_follows_the_clock_of_the_pc_behind_the_firewall(robot, server, tmp_path):
    chronyd = program("chronyd")
    rules = robot.folder / "etc/gpr20/firewall.nft"
    with two_machines() as places, contextlib.ExitStack() as started:
        logs = []
        for machine, place in zip((server, robot), places):
            place.load_rules(rules)
            file = tmp_path / f"{machine.script}.conf"
            settings = (machine.folder / "etc/chrony/conf.d/gpr20.conf").read_text("utf-8")
            file.write_text(f"{settings}pidfile {file}.pid\nbindcmdaddress /\ncmdport 0\n")
            log = started.enter_context(file.with_suffix(".log").open("wb"))
            # -x: the clock of this computer is not touched.
            command = [*place.prefix, chronyd, "-x", "-d", "-u", "root", "-f", str(file)]
            process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
            started.callback(process.wait)
            started.callback(process.terminate)
            logs.append((file.with_suffix(".log"), process))
        log, process = logs[1]
        wait_until(lambda: "Selected source 10.20.0.2" in log.read_text(), process, limit_s=60.0)

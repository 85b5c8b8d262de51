"""A robot and its computer are broken in each way of a table; the doctor says it, and what to do.

Files, mounts, processes and sockets are real ones, below a folder that stands for the root of the
file system. The commands of an advice are run as they are written; those that would change this
computer are stand-ins of the same name, first in PATH.
"""

import os
import re
import socket
import subprocess
import tempfile
import threading
import time
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any, Callable, NamedTuple
from unittest import mock

import pytest
from case_kit import each_case
from test_robot_checks import facts, report, stale

from gpr20_common.faults import CONFIGURATION, DISK_FULL
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import own_software
from gpr20_doctor.low import masters, processes
from gpr20_doctor.low.masters import state_of
from gpr20_doctor.low.processes import Processes
from gpr20_doctor.mid import findings as all_findings
from gpr20_doctor.mid.finding import Level
from gpr20_doctor.mid.findings import examine, findings
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.robot_checks import evidence_of
from gpr20_doctor.mid.robot_facts import unheard

pytestmark = pytest.mark.needs("mounts")

MASTER = "http://localhost:11311"
SIZES = {"logs": "230m", "tmp": "230m", "data": "8g"}
COMMAND = re.compile(r"[Rr]un: (.+?)(?:\. [A-Z]|\.?$)")
PROGRAMS = {
    "sudo": 'exec "$@"',
    "vcgencmd": "cat {root}/throttled",
    "rosrun": "cat {root}/problems",
    "nft": 'cat "{root}/tables"',
    "raspi-config": 'touch "{root}/dev/spidev0.0"',
}
FILES = {
    "proc/device-tree/model": "Raspberry Pi 4",
    "proc/meminfo": "MemAvailable: 2000000 kB\n",
    "proc/vmstat": "oom_kill 0\n",
    "proc/stat": f"btime {int(time.time()) + 1_000_000}\n",
    "dev/spidev0.0": "",
    "dev/gpiomem": "",
    "lib/systemd/system/gpr20.service": "",
    "etc/gpr20/robot.conf": "",
    "usr/share/zoneinfo/Europe/Madrid": "",
    "robot/site.yaml": "",
    "throttled": "throttled=0x0",
    "problems": "[]",
    "tables": "table inet gpr20",
}


def tree(folder, **files):
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)


class Computer:
    """A Raspberry Pi with the services of the packages and a robot that runs."""

    def __init__(self, folder: Path) -> None:
        self.root, self.logs, self.data = folder / "root", folder / "logs", folder / "data"
        self.temporary, self.denied, self.missing = self.root / "tmp", "none", "none"
        self.robot = facts(software=dict.fromkeys(facts().software, own_software()))
        self.now_s, self.master = 4e9, ""
        self.environment = {
            "ROS_IP": "127.0.0.1",
            "ROS_LOG_DIR": str(self.logs),
            "GPR20_STATE": str(folder / "state"),
            "GPR20_DATA": str(self.data),
            "GPR20_CONFIG": f"{self.root}/robot",
        }
        tree(self.root, **FILES)
        self.set(*OWN)
        for name, script in PROGRAMS.items():
            tree(
                folder,
                **{f"bin/{name}": f"#!/bin/sh\n{script}\n".replace("{root}", str(self.root))},
            )
            (folder / "bin" / name).chmod(0o755)
        for place in (self.logs, self.data, self.temporary):
            place.mkdir()
            options = f"size={SIZES[place.name]},nr_inodes=2500"
            subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(place)], check=True)
        self.process(20, "python3 /opt/ros/bin/roslaunch gpr20 survey.launch")
        self.process(21, "node __name:=main_control __log:=/l configuration:=/one", parent=20)
        self.process(22, "watchdog --launch=/one __name:=watchdog __log:=/l", parent=20)
        self.process(23, "node __name:=visualization __log:=/l", parent=20)

    def write(self, name, text):
        tree(self.root, **{name: text})

    def set(self, robot, server, **more):
        self.environment.update(GPR20_ROBOT=robot, GPR20_SERVER=server, **more)

    def process(self, number, words, parent=1, state="S", variables=f"ROS_MASTER_URI={MASTER}"):
        self.write(f"proc/{number}/cmdline", words.replace(" ", "\0"))
        self.write(f"proc/{number}/environ", variables.replace(" ", "\0"))
        self.write(f"proc/{number}/stat", f"{number} (a b) {state} {parent}{' 0' * 30}")

    def change(self, number, old, new):
        path = self.root / f"proc/{number}/stat"
        path.write_text(path.read_text().replace(old, new))

    def look(self):
        """Return what is wrong, by check and code of its fault."""
        if self.master:
            state, here = state_of(self.master), Processes(self.root)
            self.robot = unheard(self.master, evidence_of("", state, self.master, here))
        with ExitStack() as stack:
            allowed = mock.patch("os.access", lambda path, *_mode: self.denied not in str(path))
            found = mock.patch("importlib.util.find_spec", lambda one: one != self.missing or None)
            for one in (allowed, found, mock.patch("time.time", lambda: self.now_s)):
                stack.enter_context(one)
            machine = examine(Machine.here(self.environment, self.root))
        bad = [one for one in findings(self.robot, machine) if one.level >= Level.WARNING]
        return {f"{one.check} {one.text.fault_code}": one for one in bad}


@contextmanager
def computer():
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        path = f"{name}/bin:{os.environ['PATH']}"
        stack.enter_context(mock.patch.dict(os.environ, {"PATH": path}))
        for module, limit in (
            *((all_findings, "LIMIT_S"), (processes, "ANSWER_LIMIT_S")),
            (masters, "ANSWER_LIMIT_S"),
        ):
            stack.enter_context(mock.patch.object(module, limit, 60.0))
        made = Computer(Path(name))
        for place in (made.logs, made.data, made.temporary):
            stack.callback(subprocess.run, ["umount", "--lazy", str(place)], check=True)
        yield made


def nothing(_one):
    """Leave it broken: what ends it is not for a test."""


class State(NamedTuple):
    """A way to break a computer, check and code that must be found, words of its advice.

    `repair` does by hand what the advice says; None: the commands of the advice are run.
    """

    found: str
    words: str
    break_it: Callable[[Computer], Any]
    repair: Any = nothing


def swap(name, bad, good=None):
    """Return what breaks a computer by the text of a file, and what ends that."""
    good = FILES[name] if good is None else good
    return (lambda one: one.write(name, bad)), (lambda one: one.write(name, good))


def fill(one):
    with (one.logs / "large").open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, 225 << 20)


def crowd(one):
    for number in range(600):
        (one.logs / f"small-{number}").touch()


def clear(one):
    for path in one.logs.iterdir():
        path.unlink()


def read_only(place):
    return lambda one: subprocess.run(
        ["mount", "-o", "remount,ro", str(getattr(one, place))], check=True
    )


def has(name, value):
    return lambda one: setattr(one, name, value)


def robot(**changes):
    return lambda one: setattr(one, "robot", replace(one.robot, **changes))


def silent(name):
    return robot(nodes=stale(name).nodes)


def variable(name, value):
    return lambda one: one.environment.update({name: value})


def edit(one):
    one.write("robot/site.yaml", "robot: Mole\n")
    os.utime(one.root / "robot/site.yaml", (5e9, 5e9))


def zone(one):
    (one.root / "etc").mkdir(exist_ok=True)
    (one.root / "etc/localtime").symlink_to("/usr/share/zoneinfo/Mars/Base")


def late(one):
    nodes = [replace(node, clock_offset_s=75.0) for node in one.robot.nodes[:1]]
    one.robot = replace(one.robot, nodes=(*nodes, *one.robot.nodes[1:]))


def updated(one):
    older = replace(own_software(), revision="older")
    one.robot = replace(one.robot, software=dict.fromkeys(one.robot.software, older))


MISTAKE = Message("axes.yaml: x and y use the same pin").with_fault(CONFIGURATION)
FULL = Message("the disk is full").with_fault(DISK_FULL)
OWN = ("127.0.0.1", "127.0.0.2")
NO_INODE = report("vna_processing", 2, FULL).nodes
NOT_RUNNING, LOST = "master robot.not_running", "master robot.master_lost"
ADDRESS, FIREWALL = "addresses network.address", "firewall network.firewall"
STATES = {
    # Nodes.
    "an axis hangs or has ended": State(
        *("y_axis/axis_driver robot.part_lost", "Keep your hands clear"),
        silent("y_axis/axis_driver"),
    ),
    "a part hangs or has ended that moves nothing": State(
        "imaging robot.part_silent", "Wait one minute", silent("imaging")
    ),
    "the watchdog was stopped": State(
        *("launch robot.part_silent", "kill -CONT 22"),
        *(lambda one: one.change(22, " S ", " T "), lambda one: one.change(22, " T ", " S ")),
    ),
    "the watchdog has ended": State(
        *("watchdog robot.internal_error", "watchdog_s"),
        lambda one: one.write("proc/22/cmdline", ""),
    ),
    "the visualization was stopped": State(
        "launch robot.part_silent", "kill -CONT 23", lambda one: one.change(23, " S ", " T ")
    ),
    "roslaunch was stopped": State(
        "launch robot.part_silent", "kill -CONT 20", lambda one: one.change(20, " S ", " T ")
    ),
    "roslaunch has ended": State(
        "launch robot.internal_error", "kill 21 22 23", lambda one: one.write("proc/20/cmdline", "")
    ),
    "the software was updated under a robot that runs": State(
        "versions robot.other_launch", "Start all parts", updated
    ),
    # Files.
    "a file of the configuration was edited under a robot that runs": State(
        "edited robot.other_launch", "Outside a survey, start the robot again", edit
    ),
    "two axes use one pin": State(
        "config_files config.wrong",
        "correct what the message names",
        *swap("problems", f"[{MISTAKE.to_json()}]"),
    ),
    "a Python package is missing": State(
        *("packages computer.not_set_up", "apt install --reinstall gpr20"),
        *(has("missing", "mcap"), has("missing", "none")),
    ),
    "the logs are on a read-only disk": State(
        "volumes disk.refuses", "remount,rw", read_only("logs"), None
    ),
    "/tmp is read-only": State("volumes disk.refuses", "remount,rw", read_only("temporary"), None),
    "the disk of the logs is full": State("volumes disk.full", "copy surveys", fill, clear),
    "the disk of the logs takes no more files": State(
        "volumes disk.full", "copy surveys", crowd, clear
    ),
    "the storage found no inode, and there are some again": State(
        "vna_processing disk.full", "press RESUME", robot(nodes=NO_INODE)
    ),
    # Network.
    "the addresses are those of other computers": State(
        *(ADDRESS, "GPR20_ROBOT and GPR20_SERVER"),
        *(lambda one: one.set("192.0.2.5", "192.0.2.6"), lambda one: one.set(*OWN)),
    ),
    "the parts listen on an address that is gone": State(
        *(ADDRESS, "Check the link"),
        lambda one: one.process(
            *(21, "node __name:=x", 20, "S"), f"ROS_MASTER_URI={MASTER} ROS_IP=192.0.2.7"
        ),
    ),
    "the firewall was flushed": State(FIREWALL, "firewall load", *swap("tables", "")),
    "the firewall is switched off": State(
        FIREWALL, "GPR20_FIREWALL=on", lambda one: one.set(*OWN, GPR20_FIREWALL="off")
    ),
    # Clock.
    "the clock starts in 1970": State(
        "date clock.wrong", "sudo date -s", has("now_s", 86400.0), has("now_s", 4e9)
    ),
    "the time zone of the system is none": State(
        "zone clock.wrong", "timedatectl set-timezone", zone
    ),
    "the time zone of the terminal is none": State(
        "zone clock.wrong", "unset TZ", variable("TZ", "Mars/Base"), variable("TZ", "Europe/Madrid")
    ),
    "the clock of the other computer is 75 s late": State("clocks clock.wrong", "chrony", late),
    # Machine and rights.
    "the SPI bus is off": State(
        *("spi computer.not_set_up", "raspi-config"),
        *(lambda one: (one.root / "dev/spidev0.0").unlink(), None),
    ),
    "the user may not use the SPI bus": State(
        "spi computer.not_set_up", "usermod -aG spi", has("denied", "spidev"), has("denied", "none")
    ),
    "the user may not write the logs": State(
        "volumes disk.refuses", "chown", has("denied", "/logs"), has("denied", "none")
    ),
    "the supply is weak": State(
        "power computer.voltage_low", "battery", *swap("throttled", "throttled=0x1")
    ),
    "the memory is used up": State(
        *("memory robot.overloaded", "End other programs"),
        *swap("proc/meminfo", "MemAvailable: 50000 kB\n"),
    ),
    "Linux has ended a program for lack of memory": State(
        "memory robot.overloaded", "restart the computer", *swap("proc/vmstat", "oom_kill 2\n")
    ),
}


@each_case("name", STATES)
def test_each_broken_state_is_found_with_its_advice_which_ends_it(name):
    state = STATES[name]
    with computer() as one:
        # What is found on this machine whatever is done to it.
        healthy = set(one.look())
        assert state.found not in healthy
        state.break_it(one)
        found = one.look()
        assert set(found) - healthy == {state.found}
        advice = str(found[state.found].remedy)
        assert state.words in advice
        if state.repair is None:
            command = ["sh", "-ec", COMMAND.findall(advice)[0]]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        elif state.repair is not nothing:
            state.repair(one)
        assert state.repair is nothing or set(one.look()) == healthy


class Web(BaseHTTPRequestHandler):
    def do_POST(self):
        self.send_error(404)

    def log_message(self, *_all):
        pass


@contextmanager
def web_server():
    with HTTPServer(("127.0.0.1", 0), Web) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        yield server.server_address[1]
        server.shutdown()
        thread.join()


@contextmanager
def silent_server():
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server.getsockname()[1]


@contextmanager
def closed_port():
    # What is bound and does not listen keeps others from the port.
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        yield taken.getsockname()[1]


MASTERS = [
    # What listens there, whether a rosmaster runs, whether parts do; code and words of the advice.
    (web_server, False, False, NOT_RUNNING, "sudo ss -ltnp"),
    (silent_server, False, False, NOT_RUNNING, "sudo ss -ltnp"),
    (silent_server, True, False, LOST, "switch off the motors' power"),
    (web_server, False, True, LOST, "switch off the motors' power"),
    (closed_port, False, True, LOST, "switch off the motors' power"),
    (closed_port, False, False, NOT_RUNNING, "systemctl restart gpr20"),
]


@each_case("server, has_master, has_parts, code, words", MASTERS)
def test_a_master_that_is_not_heard_has_one_fault_with_its_reason(
    server, has_master, has_parts, code, words
):
    with computer() as one, server() as port, mock.patch.object(masters, "ANSWER_LIMIT_S", 0.3):
        for number in range(20, 24):
            one.write(f"proc/{number}/cmdline", "")
        one.master = f"http://localhost:{port}"
        one.environment["ROS_MASTER_URI"] = one.master
        variables = f"ROS_MASTER_URI={one.master}"
        if has_master:
            one.process(30, f"python3 /opt/rosmaster --core -p {port}", 1, "T", variables)
        if has_parts:
            one.process(31, "node __name:=imaging", 1, "S", variables)
        fault = one.look()[code]
        assert words in str(fault.remedy)
        assert ("motors" in str(fault.remedy)) == (code == LOST)


@each_case(
    "master, parts, advice",
    [
        ("http://no-such-host.invalid:1", "", "/etc/hosts"),
        (MASTER.replace("11311", "1"), MASTER, f"export ROS_MASTER_URI={MASTER}."),
    ],
)
def test_a_wrong_master_has_the_advice_that_names_the_right_one(master, parts, advice):
    with computer() as one:
        one.master = master
        for number in range(20, 24):
            one.process(
                number, "node __name:=x" if parts else "", 1, "S", f"ROS_MASTER_URI={parts}"
            )
        assert advice in str(one.look()[NOT_RUNNING].remedy)


def test_what_a_check_cannot_see_is_unknown_and_never_good():
    with computer() as one:
        for name in ("meminfo", "vmstat"):
            (one.root / "proc" / name).unlink()
        one.write("throttled", "")
        one.write("problems", "")
        with mock.patch("os.geteuid", lambda: 1000):
            report = examine(Machine.here(one.environment, one.root))
        levels = {one.check: one.level for one in report.found}
        for check in ("memory", "power", "config_files", "firewall"):
            assert levels[check] is Level.UNKNOWN, check
        assert all(one.remedy for one in report.found if one.level is not Level.OK)


def test_a_check_that_hangs_is_unknown_and_the_others_are_made():
    never = threading.Event()

    def hangs(_machine):
        yield never.wait(60.0)

    checks = {"disk": hangs, "memory": all_findings.CHECKS["memory"]}
    with mock.patch.multiple(all_findings, LIMIT_S=0.3, CHECKS=checks):
        first, second = examine(Machine()).found
    never.set()
    assert (first.check, first.level) == ("disk", Level.UNKNOWN) and first.remedy
    assert second.check == "memory"

"""Checks of the configuration and the software: what is installed, what runs, what it runs with."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Iterator, List, Optional

import gpr20_common
from gpr20_common.faults import (
    CONFIGURATION,
    INTERNAL,
    NOT_SET_UP,
    OTHER_LAUNCH,
    PART_SILENT,
    VERSIONS_DIFFER,
)
from gpr20_common.low.yaml_file import data_folder
from gpr20_common.message import Message, received_message, verbatim
from gpr20_common.terminal_text import printable
from gpr20_doctor.low.processes import HALTED, Process, answer_of
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.machine import SERVICE, Machine, MachineReport
from gpr20_doctor.mid.node_health import EXPECTED_NODES, IMAGING, node_title
from gpr20_doctor.mid.robot_facts import RobotFacts

CHECK = ("rosrun", "gpr20_launch", "robot_config", "check", "--json")
CHECK_LIMIT_S = 60.0
# Nothing is wrong, and something is.
CHECK_STATUSES = (0, 1)
UNREADABLE = "a problem that cannot be read; run robot_config check by hand"
# What the nodes of each computer import and a system does not bring (requirements/nodes.in); the
# robot works without window and page.
NEEDED = ("lz4", "mcap", "polib", "pydantic", "rosbags", "vxi11", "zstandard")
MODULES = (*NEEDED, "tornado")
# Nodes whose hang the checks of reports find; a hung one must not simply be continued.
OWN_REPORT = frozenset(name.rpartition("/")[2] for name in EXPECTED_NODES)


def check_configuration(machine: Machine) -> Iterator[Finding]:
    """Say what the check of the whole robot finds in the files on this computer."""
    if not machine.thorough:
        return
    folder, robot = machine.config, "simulated" if machine.simulated else "gpr20"
    part = "survey"
    if machine.two_computers:
        part = "robot" if machine.data is None else "server"
    # That of the configuration, unless the launch was given another.
    default = data_folder(
        str(machine.configured("storage.yaml", "data") or ""), machine.environment
    )
    data = "" if machine.data in (None, default) else str(machine.data)
    command = (*CHECK, "--robot", robot, "--part", part, "--data", data, str(folder))
    records = json.loads(answer_of(command, CHECK_LIMIT_S, CHECK_STATUSES))
    for one in records:
        # Each problem has its own fault; one without has that of a value.
        text = Message("Configuration: {reason}", reason=received_message(UNREADABLE, one))
        yield Finding.of("config_files", text, CONFIGURATION if text.cause is None else None)
    if not records:
        values = {"folder": printable(folder), "robot": robot}
        text = Message("Configuration in {folder}, for robot:={robot}", **values)
        yield Finding.of("config_files", text)


def check_edited(machine: Machine) -> Iterator[Finding]:
    """Find files that a running robot has read, and that were changed since."""
    launches = machine.processes.launches_of(machine.master)
    if not launches:
        return
    started_s = min(one.started_s for one in launches)
    # In a checkout each package has its sources below src; where they are installed, beside it.
    module = Path(gpr20_common.__file__).resolve()
    programs = [*module.parents[3].glob("gpr20_*/src/**/*.py")]
    programs += module.parents[1].glob("gpr20_*/**/*.py")
    files = [*machine.config.glob("*.yaml"), *programs]
    later = [one for one in files if one.stat().st_mtime > started_s]
    if not later:
        yield Finding.of("edited", Message("The robot runs with the files as they are now."))
        return
    text = Message(
        "Changed since the robot was started, which runs as before: {files}",
        files=", ".join(printable(one) for one in sorted(later)[:3]),
    )
    advice = machine.restart(Message("Outside a survey, start the robot again."))
    yield Finding.of("edited", text, OTHER_LAUNCH.as_warning(), advice=advice)


def check_launch(machine: Machine) -> Iterator[Finding]:
    """Find parts of the robot that nobody would start again."""
    nodes = machine.processes.nodes_of(machine.master)
    left = [one for one in nodes if one.master and machine.processes.is_left_over(one)]
    launches = machine.processes.launches_of(machine.master)
    if left:
        text = Message(
            "The launch of {count} parts of the robot on this computer has ended. They run on, "
            "and nothing starts one of them again if it ends.",
            count=len(left),
        )
        advice = Message(
            "Run: kill {numbers}. A survey that runs is stopped and can be resumed. Then start the "
            "robot again.",
            numbers=_numbers(left),
        )
        yield Finding.of("launch", text, INTERNAL, mild=True, advice=machine.restart(advice))
    others = [one for one in nodes if one.node not in OWN_REPORT]
    halted = [one for one in (*launches, *others) if one.state in HALTED]
    if halted:
        names = tuple(node_title(one.node) if one.node else verbatim("roslaunch") for one in halted)
        text = Message("Stopped on this computer, and does nothing: {parts}", parts=names)
        advice = Message(
            "Run: kill -CONT {numbers}. If it is found again, start the robot again.",
            numbers=_numbers(halted),
        )
        yield Finding.of("launch", text, PART_SILENT, advice=advice)
    if launches and not left + halted:
        yield Finding.of("launch", Message("Launch of the robot on this computer"))


def check_watchdog(machine: Machine) -> Iterator[Finding]:
    """Judge whether each launch has what would end its parts that hang; it may be stopped."""
    known = machine.processes
    nodes = [one for one in known.nodes_of(machine.master) if not known.is_left_over(one)]
    launches = {one.argument("configuration:=") for one in nodes} - {""}
    watched = {one.argument("--launch=") for one in nodes}
    if launches - watched:
        text = Message("No watchdog runs here: a part of the robot that hangs is not restarted.")
        again = Message("Start the robot again, with watchdog_s:=10 or without that argument.")
        yield Finding.of("watchdog", text, INTERNAL, True, machine.restart(again))
    elif launches:
        yield Finding.of("watchdog", Message("Watchdog"))


def _numbers(some: List[Process]) -> str:
    return " ".join(map(str, sorted(one.number for one in some)))


def check_packages(machine: Machine) -> Iterator[Finding]:
    """Find Python packages that the parts of the robot import and that are not installed."""
    missing = [one for one in MODULES if importlib.util.find_spec(one) is None]
    if not missing:
        yield Finding.of("packages", Message("Python packages of the robot"))
        return
    text = Message("Python packages are missing: {names}", names=", ".join(missing))
    advice = Message("Run: scripts/setup.sh")
    if machine.settings:
        advice = Message("Run: sudo apt install --reinstall {package}", package=SERVICE)
    yield Finding.of("packages", text, NOT_SET_UP, advice=advice)


def check_versions(facts: RobotFacts, here: Optional[MachineReport]) -> Iterator[Finding]:
    """Compare the software of the nodes, and what is installed here, if that was looked for."""
    if not facts.control_alive:
        return
    software = {name: one for name, one in facts.software.items() if one.version}
    # The node of the images does not describe itself.
    silent = [one for one in EXPECTED_NODES if one not in (IMAGING, *software)]
    if here is not None:
        software["installed here"] = here.software
    versions = sorted({(one.name, one.host) for one in software.values()})
    if len({name for name, _host in versions}) > 1:
        found = tuple(
            Message("{software} on {host}", software=name, host=host or "?")
            for name, host in versions
        )
        text = Message("The parts of the robot run different software: {versions}", versions=found)
        fault, advice = VERSIONS_DIFFER.as_warning(), None
        if here is not None and len({host for _name, host in versions}) < len(versions):
            # It was updated under a robot that runs on.
            again = Message("Start all parts of the robot again, from one installation.")
            fault, advice = OTHER_LAUNCH.as_warning(), here.machine.restart(again)
        yield Finding.of("versions", text, fault, advice=advice)
    elif silent:
        text = Message("Not known: the software of {parts}", parts=tuple(map(node_title, silent)))
        yield Finding("versions", Level.UNKNOWN, text, VERSIONS_DIFFER.remedy)
    else:
        text = Message("Software {software} on every part", software=versions[0][0])
        yield Finding.of("versions", text)

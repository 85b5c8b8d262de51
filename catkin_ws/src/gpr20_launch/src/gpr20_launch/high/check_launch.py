"""check_launch: what the launch files run before anything starts.

It prints the configuration of the nodes as JSON, which roslaunch stores under a name of this
launch alone. If it fails, roslaunch starts nothing and changes nothing.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Optional, Sequence

import rosgraph
import rospkg

from gpr20_common.errors import Gpr20Error, NodeSilentError
from gpr20_common.faults import OTHER_LAUNCH
from gpr20_common.low.links import NodeProbe
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_doctor.mid.finding import Finding
from gpr20_launch.errors import LaunchRefusedError
from gpr20_launch.low.process_info import ProcessInfo, process_info
from gpr20_launch.mid.launch_request import REAL, ROBOT, SERVER, SURVEY, LaunchRequest
from gpr20_launch.mid.machine_warnings import machine_warnings
from gpr20_launch.mid.place_checks import Use
from gpr20_launch.mid.problem import Problem
from gpr20_launch.mid.robot_check import BuiltRobot, check_robot
from gpr20_launch.mid.running_robot import RunningNode, refusal
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters

NAME = "/check_launch"
# A node that lives answers within this time [s].
ANSWER_LIMIT_S = 1.0


def main() -> int:
    """Check a launch and print the configuration of its nodes; return the exit status."""
    given = _parser().parse_args(rosgraph.myargv()[1:])
    try:
        request = LaunchRequest(
            given.part,
            given.robot,
            given.config,
            given.data,
            _simulator(given),
            given.full_screen,
        )
        use = Use(request.folder, os.environ, given.data, given.robot == REAL, given.part)
        found = check_robot(use, built_robot())
        if any(one.refuses for one in found):
            _refuse_mistakes(found)
            return 1
        sections = request.sections(built_axes())
        _refuse_running(request.nodes, given.ns)
    except (Gpr20Error, OSError, RuntimeError) as error:
        # A folder that may not be searched, a master that has ended, ~USER without such a user.
        say("", f"This robot cannot be launched: {error}", "", file=sys.stderr)
        return 1
    doubtful = [Finding.of_fault("config_files", one.message) for one in found]
    _print_warnings([*doubtful, *machine_warnings(request, sections, os.environ)])
    print(json.dumps(sections))
    return 0


def built_axes() -> Path:
    """Return the file with the axes of the robot as it is built."""
    return Path(rospkg.RosPack().get_path("gpr20_launch")) / "config" / "axes.yaml"


def built_robot() -> BuiltRobot:
    """Return the robot as it is built, and what is installed here."""
    return BuiltRobot(built_axes(), _message_field)


def _message_field(datatype: str, field: str) -> object:
    # Imported only with a sensor: a launch without one need not wait for it.
    from gpr20_main_control.high.sensor_topics import MessageField

    return MessageField(datatype, field)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description="Check a launch; used by the launch files.")
    parser.add_argument("--part", choices=(ROBOT, SERVER, SURVEY), required=True)
    for name in ("robot", "ns", "config", "data", "scene", "medium", "capture_dir"):
        parser.add_argument(f"--{name}", default="")
    for name in ("time_scale", "seconds_per_point"):
        parser.add_argument(f"--{name}", default="1")
    parser.add_argument("--portmapper", default="false")
    parser.add_argument("--full_screen", default="auto")
    return parser


def _simulator(given: argparse.Namespace) -> SimulatorParameters:
    return SimulatorParameters(
        scene=given.scene,
        time_scale=_number("time_scale", given.time_scale),
        seconds_per_point=_number("seconds_per_point", given.seconds_per_point),
        portmapper=given.portmapper == "true",
        medium=given.medium,
        capture_dir=given.capture_dir,
    )


def _refuse_mistakes(found: Sequence[Problem]) -> None:
    lines = [f"- {one.message}" for one in found if one.refuses]
    say("", "This robot cannot be launched: its configuration is wrong.", *lines, file=sys.stderr)
    say("Correct it, then see that nothing is left: robot_config check", "", file=sys.stderr)


def _print_warnings(found: Sequence[Finding]) -> None:
    # The standard output is the configuration.
    for one in found:
        end = "" if str(one.text).endswith(".") else "."
        remedy = "" if one.remedy is None else f" {one.remedy}"
        say(f"{one.level.title}: {one.text}{end}{remedy}", file=sys.stderr)


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        values = {"name": name, "value": text}
        reason = Message("{name}:={value} is not a number; give one, such as {name}:=1", **values)
        raise LaunchRefusedError(reason) from error


def _refuse_running(names: Sequence[str], namespace: str) -> None:
    master = rosgraph.get_master_uri()
    if not rosgraph.is_master_online(master):
        return
    prefix = "/" + namespace.strip("/")
    found = [_running(rosgraph.names.ns_join(prefix, name), master) for name in names]
    nodes = [one for one in found if one is not None]
    if any(one.is_left_over for one in nodes):
        # They outlive a roslaunch that was killed, too.
        shared = [_running("/rosout", master), _master(master)]
        nodes += [one for one in shared if one is not None and one.is_left_over]
    if nodes:
        raise LaunchRefusedError(refusal(nodes, master), fault=OTHER_LAUNCH)


def _running(name: str, master: str) -> Optional[RunningNode]:
    try:
        number = NodeProbe(master, NAME, name, ANSWER_LIMIT_S).process()
    except NodeSilentError:
        return None
    process = process_info(number)
    if process is not None and not process.may_be_node(name):
        process = None  # the number is that of a process on another computer
    return RunningNode(name, number, process, _parent(process))


def _master(master: str) -> Optional[RunningNode]:
    number = rosgraph.Master(NAME, master).getPid()
    process = process_info(number)
    if process is not None and not any("rosmaster" in word for word in process.command[:3]):
        process = None
    return RunningNode("rosmaster", number, process, _parent(process))


def _parent(process: Optional[ProcessInfo]) -> Optional[ProcessInfo]:
    return process_info(process.parent) if process else None

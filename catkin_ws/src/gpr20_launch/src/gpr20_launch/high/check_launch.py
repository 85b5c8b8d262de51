"""check_launch: what the launch files run before anything starts.

It prints the configuration of the nodes as JSON, which roslaunch stores under a name of this
launch alone. If it fails, roslaunch starts nothing and changes nothing.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
from dataclasses import fields
from importlib.util import find_spec
from pathlib import Path
from typing import Dict, List, Mapping, Sequence, TextIO

import rosgraph
import rospkg

from gpr20_common.errors import ConfigurationError, Gpr20Error, NodeSilentError
from gpr20_common.faults import NOT_SET_UP, OTHER_LAUNCH
from gpr20_common.low.links import NodeProbe
from gpr20_common.low.yaml_file import DEFAULT_FOLDER
from gpr20_common.message import verbatim
from gpr20_common.terminal_text import say
from gpr20_doctor.low.processes import Process, process_of
from gpr20_doctor.mid.software_checks import NEEDED
from gpr20_launch.faults import LaunchRefusedError
from gpr20_launch.mid.launch_request import nodes_of, sections_of
from gpr20_launch.mid.old_launch import UNREAD
from gpr20_launch.mid.robot_check import check_robot
from gpr20_launch.mid.robot_files import PARTS, REAL, ROBOTS, Problem, Reading, Use
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters

NAME = "/check_launch"
# A node that lives answers within this time [s].
ANSWER_LIMIT_S = 1.0


def main() -> int:
    """Check a launch and print the configuration of its nodes; return the exit status."""
    given = _parser().parse_args(rosgraph.myargv()[1:])
    use = Use(os.environ, given.data, given.robot == REAL, given.part)
    names = [one.name for one in fields(SimulatorParameters)]
    try:
        missing = ", ".join(one for one in NEEDED if find_spec(one) is None)
        if missing:
            text = f"the Python modules {missing} are missing; run: scripts/setup.sh"
            raise LaunchRefusedError(verbatim(text), fault=NOT_SET_UP)
        own = {name: value for name, value in vars(given).items() if name in names}
        simulator = SimulatorParameters(**own)
        reading = Reading(_folder(given), built_axes())
        found = check_robot(reading, use, message_field)
        if any(one.refuses for one in found):
            lines = [f"- {one.message}" for one in found if one.refuses]
            head = "This robot cannot be launched: its configuration is wrong."
            end = "Correct it, then see that nothing is left: robot_config check"
            say("", head, *lines, end, "", file=sys.stderr)
            return 1
        sections = sections_of(reading, use, simulator)
        _refuse_running(nodes_of(use), given.ns)
    except (Gpr20Error, OSError, RuntimeError) as error:
        # A folder that may not be searched, a master that has ended, ~USER without such a user.
        say("", f"This robot cannot be launched: {error}", "", file=sys.stderr)
        return 1
    # The standard output is the configuration.
    say_problems(found, sys.stderr)
    print(json.dumps(sections))  # noqa: T201
    return 0


def _folder(given: argparse.Namespace) -> Path:
    if given.robot == REAL and given.time_scale != 1.0:
        text = f"time_scale:={given.time_scale:g} is for the simulated robot; leave it out"
        raise LaunchRefusedError(verbatim(text))
    folder = Path(given.config or DEFAULT_FOLDER).expanduser().absolute()
    if given.config and not folder.is_dir():
        text = f"{folder} (config:=) is no folder; create it with its files: "
        text += f"rosrun gpr20_launch robot_config create {folder}"
        raise ConfigurationError(verbatim(text))
    return folder


def built_axes() -> Path:
    """Return the file with the axes of the robot as it is built."""
    return Path(rospkg.RosPack().get_path("gpr20_launch")) / "config" / "axes.yaml"


def message_field(datatype: str, field: str) -> object:
    """Return a field of the messages of a type, or raise an InvalidValueError."""
    # Imported only with a sensor: a launch without one need not wait for it.
    from gpr20_main_control.high.sensor_topics import MessageField

    return MessageField(datatype, field)


def say_problems(found: Sequence[Problem], stream: TextIO) -> None:
    """Print problems; what is to be done about several in a row is said once."""
    # All that an imported launch file left open is one mistake.
    unread = [one for one in found if UNREAD in str(one.message)]
    found = [one for one in found if one not in unread[1:]]
    for one, after in zip(found, [*found[1:], None]):
        say(f"{'FAULT' if one.refuses else 'WARNING'}: {one.message}", file=stream)
        remedy = one.message.remedy
        if remedy is not None and (after is None or after.message.remedy != remedy):
            say(f"  -> {remedy}", file=stream)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("check_launch", usage=argparse.SUPPRESS)
    parser.add_argument("--part", choices=PARTS, required=True)
    parser.add_argument("--robot", choices=ROBOTS, required=True)
    parser.add_argument("--full_screen", choices=("auto", "true", "false"), default="auto")
    for name in ("ns", "config", "data", "scene", "medium", "capture_dir"):
        parser.add_argument(f"--{name}", default="")
    for name in ("time_scale", "seconds_per_point"):
        parser.add_argument(f"--{name}", type=float, default=1.0)
    parser.add_argument("--portmapper", type="true".__eq__, default=False)
    return parser


def _refuse_running(names: Sequence[str], namespace: str) -> None:
    master = rosgraph.get_master_uri()
    if not rosgraph.is_master_online(master):
        return
    prefix = "/" + namespace.strip("/")
    nodes = _running([rosgraph.names.ns_join(prefix, one) for one in names], master)
    if nodes:
        said = refusal(master, nodes, _processes(nodes))
        raise LaunchRefusedError(verbatim(said), fault=OTHER_LAUNCH)


def _running(names: Sequence[str], master: str) -> Dict[str, int]:
    found = {}
    for name in names:
        with contextlib.suppress(NodeSilentError):
            found[name] = NodeProbe(master, NAME, name, ANSWER_LIMIT_S).process()
    return found


def _processes(nodes: Mapping[str, int]) -> List[Process]:
    """Return what runs on this computer: a number may be of a process elsewhere."""
    found = {name: process_of(number) for name, number in nodes.items()}
    return [one for name, one in found.items() if one is not None and may_be(one, name)]


def may_be(process: Process, node: str) -> bool:
    """Return whether it can be that node; rosrun starts a program of its name."""
    base = node.rpartition("/")[2]
    return process.node == base or any(Path(one).name.endswith(base) for one in process.words[:2])


def refusal(master: str, nodes: Mapping[str, int], here: Sequence[Process]) -> str:
    """Return which nodes answer, by their process ids, and the command that ends those here."""
    names = ", ".join(f"{name} (process {number})" for name, number in nodes.items())
    parents = {one.parent: process_of(one.parent) for one in here}
    launches = [number for number, one in parents.items() if one is not None and one.is_launch]
    # What outlived its roslaunch is ended by itself.
    ends = sorted({one.parent if one.parent in launches else one.number for one in here})
    remedy = "It was started on another computer; end it there."
    if ends:
        remedy = "To end it, run this; a survey that runs is stopped and can be resumed: kill "
        remedy += " ".join(map(str, ends))
    return (
        f"a robot is running on {master}: {names}. To launch another one beside it, add a "
        f"namespace, such as ns:=robot2. {remedy}"
    )

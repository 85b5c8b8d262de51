"""A configuration made of the launch files of the software with which GPR-20 was built.

Its axis node (gpr20_axis_driver, 2021) reads nine parameters of each axis. It drives DIR low for
increasing coordinates, and sets no pull-up for the endstops.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, Mapping

import yaml

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_launch.errors import OldLaunchError
from gpr20_launch.mid.hints import UNREAD
from gpr20_launch.mid.old_launch import LaunchParameters, Unread
from gpr20_launch.mid.problem import Problem
from gpr20_launch.mid.robot_files import AXES_FILE, AXIS_SECTIONS
from gpr20_launch.mid.wiring import Unchecked
from gpr20_survey.axes.axis_parameters import LINEAR, ROTARY

PINS = ("dir_pin", "step_pin", "sensor_pin")
NUMBERS = ("step_size", "min_step", "max_step", "delta_step", "min_coord", "max_coord")
NAMES = (*PINS, *NUMBERS, "type")
_TYPES = (LINEAR, ROTARY)
VNA_NAMES = ("vna_ip", "ip_addr", "vna_address")
# Such as gpr20_x_axis, x_axis, axis_x or x, as one part of a name.
_AXIS = re.compile(r"(?:.*_)?(?:([xyz])(?:_?axis)?|axis_?([xyz]))(?:_.*)?")
ANALYZER_FILE, WIRING_FILE = "analyzer.yaml", "wiring.yaml"
# Two are about the group's board.
NOT_ITS_OWN = (Unchecked.Z_DIRECTION_OR_STEP, Unchecked.NO_5_V, Unchecked.UNREAD)
TO_CHECK = [one.value for one in Unchecked if one not in NOT_ITS_OWN]


@dataclass
class OldRobot:
    """A configuration, and what became of the parameters.

    Attributes:
        texts: Text of each file.
        taken: Parameters that mean the same here.
        changed: What is written otherwise, and why.
        left: Parameters that have no counterpart here.
        problems: What could not be read; a warning if it sets nothing of an axis.
    """

    texts: Dict[str, str] = field(default_factory=dict)
    taken: List[str] = field(default_factory=list)
    changed: List[str] = field(default_factory=list)
    left: List[str] = field(default_factory=list)
    problems: List[Problem] = field(default_factory=list)


def old_robot(
    path: Path, parameters: LaunchParameters, defaults: Mapping[str, Mapping[str, Any]]
) -> OldRobot:
    """Return the configuration that a launch file of the original means.

    Raises:
        OldLaunchError: It sets no parameter of an axis.
    """
    robot = OldRobot()
    axes: Dict[str, Dict[str, Any]] = {axis: {} for axis in AXIS_SECTIONS}
    for name, value in sorted(parameters.values.items()):
        axis, key = _axis_of(name), name.rsplit("/", 1)[-1]
        if axis and key in NAMES:
            other = axes[axis].setdefault(key, value)
            if other != value:
                axes[axis][key] = f"{UNREAD} {path.name}: {other} and {name} {value}"
        elif str(value).upper() == "BCM":
            text = Message("{name}: the pins are numbers of the processor", name=f"{name} {value}")
            parameters.unread.append(Unread(text, ""))
        elif key in VNA_NAMES:
            robot.texts[ANALYZER_FILE] = f"# From {path.name}.\naddress: {_written(value)}\n"
            robot.taken.append(f"{name} -> {ANALYZER_FILE} address: {value}")
        else:
            robot.left.append(f"{name}: {value}")
    _mark_unread(parameters, axes, defaults, robot)
    if all(str(one).startswith(UNREAD) for axis in axes.values() for one in axis.values()):
        example = "gpr20_x_axis/gpr20_axis/dir_pin"
        text = Message(
            "{file} sets no parameter of an axis, such as {example}; give the launch file that "
            "starts the nodes of the axes",
            file=path,
            example=example,
        )
        raise OldLaunchError(
            next((one.message for one in parameters.unread if one.name == ""), text)
        )
    _mark_unset(path.name, axes, defaults, robot)
    lines = [f"# {AXES_FILE}: from {path.name}; a key that is not here has its default."]
    for axis in AXIS_SECTIONS:
        lines += _axis_lines(axis, axes[axis], defaults[axis], robot)
    robot.texts[AXES_FILE] = "\n".join([*lines, ""])
    unread = [one.message for one in robot.problems if one.refuses]
    robot.texts[WIRING_FILE] = "\n".join(
        [
            f"# {WIRING_FILE}: {path.name} does not show whether this is right for the robot.",
            "# Delete each line when a person has checked it, as docs/wiring.md describes.",
            *(f"# unread: {printable(str(one))}" for one in unread),
            yaml.safe_dump(
                {"unchecked": [*([Unchecked.UNREAD.value] if unread else []), *TO_CHECK]}
            ),
        ]
    )
    return robot


def _mark_unread(
    parameters: LaunchParameters,
    axes: Mapping[str, Dict[str, Any]],
    defaults: Mapping[str, Mapping[str, Any]],
    robot: OldRobot,
) -> None:
    """Give what could not be read a value that no launch accepts, in place of a default."""
    for one in parameters.unread:
        name = one.name
        own = [axis for axis in axes if name is not None and _axis_of(name or f"/{axis}/") == axis]
        key = "" if name is None else name.rsplit("/", 1)[-1]
        matters = bool(own) and key in ("", *NAMES)
        message = _to_look_up(one.message)
        robot.problems.append(Problem(message if matters else message.as_warning()))
        for axis in own if matters else ():
            absent = set(defaults[axis]) & set(NAMES) - set(axes[axis])
            for other in {key} if key else absent:
                axes[axis][other] = f"{UNREAD} {one.message}"


def _mark_unset(
    file: str,
    axes: Mapping[str, Dict[str, Any]],
    defaults: Mapping[str, Mapping[str, Any]],
    robot: OldRobot,
) -> None:
    """Do the same with pins, and whole axes, that nothing sets: another robot has other ones."""
    for axis, own in axes.items():
        names = [key for key in (PINS if own else NAMES) if key in {*defaults[axis]} - {*own}]
        if names:
            text = Message(
                "{file} does not set {names}", file=file, names=", ".join(names) if own else axis
            )
            robot.problems.append(Problem(_to_look_up(text)))
            own.update({key: f"{UNREAD} {text}" for key in names})


def _to_look_up(reason: Message) -> Message:
    return Message(
        "{reason}; look up on the original robot what it sets, and write it into {file}",
        reason=reason,
        file=AXES_FILE,
    ).with_fault(CONFIGURATION)


def _axis_of(name: str) -> str:
    """Return the axis that a full name of a parameter belongs to; empty: none."""
    for part in reversed(name.split("/")[:-1]):
        match = _AXIS.fullmatch(part.lower())
        if match:
            return match.group(1) or match.group(2)
    return ""


def _axis_lines(
    axis: str, old: Mapping[str, Any], defaults: Mapping[str, Any], robot: OldRobot
) -> List[str]:
    def changed(text: str) -> None:
        robot.changed.append(f"{axis}/{text}")

    for key in (key for key in defaults if key in NAMES and key not in old):
        changed(f"{key}: not in the file, so the default counts: {defaults[key]}")
    own, pin = dict(old), old.get("sensor_pin")
    if all(str(value).startswith(UNREAD) for value in own.values()):
        return [f"{axis}: {_written(value)}" for value in list(own.values())[:1]]
    kind = str(own.get("type", defaults["type"])).strip().upper()
    if kind in _TYPES and kind != own.get("type", kind):
        own["type"] = kind
        changed(f"type: {old['type']} -> {kind}")
    if "sensor_pin" in own and kind == ROTARY:
        del own["sensor_pin"]
        changed(f"sensor_pin: {pin} -> left out: an axis that turns has no endstop, also before")
        changed("min_coord: homing called the place where it was so; here a person sets 0")
    elif isinstance(pin, int) and pin < 0:
        own["sensor_pin"] = None
        changed(f"sensor_pin: {pin} -> null: no endstop")
    changed("invert_direction: true, because DIR was low for increasing coordinates")
    if own.get("sensor_pin") is not None:
        changed("endstop_pull: up, so that a broken wire has a level; before there was none")
    lines = [f"{axis}:"]
    for key in NAMES:
        if key in own:
            if not str(own[key]).startswith(UNREAD):
                robot.taken.append(f"{axis}/{key}: {own[key]}{_unit(axis, key)}")
            lines.append(f"  {key}: {_written(own[key])}")
    return [*lines, "  invert_direction: true  # DIR was low for increasing coordinates"]


def _written(value: Any) -> str:
    text: str = yaml.safe_dump(value, default_flow_style=True, width=math.inf)
    return text.splitlines()[0]  # a plain value is followed by a line of dots


def _unit(axis: str, key: str) -> str:
    if key in ("step_size", "min_coord", "max_coord"):
        return " deg" if axis == "z" else " mm"
    return " s" if key in NUMBERS else ""

"""A configuration made of the launch files of the software with which GPR-20 was built.

Only what sets parameters is followed: args, groups, nodes, includes and rosparam. Nothing is run.
What cannot be found out here is named, and refuses every launch until a person has looked.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Union
from xml.etree import ElementTree

import yaml

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.yaml_file import limited_bytes, parse_yaml
from gpr20_common.message import verbatim
from gpr20_launch.faults import LaunchRefusedError
from gpr20_launch.mid.axis_checks import HEIGHT_FILE, LATEST_PULSE
from gpr20_launch.mid.robot_files import AXES_FILE, AXIS_SECTIONS
from gpr20_survey.axes import ROTARY, AxisParameters

# Begins the value of what could not be found out and a person must write.
UNREAD, NO_PIN, MAX_VALUES = "UNREAD, write it", -1, 10_000
NAMES = tuple(one.name for one in fields(AxisParameters)[:10])
# Such as gpr20_x_axis, x_axis, axis_x or x, as one part of a name.
_AXIS = re.compile(r"(?:.*_)?(?:([xyz])(?:_?axis)?|axis_?([xyz]))(?:_.*)?")
_SUBSTITUTION = re.compile(r"\$\(([^()]*)(\)?)")
_BOOLS = {"true": True, "1": True, "false": False, "0": False}
TO_CHECK = ["pins", "endstop_levels", "directions", "travel", "emergency_stop"]


@dataclass
class OldRobot:
    """The files of a configuration, and what could not be found out.

    Of the values, such as x/dir_pin, in the end those without a counterpart are left.
    """

    values: Dict[str, Any] = field(default_factory=dict)
    unread: List[str] = field(default_factory=list)
    texts: Dict[str, str] = field(default_factory=dict)

    def take(self, part: str, names: Iterable[str]) -> Dict[str, Any]:
        known = [key for key in names if f"{part}/{key}" in self.values]
        return {key: self.values.pop(f"{part}/{key}") for key in known}


@dataclass(frozen=True)
class _Scope:
    """Where an element is: its file, the names around it, and the args that it knows."""

    file: Path
    namespace: str = "/"
    arguments: Dict[str, str] = field(default_factory=dict)

    def join(self, name: str) -> str:
        return name if name.startswith("/") else f"{self.namespace.rstrip('/')}/{name}".rstrip("/")

    def text(self, element: ElementTree.Element, name: str, default: str = "") -> str:
        return self.substituted(element.get(name, default))

    def substituted(self, text: str) -> str:
        """Return a text with its args; the folder of a package is looked for around the file."""

        def value(match: re.Match[str]) -> str:
            kind, _space, name = match.group(1).strip().partition(" ")
            around = list(self.file.absolute().parents)[:4]
            packages = [one for one in around if one.name == name]
            packages += [one / name for one in around if os.path.isdir(one / name)]
            known = {"arg": self.arguments.get(name), "dirname": around[0]}
            found = next(iter(packages), None) if kind == "find" else known.get(kind)
            if found is None or not match.group(2):
                # Also env and eval: only the original's computer knows what they are.
                raise _refused(f"{match.group()} is not known here")
            return str(found)

        return _SUBSTITUTION.sub(value, text)

    def uses(self, element: ElementTree.Element) -> bool:
        used = [self.text(element, "if", "1").lower(), self.text(element, "unless", "0").lower()]
        if not {*used} <= {*_BOOLS}:
            raise _refused("its condition is neither true nor false")
        return _BOOLS[used[0]] and not _BOOLS[used[1]]


def old_robot(path: Path, defaults: Mapping[str, Mapping[str, Any]]) -> OldRobot:
    """Return the configuration that a launch file of the original means.

    Raises:
        LaunchRefusedError: It cannot be read, is no launch file, or sets nothing of an axis.
    """
    robot = OldRobot()
    read(path, robot)
    axes = {axis: robot.take(axis, NAMES) for axis in AXIS_SECTIONS}
    if not any(axes.values()):
        reasons = "; ".join(robot.unread) or "give the one that starts the nodes of the axes"
        raise _refused(f"{path} sets no parameter of an axis: {reasons}")
    for axis, own in axes.items():
        # Another robot has other values, and its axis node has no defaults.
        missing = [key for key in NAMES if key in {*defaults[axis]} - {*own}]
        if missing:
            robot.unread.append(f"{path.name} does not set {axis}: {', '.join(missing)}")
        own.update(dict.fromkeys(missing, f"{UNREAD}: {'; '.join(robot.unread)}"))
        # Its axis node drives DIR low for increasing coordinates, and knows no late pulses.
        own["invert_direction"] = True
        if own.get("type") == ROTARY or own.get("sensor_pin") == NO_PIN:
            own["sensor_pin"] = None
        pause_s = own["min_step"]
        if isinstance(pause_s, float) and LATEST_PULSE * pause_s < AxisParameters.late_limit_s:
            own["late_limit_s"] = LATEST_PULSE * pause_s
    notes = "".join(f"# unread: {one!r}\n" for one in robot.unread)
    unchecked = {"unchecked": ["unread"] * bool(robot.unread) + TO_CHECK}
    robot.texts["wiring.yaml"] = notes + yaml.safe_dump(unchecked)
    for name, content in ((AXES_FILE, axes), (HEIGHT_FILE, robot.take("height", ("channel",)))):
        if content:
            robot.texts[name] = f"# From {path.name}.\n{yaml.safe_dump(content, sort_keys=False)}"
    return robot


def read(path: Path, robot: OldRobot) -> None:
    """Add the parameters that a launch file and those that it includes set."""
    try:
        _follow(_root(path), _Scope(path), robot)
    except RecursionError as error:
        raise _refused(f"{path} is nested too deeply") from error


def _refused(text: str) -> LaunchRefusedError:
    return LaunchRefusedError(verbatim(text))


def _root(path: Path) -> ElementTree.Element:
    try:
        text = limited_bytes(path).decode("utf-8", "replace")
        root = ElementTree.fromstring("" if "<!ENTITY" in text else text)
    except (ElementTree.ParseError, OSError, ValueError) as error:
        raise _refused(f"{path} is not a launch file: {error}") from error
    if root.tag != "launch":
        raise _refused(f"{path} is not a launch file")
    return root


def _follow(parent: ElementTree.Element, scope: _Scope, robot: OldRobot) -> None:
    for element in parent:
        try:
            if scope.uses(element):
                _element(element, scope, robot)
        except (OSError, Gpr20Error) as error:
            # Short, so that the reason is still seen where a message cuts a long value.
            text = ElementTree.tostring(element, "unicode").strip()[:60]
            robot.unread.append(f"{scope.file.name}: {text} could not be read: {error}")


def _element(element: ElementTree.Element, scope: _Scope, robot: OldRobot) -> None:
    inner = replace(scope, namespace=scope.join(scope.text(element, "ns")))
    name = scope.text(element, "name")
    if element.tag == "arg":
        # A value that was passed to an include replaces the default.
        passed = scope.arguments.pop(name, element.get("default"))
        text = element.get("value", passed)
        if text is not None:
            scope.arguments[name] = scope.substituted(text)
    elif element.tag == "group":
        # An arg inside of a group does not exist behind it.
        _follow(element, replace(inner, arguments=dict(scope.arguments)), robot)
    elif element.tag == "node":
        _follow(element, replace(inner, namespace=inner.join(name)), robot)
        if scope.text(element, "args"):
            raise _refused("only its program knows what its args mean")
    elif element.tag == "param":
        kind = element.get("type", "auto")
        if "value" not in element.attrib or name[:1] in "~/" or kind in ("yaml", "bool"):
            raise _refused("its value comes from elsewhere, or goes to another node")
        text = scope.text(element, "value")
        _load(text if kind in ("str", "string") else _plain(text), scope.join(name), robot)
    elif element.tag == "rosparam":
        if element.get("command", "load") != "load":
            raise _refused("it deletes or writes parameters")
        text, file = element.text or "", scope.text(element, "file")
        path, around = Path(file).resolve(), [*scope.file.resolve().parents][:3]
        if file:
            if path.suffix not in (".yaml", ".yml") or around[-1] not in path.parents:
                raise _refused("only a .yaml file in a folder around the launch file is read")
            text = limited_bytes(path).decode("utf-8", "replace")
        try:
            content = parse_yaml(scope.substituted(text))
            _load(content, inner.join(scope.text(element, "param")), robot)
        except Gpr20Error as error:
            # Nothing of a file is printed, whatever it is.
            raise (_refused("what it holds cannot be used") if file else error) from error
    elif element.tag == "include":
        path = Path(scope.text(element, "file"))
        given = scope.arguments if scope.text(element, "pass_all_args") == "true" else {}
        for one in filter(scope.uses, element.findall("arg")):
            given = {**given, one.get("name", ""): scope.text(one, "value")}
        _follow(_root(path), replace(inner, file=path, arguments={**given}), robot)


def _plain(text: str) -> Union[int, float, bool, str]:
    """Return a value as roslaunch understands it without a type."""
    try:
        return float(text) if "." in text else int(text)
    except ValueError:
        return {"true": True, "false": False}.get(text.lower(), text)


def _load(values: Any, name: str, robot: OldRobot) -> None:
    if isinstance(values, dict):
        for key, value in values.items():
            _load(value, f"{name.rstrip('/')}/{key}", robot)
        return
    *above, key = name.split("/")
    parts = [_AXIS.fullmatch(one.lower()) for one in reversed(above)]
    axes = [one.group(1) or one.group(2) for one in parts if one]
    place = f"{axes[0]}/{key}" if axes and key in NAMES else name
    if key == "channel" and "height" in name.lower():
        place = "height/channel"
    if robot.values.setdefault(place, values) != values or len(robot.values) > MAX_VALUES:
        # Which of two counts depends on the order in which roslaunch sets them.
        raise _refused(f"{name} is {values}, after {place} {robot.values[place]}")

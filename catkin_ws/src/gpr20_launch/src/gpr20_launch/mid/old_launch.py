"""The parameters that a ROS 1 launch file sets, read without ROS and without its packages.

Only what sets parameters is followed: args, groups, nodes, includes and rosparam. What cannot be
found out here is named; nothing is run.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Dict, List, Optional
from xml.etree import ElementTree

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.yaml_file import parse_yaml
from gpr20_common.message import Message
from gpr20_launch.errors import OldElementError, OldLaunchError
from gpr20_launch.mid.launch_texts import BOOLS, FOUND, substituted, typed, unknown

MAX_BYTES = 1 << 20
# Of groups, nodes and includes in each other; files in all; and parameters in all.
MAX_DEPTH, MAX_FILES, MAX_VALUES = 32, 64, 10_000
_PRIVATE_ARGUMENT = re.compile(r"_(\w[\w/]*):=(.*)", re.DOTALL)


@dataclass(frozen=True)
class Unread:
    """An element that could not be read.

    Attributes:
        message: File, element and reason.
        name: Full name of the parameter that it sets, or of its node with a slash behind; empty:
            it may set any; None: none by itself.
    """

    message: Message
    name: Optional[str]


@dataclass
class LaunchParameters:
    """What a launch file sets.

    Attributes:
        values: Value of each parameter, by its full name.
        unread: What could not be found out.
        files: The files that were read.
    """

    values: Dict[str, Any] = field(default_factory=dict)
    unread: List[Unread] = field(default_factory=list)
    files: List[Path] = field(default_factory=list)


@dataclass(frozen=True)
class _Scope:
    """Where an element is.

    Attributes:
        file: The launch file.
        namespace: Before the names of its parameters.
        arguments: Values of its args.
        private: Parameters of the node, or of every node behind.
        is_node: Whether it is inside of a node.
        depth: Number of elements around it.
    """

    file: Path
    namespace: str = "/"
    arguments: Dict[str, str] = field(default_factory=dict)
    private: Dict[str, Any] = field(default_factory=dict)
    is_node: bool = False
    depth: int = 0


def read_launch(path: Path) -> LaunchParameters:
    """Return the parameters that a launch file and those that it includes set.

    Raises:
        OldLaunchError: The file cannot be read, or is no launch file.
    """
    found = LaunchParameters()
    _follow(_root(path, found), _Scope(path), found)
    return found


def _root(path: Path, found: LaunchParameters) -> ElementTree.Element:
    text = _bytes(path, found)
    try:
        root = ElementTree.fromstring(b"" if b"<!ENTITY" in text else text)
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise OldLaunchError(
            Message("{file} is not a launch file", file=path, details=error)
        ) from error
    if root.tag != "launch":
        raise OldLaunchError(Message("{file} is not a launch file", file=path))
    return root


def _bytes(path: Path, found: LaunchParameters) -> bytes:
    found.files.append(path)
    if len(found.files) > MAX_FILES:
        raise OldElementError(Message("there are too many files"))
    try:
        with path.open("rb") as file:
            text = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise OldLaunchError(
            Message("{file}: {reason}", file=path, reason=os_reason(error))
        ) from error
    if len(text) > MAX_BYTES:
        raise OldLaunchError(Message("{file} is not a launch file", file=path))
    return text


def _follow(parent: ElementTree.Element, scope: _Scope, found: LaunchParameters) -> None:
    for element in parent:
        try:
            if scope.depth > MAX_DEPTH:
                raise OldElementError(Message("it is nested too deeply"))
            if _is_used(element, scope):
                _element(element, scope, found)
        except Gpr20Error as error:
            attributes = "".join(f' {key}="{value}"' for key, value in element.attrib.items())
            text = Message(
                "{file}: {element} could not be read: {reason}",
                file=scope.file,
                element=f"<{element.tag}{attributes}>"[:200],
                reason=error.message.with_fault(None),
            )
            found.unread.append(Unread(text, _name_of(element, scope)))


def _name_of(element: ElementTree.Element, scope: _Scope) -> Optional[str]:
    """Return the name of an `Unread`."""
    if element.tag == "arg":
        return None
    try:
        name, below = (_text(element, key, scope) for key in ("name", "ns"))
    except OldElementError:
        return ""
    if element.tag == "param" and name and (scope.is_node or not name.startswith("~")):
        return _join(scope.namespace, name.lstrip("~/" if scope.is_node else ""))
    is_node = element.tag == "node" and name
    return _join(_join(scope.namespace, below), name) + "/" if is_node else ""


def _element(element: ElementTree.Element, scope: _Scope, found: LaunchParameters) -> None:
    names = _join(scope.namespace, _text(element, "ns", scope))
    inner = replace(scope, namespace=names, depth=scope.depth + 1)
    if element.tag == "arg":
        name = element.get("name", "")
        # A value that was passed to an include replaces the default.
        if "value" in element.attrib:
            scope.arguments.pop(name, None)
            scope.arguments[name] = _text(element, "value", scope)
        elif "default" in element.attrib and name not in scope.arguments:
            scope.arguments[name] = _text(element, "default", scope)
    elif element.tag == "group":
        # An arg or a private parameter inside of a group does not exist behind it.
        inner = replace(inner, arguments=dict(scope.arguments), private=dict(scope.private))
        _follow(element, inner, found)
    elif element.tag == "node":
        node = _join(names, _text(element, "name", scope))
        own: Dict[str, Any] = {}
        _follow(element, replace(inner, namespace=node, private=own, is_node=True), found)
        # They replace what its rosparams load, wherever these stand: roslaunch sets them last.
        for name, value in {**scope.private, **own}.items():
            _load(value, _join(node, name), found)
        for word in _text(element, "args", scope).split():
            private = _PRIVATE_ARGUMENT.fullmatch(word)
            if private:
                _load(typed(private.group(2), "yaml"), _join(node, private.group(1)), found)
            elif ":=" not in word:
                raise OldElementError(Message("only its program knows what its args mean"))
    elif element.tag == "param":
        if "value" not in element.attrib:
            raise OldElementError(Message("its value comes from a command or another file"))
        name = _text(element, "name", scope)
        text = re.sub(f"{FOUND}(.*?){FOUND}", r"$(find \1)", _text(element, "value", scope))
        value = typed(text, element.get("type", "auto").lower().strip())
        if scope.is_node or name.startswith("~"):
            scope.private[name.lstrip("~/")] = value
        else:
            _load(value, _join(scope.namespace, name), found)
    elif element.tag == "rosparam" and element.get("command", "load") == "load":
        below = _join(names, _text(element, "param", scope))
        text = element.text or ""
        if "file" in element.attrib:
            text = _bytes(_file(element, scope), found).decode("utf-8", "replace")
        if element.get("subst_value", "false").lower() in ("true", "1") or "$(" in text:
            text = substituted(text, scope.arguments, scope.file)
        _load(parse_yaml(text, odd_numbers=True), below, found)
    elif element.tag == "rosparam" and element.get("command") == "delete":
        raise OldElementError(Message("it deletes parameters"))
    elif element.tag == "include":
        path, used = _file(element, scope), element.findall("arg")
        used = [one for one in used if _is_used(one, scope)]
        given = {one.get("name", ""): _text(one, "value", scope) for one in used}
        passed = dict(scope.arguments) if element.get("pass_all_args") == "true" else {}
        inner = replace(inner, file=path, arguments={**passed, **given})
        # As roslaunch: a file adds to the private parameters around it unless there are none.
        _follow(_root(path, found), replace(inner, private=scope.private or {}), found)


def _is_used(element: ElementTree.Element, scope: _Scope) -> bool:
    for name, wanted in (("if", True), ("unless", False)):
        if name in element.attrib:
            text = _text(element, name, scope).lower()
            if text not in BOOLS:
                raise unknown(f"{name}={text}")
            if BOOLS[text] != wanted:
                return False
    return True


def _text(element: ElementTree.Element, name: str, scope: _Scope) -> str:
    return substituted(element.get(name, ""), scope.arguments, scope.file)


def _file(element: ElementTree.Element, scope: _Scope) -> Path:
    text = _text(element, "file", scope)
    if FOUND not in text:
        return Path(text)
    before, package, rest = text.split(FOUND, 2)
    if before or FOUND in rest:
        raise unknown(element.get("file", ""))
    rest, near = rest.strip("/"), list(scope.file.absolute().parents)[:4]
    inside = [folder for folder in near if folder.name == package]
    inside += [folder / package for folder in near]
    # Also files that were copied without the folders of their package.
    copied = [near[0] / name for name in (rest, Path(rest).name) if name]
    for path in (*(folder / rest for folder in inside), *copied):
        if path.is_file():
            return path
    raise unknown(f"$(find {package})/{rest}")


def _load(values: Any, below: str, found: LaunchParameters) -> None:
    if len(found.values) > MAX_VALUES:
        raise OldElementError(Message("it sets too many parameters"))
    if isinstance(values, dict):
        for name, value in values.items():
            _load(value, _join(below, str(name)), found)
    else:
        found.values[below] = values


def _join(namespace: str, name: Optional[str]) -> str:
    if not name:
        return namespace
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"

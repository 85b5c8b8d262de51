"""The parameters that a ROS 1 launch file sets, read without ROS and without its packages.

Only what sets parameters is followed: args, groups, nodes, includes and rosparam.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Dict, List, Optional
from xml.etree import ElementTree

import yaml

from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_launch.errors import OldLaunchError

MAX_BYTES = 1 << 20
# Of groups, nodes and includes in each other, and files in all.
MAX_DEPTH, MAX_FILES = 32, 64
_SUBSTITUTION = re.compile(r"\$\(\s*(\w+)\s+([^()]*?)\s*\)")


class _Unresolved(ValueError):
    """A substitution needs the computer of the original."""


@dataclass
class LaunchParameters:
    """What a launch file sets.

    Attributes:
        values: Value of each parameter, by its full name.
        unresolved: What could not be found out: the element, and why.
        files: How many files were read.
    """

    values: Dict[str, Any] = field(default_factory=dict)
    unresolved: List[str] = field(default_factory=list)
    files: int = 0


@dataclass(frozen=True)
class _Scope:
    """Where an element is.

    Attributes:
        file: The launch file.
        namespace: Before the names of its parameters.
        arguments: Values of its args.
        depth: Number of elements around it.
    """

    file: Path
    namespace: str = "/"
    arguments: Dict[str, str] = field(default_factory=dict)
    depth: int = 0


def read_launch(path: Path) -> LaunchParameters:
    """Return the parameters that a launch file and those that it includes set.

    Raises:
        OldLaunchError: The file cannot be read, or is no launch file.
    """
    found = LaunchParameters()
    _follow(_root(path), _Scope(path), found)
    return found


def _root(path: Path) -> ElementTree.Element:
    try:
        with path.open("rb") as file:
            text = file.read(MAX_BYTES + 1)
        if len(text) > MAX_BYTES or b"<!ENTITY" in text:
            raise OldLaunchError(Message("{file} is not a launch file", file=path))
        root = ElementTree.fromstring(text)
    except OSError as error:
        raise OldLaunchError(
            Message("{file}: {reason}", file=path, reason=os_reason(error))
        ) from error
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        if isinstance(error, OldLaunchError):
            raise
        raise OldLaunchError(
            Message("{file} is not a launch file", file=path, details=error)
        ) from error
    if root.tag != "launch":
        raise OldLaunchError(Message("{file} is not a launch file", file=path))
    return root


def _follow(parent: ElementTree.Element, scope: _Scope, found: LaunchParameters) -> None:
    for element in parent:
        try:
            if scope.depth > MAX_DEPTH:
                raise _Unresolved("it is nested too deeply")
            if not _is_used(element, scope):
                continue
            _element(element, scope, found)
        except (_Unresolved, yaml.YAMLError, YamlFileError, OldLaunchError, OSError) as error:
            name = element.get("name") or element.get("file") or ""
            found.unresolved.append(f"<{element.tag} {name}>: {error}")


def _element(element: ElementTree.Element, scope: _Scope, found: LaunchParameters) -> None:
    names = _join(scope.namespace, _text(element, "ns", scope))
    inner = replace(scope, namespace=names, depth=scope.depth + 1)
    if element.tag == "arg":
        name = element.get("name", "")
        value = "value" if "value" in element.attrib else "default"
        # A value that was passed to an include replaces the default.
        if value in element.attrib and (value == "value" or name not in scope.arguments):
            scope.arguments[name] = _text(element, value, scope)
    elif element.tag == "group":
        # An arg inside of a group does not exist behind it.
        _follow(element, replace(inner, arguments=dict(scope.arguments)), found)
    elif element.tag == "node":
        node = _join(names, _text(element, "name", scope))
        _follow(element, replace(inner, namespace=node), found)
    elif element.tag == "param":
        if "value" not in element.attrib:
            raise _Unresolved("it has no value")
        name = _join(scope.namespace, _text(element, "name", scope).lstrip("~"))
        text = _text(element, "value", scope)
        found.values[name] = text if element.get("type") in ("str", "string") else _plain(text)
    elif element.tag == "rosparam" and element.get("command", "load") == "load":
        below = _join(names, _text(element, "param", scope))
        if "file" in element.attrib:
            _load(read_yaml(_file(element, scope)), below, found)
        else:
            _load(yaml.safe_load(_substituted(element.text or "", scope)), below, found)
    elif element.tag == "include":
        found.files += 1
        if found.files > MAX_FILES:
            raise _Unresolved("there are too many files")
        path = _file(element, scope)
        given = {one.get("name", ""): _text(one, "value", scope) for one in element.findall("arg")}
        passed = dict(scope.arguments) if element.get("pass_all_args") == "true" else {}
        _follow(_root(path), replace(inner, file=path, arguments={**passed, **given}), found)


def _is_used(element: ElementTree.Element, scope: _Scope) -> bool:
    for name, wanted in (("if", True), ("unless", False)):
        if name in element.attrib:
            text = _text(element, name, scope).lower()
            if text not in ("true", "false", "1", "0"):
                raise _Unresolved(f"{name}={text}")
            if (text in ("true", "1")) != wanted:
                return False
    return True


def _text(element: ElementTree.Element, name: str, scope: _Scope) -> str:
    return _substituted(element.get(name, ""), scope)


def _substituted(text: str, scope: _Scope) -> str:
    def value(match: re.Match[str]) -> str:
        kind, rest = match.group(1), match.group(2)
        if kind == "arg" and rest in scope.arguments:
            return scope.arguments[rest]
        if kind == "optenv":
            return rest.partition(" ")[2].strip()
        if kind == "find":
            return f"{FOUND}{rest}"
        if kind == "anon":
            return rest
        raise _Unresolved(match.group(0))

    result = _SUBSTITUTION.sub(value, text)
    if "$(" in result:
        raise _Unresolved(result)
    return result


# Stands for the folder of a package, which is looked for beside the file that names it.
FOUND = "\0"


def _file(element: ElementTree.Element, scope: _Scope) -> Path:
    text = _text(element, "file", scope)
    if not text.startswith(FOUND):
        return Path(text)
    package, _slash, rest = text[len(FOUND) :].partition("/")
    near = list(scope.file.absolute().parents)[:4]
    for folder in near:
        for path in (folder / rest, folder / package / rest, folder / Path(rest).name):
            if path.is_file():
                return path
    raise _Unresolved(f"$(find {package})/{rest}")


def _load(values: Any, below: str, found: LaunchParameters) -> None:
    if isinstance(values, dict):
        for name, value in values.items():
            _load(value, _join(below, str(name)), found)
    elif values is not None:
        found.values[below] = values


def _join(namespace: str, name: Optional[str]) -> str:
    if not name:
        return namespace
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def _plain(text: str) -> Any:
    """Return a value as roslaunch understands it without a type."""
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        pass
    return {"true": True, "false": False}.get(text.lower(), text)

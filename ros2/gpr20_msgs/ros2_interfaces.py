#!/usr/bin/env python3
"""Write the interfaces of ROS 1 as those of ROS 2.

    ros2_interfaces.py ROS1_PACKAGE FOLDER

Writes msg/*.msg, srv/*.srv and action/*.action below the folder and prints their names. Comments
stay. Of an action its messages are written too, as actionlib makes them: recordings hold those.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Dict, List

SEPARATOR = "---"
TYPES = {
    "time": "builtin_interfaces/Time",
    "duration": "builtin_interfaces/Duration",
    "Header": "std_msgs/Header",
    "byte": "int8",
    "char": "uint8",
}
# Words of C++, which its code for ROS 2 cannot have as names. The bytes of a message stay the same.
RENAMED = {"operator": "operator_name"}
# By the rules of ROS 2; a constant has a value.
FIELD = re.compile(r"^(?P<type>[\w/]+)(?P<array>\[\d*\])?\s+(?P<name>[a-z](_?[a-z0-9])*)\s*$")
CONSTANT = re.compile(r"^(?P<type>[\w/]+)\s+(?P<name>[A-Z](_?[A-Z0-9])*)\s*=\s*\S.*$")
# What actionlib adds to the goal, the result and the feedback.
ADDED = {"Goal": "GoalID goal_id", "Result": "GoalStatus status", "Feedback": "GoalStatus status"}


class InterfaceError(ValueError):
    """A definition cannot be one of ROS 2."""


def ros2_line(line: str) -> str:
    """Return a line of a definition in the form of ROS 2.

    Raises:
        InterfaceError: Its name is not allowed there.
    """
    code, hash_sign, comment = line.partition("#")
    if code.strip() in ("", SEPARATOR):
        return line
    found = FIELD.match(code) or CONSTANT.match(code)
    if found is None:
        raise InterfaceError(
            f"'{line}' is no field or constant of ROS 2; a field is such as 'float64 height_m', "
            "in lower case, a constant such as 'int32 IDLE=0'"
        )
    kind, name = found["type"], found["name"]
    before, behind = code[len(kind) : found.start("name")], code[found.end("name") :]
    return f"{TYPES.get(kind, kind)}{before}{RENAMED.get(name, name)}{behind}{hash_sign}{comment}"


def ros2_text(text: str) -> str:
    """Return a whole definition in the form of ROS 2."""
    return "".join(f"{ros2_line(line)}\n" for line in text.splitlines())


def messages_of_action(name: str, text: str) -> Dict[str, str]:
    """Return the messages that actionlib makes of an action, in the form of ROS 2, by name."""
    parts: List[str] = [""]
    for line in ros2_text(text).splitlines():
        if line.strip() == SEPARATOR:
            parts.append("")
        else:
            parts[-1] += f"{line}\n"
    messages = {}
    for (part, added), content in zip(ADDED.items(), parts):
        messages[f"{name}{part}"] = content
        messages[f"{name}Action{part}"] = (
            f"std_msgs/Header header\nactionlib_msgs/{added}\n{name}{part} {part.lower()}\n"
        )
    return messages


def interfaces(package: Path) -> Dict[str, str]:
    """Return the definitions for ROS 2 of a package of ROS 1, by the names of their files.

    Raises:
        InterfaceError: One cannot be written for ROS 2.
        OSError: They cannot be read.
    """
    found = {}
    for path in sorted(package.glob("*/*.*")):
        kind = path.parent.name
        if path.suffix != f".{kind}" or kind not in ("msg", "srv", "action"):
            continue
        text = path.read_text(encoding="utf-8")
        try:
            found[f"{kind}/{path.name}"] = ros2_text(text)
        except InterfaceError as error:
            raise InterfaceError(f"{path}: {error}") from error
        if kind == "action":
            for name, content in messages_of_action(path.stem, text).items():
                found[f"msg/{name}.msg"] = content
    if not found:
        raise InterfaceError(f"{package} has no msg/*.msg, srv/*.srv or action/*.action")
    return found


def main() -> int:
    """Write them; return the exit status."""
    if len(sys.argv) != 3:
        print(f"usage: {Path(sys.argv[0]).name} ROS1_PACKAGE FOLDER", file=sys.stderr)
        return 2
    package, folder = map(Path, sys.argv[1:])
    try:
        found = interfaces(package)
        for name, text in found.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            # A file that has not changed keeps its time, so that nothing is built again for it.
            if not path.is_file() or path.read_text(encoding="utf-8") != text:
                path.write_text(text, encoding="utf-8")
    except (InterfaceError, OSError) as error:
        print(f"{Path(sys.argv[0]).name}: {error}", file=sys.stderr)
        return 1
    print("\n".join(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())

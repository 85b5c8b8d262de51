"""The templates of the sentences that errors of the robot's nodes carry, found in the sources."""

from __future__ import annotations

import ast
import string
from pathlib import Path
from typing import Iterator, List, Set

from gpr20_common.message import Message

SOURCES = Path(__file__).resolve().parents[1] / "catkin_ws/src"
PACKAGES = (
    "gpr20_main_control",
    "gpr20_axis_driver",
    "gpr20_height_sensor",
    "gpr20_vna_acquisition",
    "gpr20_vna_processing",
    "gpr20_survey",
    "gpr20_common",
)


def fault_templates() -> List[str]:
    """Return the templates, in alphabetical order."""
    found: Set[str] = set()
    for package in PACKAGES:
        for path in sorted((SOURCES / package / "src").rglob("*.py")):
            found.update(_templates_of_errors(ast.parse(path.read_text("utf-8"))))
    # A name of a value is no sentence.
    return sorted(one for one in found if " is " in one or one.split(" [")[0].count(" ") > 2)


def filled(template: str) -> Message:
    """Return a message with values that are only placeholders."""
    values = {
        name: 1 if spec and spec[-1] in "dfge" else "x"
        for _, name, spec, _ in string.Formatter().parse(template)
        if name
    }
    return Message(template, **values)


def _templates_of_errors(tree: ast.AST) -> Iterator[str]:
    for call in ast.walk(tree):
        if not _called(call).endswith("Error"):
            continue
        for message in ast.walk(call):
            if isinstance(message, ast.Call) and _called(message) == "Message":
                template = message.args[0]
                if isinstance(template, ast.Constant):
                    yield str(template.value)


def _called(node: ast.AST) -> str:
    if not isinstance(node, ast.Call):
        return ""
    return str(getattr(node.func, "id", getattr(node.func, "attr", "")))

"""Commented templates of the configuration's files, made from the classes of the parameters."""

from __future__ import annotations

import dataclasses
import inspect
import json
import math
import re
import textwrap
import typing
from pathlib import Path
from typing import Any, Dict, List, Type

import yaml

from gpr20_common.low.yaml_file import read_yaml
from gpr20_common.mid.codec import plain
from gpr20_launch.mid.robot_files import AXES_FILE, FILES, RobotFile
from gpr20_survey.axes.axis_parameters import AxisParameters

WIDTH = 98
HEAD = 'A key that is commented out has the default shown; remove its "#" to change it.'
# One attribute of a Google-style docstring: its name, and its text over several lines.
_ATTRIBUTE = re.compile(r"^    (\w+): (.*(?:\n        .*)*)", re.MULTILINE)


def templates(built_axes: Path) -> Dict[str, str]:
    """Return the text of each file, by its name."""
    texts = {name: _template(name, file) for name, file in FILES.items()}
    texts[AXES_FILE] = _axes_template(built_axes)
    return texts


def _template(name: str, file: RobotFile) -> str:
    lines = [f"# {name}: {file.title}.", f"# {HEAD}"]
    for _section, kind in file.sections:
        for field in dataclasses.fields(kind):
            lines += ["", *_comment(kind, field.name), *_group_comments(kind, field.name)]
            lines.append(_commented(field.name, _default(field)))
    return "\n".join(lines) + "\n"


def _axes_template(built_axes: Path) -> str:
    lines = [f"# {AXES_FILE}: the three axes of this robot.", f"# {HEAD}", "#"]
    lines.append("# Each axis has these keys; lengths are in mm (x, y) or degrees (z).")
    for field in dataclasses.fields(AxisParameters):
        lines += _comment(AxisParameters, field.name, f"{field.name}: ")
    built = read_yaml(built_axes)
    optional = {
        field.name: _default(field)
        for field in dataclasses.fields(AxisParameters)
        if _has_default(field)
    }
    for axis, values in built.items():
        lines += ["", f"{axis}:"]
        keys = {**values, **{key: optional[key] for key in optional if key not in values}}
        lines += [f"  {_commented(key, value)}" for key, value in keys.items()]
    return "\n".join(lines) + "\n"


def _comment(kind: Type, name: str, before: str = "") -> List[str]:
    text = before + _attributes(kind).get(name, name)
    return [f"# {line}" for line in textwrap.wrap(text, WIDTH - 2)]


def _group_comments(kind: Type, name: str) -> List[str]:
    """Return a comment for each key of the groups of a list; none for any other value."""
    item = (*typing.get_args(typing.get_type_hints(kind)[name]), None)[0]
    if not (isinstance(item, type) and dataclasses.is_dataclass(item)):
        return []
    lines: List[str] = []
    for field in dataclasses.fields(item):
        default = ""
        if field.default is not dataclasses.MISSING:
            default = f" Default: {json.dumps(_default(field))}."
        text = f"- {field.name}: {_attributes(item).get(field.name, field.name)}{default}"
        lines += textwrap.wrap(text, WIDTH - 2, subsequent_indent="  ")
    return [f"# {line}" for line in lines]


def _attributes(kind: Type) -> Dict[str, str]:
    document = inspect.getdoc(kind) or ""
    _before, _found, attributes = document.partition("Attributes:\n")
    return {name: " ".join(text.split()) for name, text in _ATTRIBUTE.findall(attributes)}


def _commented(name: str, value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, width=math.inf, allow_unicode=True)
    return f"#{name}: {text.splitlines()[0]}"  # a plain value is followed by a line of dots


def _has_default(field: dataclasses.Field) -> bool:
    missing = dataclasses.MISSING
    return field.default is not missing or field.default_factory is not missing


def _default(field: dataclasses.Field) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return plain(field.default)

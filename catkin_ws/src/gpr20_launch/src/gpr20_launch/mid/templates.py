"""Commented templates of the configuration's files, made from the classes of the parameters."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
import textwrap
import typing
from typing import Any, Dict, List, Mapping, Type

import yaml

from gpr20_common.mid.codec import plain
from gpr20_launch.mid.robot_files import AXES_FILE, FILES
from gpr20_survey.axes.axis_parameters import AxisParameters

WIDTH = 98
HEAD = 'A key that is commented out has the default shown; remove its "#" to change it.'
# One attribute of a Google-style docstring: its name, and its text over several lines.
_ATTRIBUTE = re.compile(r"^    (\w+): (.*(?:\n        .*)*)", re.MULTILINE)


def templates(built: Mapping[str, Mapping[str, Any]]) -> Dict[str, str]:
    """Return the text of each file, by its name, for a robot with the axes as it is built."""
    texts = {}
    for name, sections in FILES.items():
        lines = [f"# {name}", f"# {HEAD}"]
        for kind in sections.values():
            lines += ["#", f"# {_text(kind).splitlines()[0]}"]
            for field in dataclasses.fields(kind):
                lines += ["", *_comment(kind, field, f"{field.name}: ")]
                lines.append(_commented(field.name, _default(field)))
        texts[name] = "\n".join([*lines, ""])
    lines = [f"# {AXES_FILE}: the three axes of this robot.", f"# {HEAD}", "#"]
    lines.append("# Each axis has these keys; lengths are in mm (x, y) or degrees (z).")
    known = dataclasses.fields(AxisParameters)
    for field in known:
        lines += _comment(AxisParameters, field, f"{field.name}: ")
    optional = {one.name: _default(one) for one in known if _has_default(one)}
    for axis, values in built.items():
        lines += ["", f"{axis}:"]
        lines += [f"  {_commented(key, value)}" for key, value in {**optional, **values}.items()]
    texts[AXES_FILE] = "\n".join([*lines, ""])
    return texts


def _comment(kind: Type, field: dataclasses.Field, before: str) -> List[str]:
    """Return what the class says of a field, and of each key of the groups that it lists."""
    text = _text(kind).partition("Attributes:\n")[2]
    said = {name: " ".join(words.split()) for name, words in _ATTRIBUTE.findall(text)}
    words = before + said.get(field.name, "")
    if before[0] == "-" and _has_default(field):
        words += f" Default: {plain(_default(field))}."
    lines = [f"# {line}" for line in textwrap.wrap(words, WIDTH - 2)]
    item = (*typing.get_args(typing.get_type_hints(kind)[field.name]), None)[0]
    if isinstance(item, type) and dataclasses.is_dataclass(item):
        for one in dataclasses.fields(item):
            lines += _comment(item, one, f"- {one.name}: ")
    return lines


def _text(kind: Type) -> str:
    return inspect.getdoc(kind) or ""


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

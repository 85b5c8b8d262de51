"""Templates of the configuration's files: what the classes of the parameters say, and defaults."""

from __future__ import annotations

import dataclasses
import inspect
import math
import typing
from typing import Any, Dict, Iterator, List, Mapping, Type

import yaml

from gpr20_common.mid.codec import plain
from gpr20_launch.mid.robot_files import AXES_FILE, FILES
from gpr20_survey.axes.axis_parameters import AxisParameters

HEAD = 'A key that is commented out has the default shown; remove its "#" to change it.'


def templates(built: Mapping[str, Mapping[str, Any]]) -> Dict[str, str]:
    """Return the text of each file, by its name, for a robot with the axes as it is built."""
    texts = {}
    for name, sections in FILES.items():
        lines = [f"# {name}. {HEAD}"]
        for kind in sections.values():
            lines += [*_said_by(kind), *_commented(_defaults(kind))]
        texts[name] = "\n".join([*lines, ""])
    lines = [f"# {AXES_FILE}. {HEAD}", *_said_by(AxisParameters)]
    for axis, values in built.items():
        known = {**values, **_defaults(AxisParameters), **values}
        lines += ["", f"{axis}:", *(f"  {line}" for line in _commented(known))]
    texts[AXES_FILE] = "\n".join([*lines, ""])
    return texts


def _said_by(kind: Type) -> List[str]:
    """Return what a class, and those of the groups in its lists, say of themselves."""
    items = [typing.get_args(one)[:1] for one in typing.get_type_hints(kind).values()]
    groups = [one for (one,) in filter(None, items) if dataclasses.is_dataclass(one)]
    text = "\n\n".join(inspect.getdoc(one) or "" for one in (kind, *groups))
    lines = text.replace("Attributes:", "Keys:").splitlines()
    return ["#", *(f"# {line}".rstrip() for line in lines), ""]


def _commented(values: Mapping[str, Any]) -> Iterator[str]:
    for name, value in values.items():
        text = yaml.safe_dump(value, default_flow_style=True, width=math.inf, allow_unicode=True)
        yield f"#{name}: {text.splitlines()[0]}"  # a plain value is followed by a line of dots


def _defaults(kind: Type) -> Dict[str, Any]:
    known, missing = {}, dataclasses.MISSING
    for one in dataclasses.fields(kind):
        if one.default_factory is not missing:
            known[one.name] = one.default_factory()
        elif one.default is not missing:
            known[one.name] = plain(one.default)
    return known

"""Parameters from the ROS parameter server, checked against a dataclass."""

from __future__ import annotations

import dataclasses
import typing
from typing import Any, Collection, Type, TypeVar

import rospy

from gpr20_common.mid.errors import InvalidValueError

Record = TypeVar("Record")


def read_parameters(
    record_class: Type[Record], namespace: str = "~", others: Collection[str] = ()
) -> Record:
    """Read every field of a dataclass from the parameters below a namespace.

    A field without a default must be there. A dataclass that checks its own values does
    so in `__post_init__`; its error names the parameter.

    Args:
        record_class: Dataclass whose fields are named like the parameters.
        namespace: Where the parameters are; "~" is the node's own namespace.
        others: Further parameters that may stand there, read by someone else.

    Raises:
        InvalidValueError: A parameter is missing, unknown or of the wrong type.
    """
    place = rospy.resolve_name(namespace.rstrip("/") or "/")
    values = rospy.get_param(place, {})
    if not isinstance(values, dict):
        raise InvalidValueError(f"{place} must be a group of parameters, but is {values!r}")
    return record_from_values(record_class, values, place, others)


def record_from_values(
    record_class: Type[Record], values: Any, place: str, others: Collection[str] = ()
) -> Record:
    """Make a dataclass from a dictionary, naming whatever does not fit.

    Raises:
        InvalidValueError: A value is missing, unknown or of the wrong type.
    """
    fields = {field.name: field for field in dataclasses.fields(record_class) if field.init}  # type: ignore[arg-type]
    unknown = sorted(set(values) - set(fields) - set(others))
    if unknown:
        raise InvalidValueError(
            f"unknown parameter {place}/{unknown[0]}; known are {', '.join(sorted(fields))}"
        )
    hints = typing.get_type_hints(record_class)
    arguments = {}
    for name, field in fields.items():
        if name in values:
            arguments[name] = _converted(f"{place}/{name}", values[name], hints[name])
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise InvalidValueError(f"parameter {place}/{name} is missing")
    return record_class(**arguments)


def _converted(name: str, value: Any, hint: Any) -> Any:
    if typing.get_origin(hint) is typing.Union:  # Optional[...]
        hint = next(one for one in typing.get_args(hint) if one is not type(None))
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    origin = typing.get_origin(hint)
    if origin is tuple and isinstance(value, (list, tuple)):
        item_hint = typing.get_args(hint)[0]
        return tuple(_converted(f"{name}[{i}]", item, item_hint) for i, item in enumerate(value))
    expected = origin or hint
    if not isinstance(value, expected) or (isinstance(value, bool) and expected is not bool):
        raise InvalidValueError(
            f"parameter {name} is {value!r}; it must be of type {expected.__name__}"
        )
    return value

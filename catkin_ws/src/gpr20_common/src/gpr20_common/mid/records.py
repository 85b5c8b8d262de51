"""Frozen dataclasses from a file or the parameter server, naming whatever does not fit."""

from __future__ import annotations

import dataclasses
import enum
import functools
import math
import typing
from typing import Any, Mapping, Optional, Type, TypeVar

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between

Record = TypeVar("Record")
UNBOUNDED = (-math.inf, math.inf)


def bounded(lower: float, upper: float, default: Any = dataclasses.MISSING) -> Any:
    """Declare a number of a record with the bounds it must lie within, both included."""
    return dataclasses.field(default=default, metadata={"bounds": (lower, upper)})


def record_from(
    record_class: Type[Record], values: Any, place: str, base: Optional[Record] = None
) -> Record:
    """Make a record from a mapping; nested records, tuples and enums are followed.

    Args:
        record_class: Dataclass; its fields are the names allowed. A field without a
            default must be there.
        values: What was found.
        place: Where it was found, for the messages; empty if they name the place themselves.
        base: Where the values that are left out come from, instead of the defaults.

    Raises:
        InvalidValueError: A name is unknown or missing, or a value has the wrong type or is
            out of bounds.
    """
    if not isinstance(values, Mapping):
        raise InvalidValueError(
            Message(
                "{place} is {value}; it must be a group of values", place=place, value=repr(values)
            ),
            fault=CONFIGURATION,
        )
    fields = {one.name: one for one in dataclasses.fields(record_class)}  # type: ignore[arg-type]
    for name in values:
        if name not in fields:
            known = ", ".join(sorted(fields))
            raise InvalidValueError(
                Message(
                    "{place} is unknown; allowed: {known}", place=_below(place, name), known=known
                ),
                fault=CONFIGURATION,
            )
    hints = _type_hints(record_class)  # type: ignore[arg-type]
    arguments = {}
    for name, field in fields.items():
        if name in values:
            arguments[name] = _value(_below(place, name), values[name], hints[name], field)
        elif base is not None:
            arguments[name] = getattr(base, name)
        elif _is_required(field):
            raise InvalidValueError(
                Message("{place} is missing", place=_below(place, name)), fault=CONFIGURATION
            )
    return record_class(**arguments)


@functools.lru_cache(maxsize=None)
def _type_hints(record_class: type) -> Mapping[str, Any]:
    # Python evaluates the text of every annotation again, for a millisecond.
    return typing.get_type_hints(record_class)


def _below(place: str, name: Any) -> str:
    return f"{place}/{name}" if place else str(name)


def _is_required(field: dataclasses.Field) -> bool:
    return field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING


def _default(field: dataclasses.Field) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _value(place: str, value: Any, hint: Any, field: dataclasses.Field) -> Any:
    if dataclasses.is_dataclass(hint):
        base = None if _is_required(field) else _default(field)
        return record_from(typing.cast(type, hint), value, place, base)
    if typing.get_origin(hint) is typing.Union:  # Optional[...]
        if value is None:
            return None
        hint = next(one for one in typing.get_args(hint) if one is not type(None))
    if typing.get_origin(hint) is tuple:
        return _items(place, value, typing.get_args(hint)[0], field)
    if typing.get_origin(hint) is dict:
        # The values belong to a class that this software does not know.
        hint = dict
    if isinstance(hint, type) and issubclass(hint, enum.Enum):
        return _member(place, value, hint)
    if hint in (int, float):
        return _number(place, value, hint, field.metadata.get("bounds", UNBOUNDED))
    if not isinstance(value, hint):
        raise InvalidValueError(
            Message(
                "{place} is {value}; it must be of type {type}",
                place=place,
                value=repr(value),
                type=hint.__name__,
            )
        )
    return value


def _items(place: str, values: Any, hint: Any, field: dataclasses.Field) -> Any:
    if not isinstance(values, (list, tuple)):
        raise InvalidValueError(
            Message("{place} is {value}; it must be a list", place=place, value=repr(values)),
            fault=CONFIGURATION,
        )
    if dataclasses.is_dataclass(hint):
        item_class = typing.cast(type, hint)
        return tuple(record_from(item_class, one, f"{place}[{i}]") for i, one in enumerate(values))
    return tuple(_value(f"{place}[{i}]", one, hint, field) for i, one in enumerate(values))


def _member(place: str, value: Any, enum_class: Type[enum.Enum]) -> enum.Enum:
    for member in enum_class:
        if member.value == value:
            return member
    allowed = ", ".join(str(member.value) for member in enum_class)
    raise InvalidValueError(
        Message(
            "{place} is {value}; it must be one of {allowed}",
            place=place,
            value=repr(value),
            allowed=allowed,
        )
    )


def _number(place: str, value: Any, kind: type, bounds: typing.Tuple[float, float]) -> Any:
    # YAML's true is an int in Python; a switch where a number belongs is a mistake.
    accepted = (int,) if kind is int else (int, float)
    if isinstance(value, bool) or not isinstance(value, accepted):
        raise InvalidValueError(
            Message(
                "{place} is {value}; it must be a number of type {type}",
                place=place,
                value=repr(value),
                type=kind.__name__,
            )
        )
    try:
        number = kind(value)
    except OverflowError:
        raise InvalidValueError(
            Message("{place} has too many digits for a number of type float", place=place)
        ) from None
    if bounds is not UNBOUNDED:
        number_between(place, value, *bounds)
    return number

"""What the values of a trace are: as bytes of a ROS 1 message, as JSON, and back.

ROS 1 serialization: http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes;
little endian, the fields one after the other, strings and arrays behind their length as uint32.
"""

from __future__ import annotations

import dataclasses
import math
import struct
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Tuple, Type

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace_rule import Rule, refuse, refuse_value, shortened

UINT = struct.Struct("<I")
_INT, _NUMBER, _TIME = struct.Struct("<i"), struct.Struct("<d"), struct.Struct("<II")
TIME_ENDING = "_us"


class Reader:
    """Takes the values of a message one after the other.

    Every method raises struct.error or UnicodeDecodeError if the message is not whole.
    """

    def __init__(self, data: bytes) -> None:
        self._data, self._place = data, 0

    @property
    def left(self) -> int:
        """How many bytes are left."""
        return len(self._data) - self._place

    def one(self, form: struct.Struct) -> Any:
        """Return a value of a fixed size."""
        (value,) = form.unpack_from(self._data, self._place)
        self._place += form.size
        return value

    def number(self) -> float:
        """Return a float64; there is one NaN only, so that equal traces are equal in every form."""
        value: float = self.one(_NUMBER)
        return value if value == value else math.nan

    def text(self) -> str:
        """Return a string."""
        return self._bytes(self.one(UINT)).decode()

    def numbers(self) -> np.ndarray:
        """Return an array of float64."""
        # A copy: a view would keep the whole message, or a mapped file, in memory.
        return np.frombuffer(self._bytes(8 * self.one(UINT)), "<f8").astype(np.float64)

    def time_us(self) -> int:
        """Return a time [us since 1970]."""
        seconds, rest_ns = _TIME.unpack_from(self._data, self._place)
        self._place += _TIME.size
        return int(seconds * utc_time.US_PER_S + rest_ns // utc_time.NS_PER_US)

    def _bytes(self, size: int) -> bytes:
        data = self._data[self._place : self._place + size]
        if len(data) != size:
            raise struct.error(f"{size} bytes are due at byte {self._place}")
        self._place += size
        return data


@dataclass(frozen=True)
class Form:
    """One type of values.

    Attributes:
        ros: Its name in the definition of a message.
        pack: Returns the bytes of a value in a message.
        unpack: Takes a value from a message.
        as_json: Returns a value for JSON.
        from_json: Returns the value of a JSON value; the text is its place, for the message of the
            TraceRefusedError that it raises.
        parts: The fields of each value, if it is a message of its own.
    """

    ros: str
    pack: Callable[[Any], bytes]
    unpack: Callable[[Reader], Any]
    as_json: Callable[[Any], Any]
    from_json: Callable[[Any, str], Any]
    parts: Tuple[TraceField, ...] = ()


@dataclass(frozen=True)
class TraceField:
    """One field of a trace: a line of the table from which all its forms come.

    Attributes:
        name: Its name in message, JSON and Dataset.
        attribute: Its name in this software.
        form: Type of its values.
        meaning: What it is.
        unit: Its unit; empty if there is none.
        unknown: The value that says that it is not known, null in JSON; None: it is always known.
        rule: What a value must be that is known.
    """

    name: str
    attribute: str
    form: Form
    meaning: str
    unit: str
    unknown: Any
    rule: Optional[Rule]

    @classmethod
    def of(cls, attribute: str, declared: Mapping[str, Any]) -> TraceField:
        """Return the field that is declared with `of`."""
        is_time = attribute.endswith(TIME_ENDING)
        return cls(attribute[: -len(TIME_ENDING)] if is_time else attribute, attribute, **declared)

    def is_unknown(self, value: Any) -> bool:
        """Return whether a value says that it is not known."""
        return self.unknown is not None and (value == self.unknown or self.is_nan(value))

    def is_nan(self, value: Any) -> bool:
        """Return whether a value is the NaN that says that it is not known."""
        return bool(value != value and self.unknown != self.unknown)


def of(
    form: Form, meaning: str, unit: str = "", unknown: Any = None, rule: Optional[Rule] = None
) -> Dict[str, Any]:
    """Return the metadata of a field of a dataclass that is a field of a trace."""
    return {"form": form, "meaning": meaning, "unit": unit, "unknown": unknown, "rule": rule}


def fields_of(kind: Type[Any]) -> Dict[str, TraceField]:
    """Return the fields that a dataclass declares with `of`, by their attributes."""
    return {
        one.name: TraceField.of(one.name, one.metadata)
        for one in dataclasses.fields(kind)
        if one.metadata
    }


def as_json(fields: Iterable[TraceField], values: Mapping[str, Any]) -> Dict[str, Any]:
    """Return a JSON object of values, which are given by their attributes."""
    return {
        one.name: None
        if one.is_unknown(values[one.attribute])
        else one.form.as_json(values[one.attribute])
        for one in fields
    }


def from_json(fields: Iterable[TraceField], found: Any, place: str = "") -> Dict[str, Any]:
    """Return the values of a JSON object by their attributes.

    Args:
        fields: Exactly these must be there.
        found: The object.
        place: Where it is, for messages: such as `aux[2].`.

    Raises:
        TraceRefusedError: It is another value; the message names the place.
    """
    if type(found) is not dict:
        refuse_value(place.rstrip(".") or "the content", found, Message("an object"))
    names = {one.name for one in fields}
    for name in sorted(names ^ found.keys()) if names != found.keys() else ():
        key = shortened(f"{place}{name}")
        if name in names:
            refuse(Message("the entry {key} is missing", key=key))
        refuse(Message("the entry {key} is no entry of a trace", key=key))
    return {one.attribute: _value(one, found[one.name], f"{place}{one.name}") for one in fields}


def _value(field: TraceField, found: Any, place: str) -> Any:
    if found is None and field.unknown is not None:
        return field.unknown
    value = field.form.from_json(found, place)
    if field.unknown is not None and field.is_unknown(value):
        # One trace has one form.
        refuse_value(place, found, Message("null if it is not known"))
    return value


def check(fields: Iterable[TraceField], values: Mapping[str, Any], place: str = "") -> None:
    """Refuse values, given by their attributes, that break the rules of their fields.

    Raises:
        TraceRefusedError: One does; the message names it.
    """
    for one in fields:
        value, rule = values[one.attribute], one.rule
        if rule is not None and not rule.holds(value) and not one.is_nan(value):
            refuse_value(f"{place}{one.name}", one.form.as_json(value), rule.allowed, rule.fault)
        for part in value if one.form.parts else ():
            own = vars(part)
            first = str(own[one.form.parts[0].attribute])
            check(one.form.parts, own, f"{place}{one.name}[{first}].")


def _exactly(kind: type, allowed: Message) -> Callable[[Any, str], Any]:
    def checked(value: Any, place: str) -> Any:
        # Exactly: true is an int to Python, and a float is always written with a point.
        return value if type(value) is kind else refuse_value(place, value, allowed)

    return checked


def _list(value: Any, place: str, count: Optional[int] = None) -> List[Any]:
    if type(value) is not list:
        refuse_value(place, value, Message("a list"))
    if count not in (None, len(value)):
        refuse_value(place, value, Message("a list of {count} values", count=count))
    return value


def pack_text(text: str) -> bytes:
    """Return a string."""
    data = text.encode()
    return UINT.pack(len(data)) + data


def pack_time(time_us: int) -> bytes:
    """Return a time [us since 1970]."""
    seconds, rest_us = divmod(time_us, utc_time.US_PER_S)
    return _TIME.pack(seconds, rest_us * utc_time.NS_PER_US)


def _time_from_json(value: Any, place: str) -> int:
    try:
        return utc_time.parse_iso(value if type(value) is str else "")
    except InvalidValueError:
        example = utc_time.iso_text(utc_time.EARLIEST_US)
        refuse_value(place, value, Message("a time such as {example}", example=example))


def _pack_numbers(values: np.ndarray) -> bytes:
    return UINT.pack(len(values)) + values.astype("<f8", copy=False).tobytes()


def _numbers_from_json(value: Any, place: str) -> np.ndarray:
    if set(map(type, _list(value, place))) - {float}:
        refuse_value(place, value, Message("a list of numbers with a decimal point"))
    return np.array(value, np.float64)


_WHOLE = _exactly(int, Message("a whole number"))
TEXT = Form("string", pack_text, Reader.text, str, _exactly(str, Message("a text")))
UINT32 = Form("uint32", UINT.pack, lambda reader: reader.one(UINT), int, _WHOLE)
INT32 = Form("int32", _INT.pack, lambda reader: reader.one(_INT), int, _WHOLE)
FLOAT64 = Form(
    "float64",
    _NUMBER.pack,
    Reader.number,
    float,
    _exactly(float, Message("a number with a decimal point")),
)
TIME = Form("time", pack_time, Reader.time_us, utc_time.iso_text, _time_from_json)
FLOATS = Form("float64[]", _pack_numbers, Reader.numbers, np.ndarray.tolist, _numbers_from_json)


def list_of(form: Form, count: Optional[int] = None) -> Form:
    """Return the type of a tuple of values; with a count it has so many in every trace."""

    def pack(values: Tuple[Any, ...]) -> bytes:
        packed = b"".join(map(form.pack, values))
        return packed if count else UINT.pack(len(values)) + packed

    def unpack(reader: Reader) -> Tuple[Any, ...]:
        size = count or reader.one(UINT)
        # Each value has at least the size of a length; a damaged size must not fill the memory.
        if UINT.size * size > reader.left:
            raise struct.error(f"a list of {size} values is longer than the message")
        return tuple([form.unpack(reader) for _ in range(size)])

    def from_json_list(value: Any, place: str) -> Tuple[Any, ...]:
        found = enumerate(_list(value, place, count))
        return tuple(form.from_json(one, f"{place}[{number}]") for number, one in found)

    return Form(
        f"{form.ros}[{count or ''}]",
        pack,
        unpack,
        lambda values: list(map(form.as_json, values)),
        from_json_list,
        form.parts,
    )


def record_of(kind: Type[Any]) -> Form:
    """Return the type of the values of a dataclass, which is a message of its own."""
    parts = tuple(fields_of(kind).values())
    return Form(
        kind.__name__,
        lambda one: b"".join([part.form.pack(getattr(one, part.attribute)) for part in parts]),
        lambda reader: kind(*[part.form.unpack(reader) for part in parts]),
        lambda one: as_json(parts, vars(one)),
        lambda value, place: kind(**from_json(parts, value, f"{place}.")),
        parts,
    )

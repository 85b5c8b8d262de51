"""The fields of a trace: their types, as bytes of a ROS 1 message and as JSON, and their rules.

ROS 1 serialization: http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes;
little endian, the fields one after the other, strings and arrays behind their length as uint32.
"""

from __future__ import annotations

import dataclasses
import io
import math
import struct
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, List, Mapping, NoReturn, Optional, Tuple, Type

import numpy as np

from gpr20_common.faults import INTERNAL
from gpr20_common.message import Fault, Message
from gpr20_common.mid.codec import shortened
from gpr20_survey import faults
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import utc_time

UINT = struct.Struct("<I")
_TIME = struct.Struct("<II")
_NUMBER = struct.Struct("<d")


@dataclass(frozen=True)
class Rule:
    """What the values of a field must be, beyond their type."""

    holds: Callable[[Any], Any]
    allowed: Message
    fault: Fault = INTERNAL


def between(lower: float, upper: float, fault: Fault = INTERNAL) -> Rule:
    # NaN fails every comparison; a negative zero is the same as zero in no stored form.
    allowed = Message("between {lower:.12g} and {upper:.12g}", lower=lower, upper=upper)
    return Rule(
        lambda value: lower <= value <= upper and (value != lower or str(value) != "-0.0"),
        allowed,
        fault,
    )


def printable(most: int, fault: Fault = INTERNAL) -> Rule:
    """Return the rule of a text of so many printable characters."""
    allowed = Message("printable and have at most {most} characters", most=most)
    return Rule(lambda value: len(value) <= most and value.isprintable(), allowed, fault)


FINITE = Rule(math.isfinite, Message("finite"), faults.SENSOR_FAILED)
PLAUSIBLE = Rule(
    utc_time.is_plausible,
    Message(
        "between {earliest} and {latest}: set the computer's clock",
        earliest=utc_time.iso_text(utc_time.EARLIEST_US),
        latest=utc_time.iso_text(utc_time.LATEST_US),
    ),
    faults.CLOCK_WRONG,
)


def refuse(reason: Message, fault: Fault = INTERNAL) -> NoReturn:
    raise TraceRefusedError(Message("the trace is refused: {reason}", reason=reason), fault=fault)


class Reader(io.BytesIO):
    """Takes the values of a message; what is not whole is a struct.error or UnicodeDecodeError."""

    def take(self, size: int) -> bytes:
        data = self.read(size)
        if len(data) != size:
            raise struct.error(f"{size} bytes are due at byte {self.tell()}")
        return data

    def one(self, form: struct.Struct) -> Any:
        return form.unpack(self.read(form.size))[0]

    def text(self) -> str:
        return self.take(self.one(UINT)).decode()

    def time_us(self) -> int:
        """Return a time [us since 1970]."""
        seconds, rest_ns = _TIME.unpack(self.read(_TIME.size))
        return int(seconds * utc_time.US_PER_S + rest_ns // utc_time.NS_PER_US)


@dataclass(frozen=True)
class Form:
    """One type of values, by its name in ROS: how they get into messages and JSON, and back.

    Attributes:
        json: Type of its values in JSON, for `gpr20_common.mid.codec`.
        of_json: Returns the value of one from JSON; raises InvalidValueError.
        rule: What its values must be where no other rule is declared.
        parts: The fields of each value, if it is a message of its own.
    """

    ros: str
    pack: Callable[[Any], bytes]
    unpack: Callable[[Reader], Any]
    json: Any
    as_json: Callable[[Any], Any]
    of_json: Callable[[Any], Any]
    rule: Optional[Rule] = None
    parts: Tuple[TraceField, ...] = ()


@dataclass(frozen=True)
class TraceField:
    """One field of a trace: a line of the table from which all its forms come.

    Attributes:
        attribute: Its name in this software.
        unit: Empty if there is none.
        unknown: The value that says that it is not known, null in JSON; None: it is always known.
        rule: What a value must be that is known.
    """

    attribute: str
    form: Form
    meaning: str
    unit: str = ""
    unknown: Any = None
    rule: Optional[Rule] = None

    @property
    def name(self) -> str:
        return self.attribute[:-3] if self.attribute.endswith("_us") else self.attribute

    def is_unknown(self, value: Any) -> bool:
        """Return whether a value says that it is not known."""
        unknown = self.unknown
        return unknown is not None and bool(
            value == unknown or (value != value and unknown != unknown)
        )


def of(
    form: Form,
    meaning: str,
    unit: str = "",
    unknown: Any = None,
    rule: Optional[Rule] = None,
    default: Any = dataclasses.MISSING,
) -> Any:
    """Declare a field of a dataclass that is a field of a trace."""
    own = {"form": form, "meaning": meaning, "unit": unit, "unknown": unknown}
    return dataclasses.field(default=default, metadata={**own, "rule": rule or form.rule})


def fields_of(kind: Type[Any]) -> Tuple[TraceField, ...]:
    """Return the fields that a dataclass declares with `of`."""
    declared = (one for one in dataclasses.fields(kind) if one.metadata)
    return tuple(TraceField(one.name, **one.metadata) for one in declared)


def json_record(name: str, fields: Iterable[TraceField]) -> Type[Any]:
    """Return the dataclass as which `gpr20_common.mid.codec` reads these fields."""
    kinds = ((one, one.form.json) for one in fields)
    return dataclasses.make_dataclass(
        name, [(one.name, kind if one.unknown is None else Optional[kind]) for one, kind in kinds]
    )


def as_json(fields: Iterable[TraceField], values: Mapping[str, Any]) -> Dict[str, Any]:
    """Return a JSON object of values, which are given by their attributes."""
    found = ((one, values[one.attribute]) for one in fields)
    return {
        one.name: None if one.is_unknown(value) else one.form.as_json(value) for one, value in found
    }


def of_json(fields: Iterable[TraceField], record: Any) -> Dict[str, Any]:
    """Return the values of a record of `json_record` by their attributes."""
    found = ((one, getattr(record, one.name)) for one in fields)
    return {
        one.attribute: one.unknown if value is None else one.form.of_json(value)
        for one, value in found
    }


def check(fields: Iterable[TraceField], values: Mapping[str, Any], place: str = "") -> None:
    """Refuse values, given by their attributes, that break the rules of their fields.

    Raises:
        TraceRefusedError: One does; the message names it.
    """
    for one in fields:
        value, rule = values[one.attribute], one.rule
        # NaN says of some that it is not known.
        if rule and not rule.holds(value) and (value == value or one.unknown == one.unknown):
            reason = Message(
                "{place} is {value}; it must be {allowed}",
                place=f"{place}{one.name}",
                value=shortened(one.form.as_json(value)),
                allowed=rule.allowed,
            )
            refuse(reason, rule.fault)
        for part in value if one.form.parts else ():
            own = vars(part)
            first = own[one.form.parts[0].attribute]
            check(one.form.parts, own, f"{place}{one.name}[{first}].")


def pack_text(text: str) -> bytes:
    data = text.encode()
    return UINT.pack(len(data)) + data


def pack_time(time_us: int) -> bytes:
    seconds, rest_us = divmod(time_us, utc_time.US_PER_S)
    return _TIME.pack(seconds, rest_us * utc_time.NS_PER_US)


def _number(reader: Reader) -> float:
    # There is one NaN only, so that equal traces are equal in every form.
    value: float = reader.one(_NUMBER)
    return value if value == value else math.nan


def _pack_numbers(values: np.ndarray) -> bytes:
    return UINT.pack(len(values)) + values.astype("<f8", copy=False).tobytes()


def _numbers(reader: Reader) -> np.ndarray:
    return np.frombuffer(reader.take(8 * reader.one(UINT)), "<f8").astype(np.float64)


def _whole(ros: str, code: str) -> Form:
    form = struct.Struct(code)
    return Form(ros, form.pack, lambda reader: reader.one(form), int, int, int)


TEXT = Form("string", pack_text, Reader.text, str, str, str)
UINT32, INT32 = _whole("uint32", "<I"), _whole("int32", "<i")
FLOAT64 = Form("float64", _NUMBER.pack, _number, float, float, float, FINITE)
TIME = Form(
    "time", pack_time, Reader.time_us, str, utc_time.iso_text, utc_time.parse_iso, PLAUSIBLE
)
FLOATS = Form(
    "float64[]",
    _pack_numbers,
    _numbers,
    List[float],
    np.ndarray.tolist,
    # Three times as fast as np.array.
    lambda values: np.frombuffer(struct.pack(f"{len(values)}d", *values)).copy(),
)


def list_of(form: Form, count: Optional[int] = None) -> Form:
    """Return the type of a tuple of values; with a count it has so many in every trace."""

    def pack(values: Tuple[Any, ...]) -> bytes:
        packed = b"".join(map(form.pack, values))
        return packed if count else UINT.pack(len(values)) + packed

    return Form(
        f"{form.ros}[{count or ''}]",
        pack,
        lambda reader: tuple([form.unpack(reader) for _ in range(count or reader.one(UINT))]),
        Tuple[(form.json,) * count] if count else Tuple[form.json, ...],
        lambda values: list(map(form.as_json, values)),
        lambda values: tuple(map(form.of_json, values)),
        parts=form.parts,
    )


def record_of(kind: Type[Any]) -> Form:
    """Return the type of the values of a dataclass, which is a message of its own."""
    parts = fields_of(kind)
    return Form(
        kind.__name__,
        lambda one: b"".join([part.form.pack(getattr(one, part.attribute)) for part in parts]),
        lambda reader: kind(*[part.form.unpack(reader) for part in parts]),
        json_record(kind.__name__, parts),
        lambda one: as_json(parts, vars(one)),
        lambda record: kind(**of_json(parts, record)),
        parts=parts,
    )

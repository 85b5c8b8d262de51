"""One number inside the messages of any type, by the name of its field."""

from __future__ import annotations

import re
import struct
from typing import Any, List, Optional, Tuple, Type

import genpy
import roslib.message

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.high.raw_message import connection_header
from gpr20_common.message import Message

_PART = re.compile(r"(?P<name>\w+)(\[(?P<index>\d+)\])?")
_INTEGERS = tuple(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
_NUMBERS = frozenset(("bool", "float32", "float64", *_INTEGERS))
# A name, and the index in a list.
Step = Tuple[str, Optional[int]]


class MessageField:
    """Reads one number from messages that were received as `rospy.AnyMsg`."""

    def __init__(self, datatype: str, path: str) -> None:
        """Find the field.

        Args:
            datatype: Type of the messages, such as `std_msgs/Float64`.
            path: Name of the field, such as `data` or `a.b[0]`.

        Raises:
            InvalidValueError: The type is not installed here, or has no such number; the message
                names its fields.
        """
        self._type = _installed(datatype)
        self._steps = _checked_steps(self._type, path)
        self._path = path

    def read(self, received: Any) -> float:
        """Return the number.

        Args:
            received: A message as rospy handed it to a callback for `rospy.AnyMsg`.

        Raises:
            InvalidValueError: It is of another type, damaged, or its list is too short.
        """
        header = connection_header(received)
        if (header["type"], header["md5sum"]) != (self._type._type, self._type._md5sum):
            raise InvalidValueError(
                Message(
                    "messages of type {found} arrive instead of {wanted}",
                    found=header["type"],
                    wanted=self._type._type,
                    details=f"{header['md5sum']}, not {self._type._md5sum}",
                ),
                fault=faults.SENSOR_TYPE_DIFFERS,
            )
        message = self._type()
        try:
            message.deserialize(received._buff)
            return float(self._walk(message))
        except (genpy.DeserializationError, struct.error, IndexError) as error:
            raise InvalidValueError(
                Message("a message does not hold {field}", field=self._path, details=error),
                fault=faults.SENSOR_FIELD_MISSING,
            ) from error

    def _walk(self, value: Any) -> Any:
        for name, index in self._steps:
            value = getattr(value, name)
            if index is not None:
                value = value[index]
        return value


def _installed(datatype: str) -> Type:
    try:
        found = roslib.message.get_message_class(datatype)
    except (ValueError, ImportError) as error:
        raise _unknown(datatype, error) from error
    if found is None:
        raise _unknown(datatype, None)
    kind: Type = found
    return kind


def _unknown(datatype: str, reason: Optional[Exception]) -> InvalidValueError:
    return InvalidValueError(
        Message(
            "the message type {type} is not installed here; check its name, or install its package",
            type=datatype,
            details=reason or "",
        ),
        fault=faults.SENSOR_TYPE_UNKNOWN,
    )


def _checked_steps(kind: Type, path: str) -> List[Step]:
    steps: List[Step] = []
    owner: Optional[Type] = kind
    text = kind._type
    for part in path.split("."):
        found = _PART.fullmatch(part)
        fields = {} if owner is None else dict(zip(owner.__slots__, owner._slot_types))
        if found is None or found["name"] not in fields:
            raise InvalidValueError(
                Message(
                    "{type} has no field {field}; its fields are: {fields}",
                    type=text,
                    field=part,
                    fields=", ".join(f"{name} ({one})" for name, one in fields.items()) or "-",
                ),
                fault=faults.SENSOR_FIELD_MISSING,
            )
        text = fields[found["name"]]
        index = None if found["index"] is None else int(found["index"])
        if ("[" in text) != (index is not None):
            raise InvalidValueError(_list_message(part, text), fault=faults.SENSOR_FIELD_MISSING)
        text, _bracket, _length = text.partition("[")
        owner = roslib.message.get_message_class(text) if "/" in text else None
        steps.append((found["name"], index))
    if text not in _NUMBERS:
        inside = "" if owner is None else ", ".join(owner.__slots__)
        raise InvalidValueError(
            Message(
                "{field} is of type {type}, which is not a number; fields in it: {fields}",
                field=path,
                type=text,
                fields=inside or "-",
            ),
            fault=faults.SENSOR_FIELD_MISSING,
        )
    return steps


def _list_message(part: str, text: str) -> Message:
    if "[" in text:
        return Message(
            "{field} is a list ({type}); choose one of its values, such as {example}",
            field=part,
            type=text,
            example=f"{part}[0]",
        )
    return Message("{field} is not a list, but of type {type}", field=part, type=text)

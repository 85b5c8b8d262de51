"""One number inside the messages of any type, by the name of its field."""

from __future__ import annotations

import re
import struct
from typing import Any, Dict, List, Optional, Tuple

import genpy
import roslib.message

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.high.raw_message import connection_header, deserialized
from gpr20_common.message import Message

_PART = re.compile(r"(?P<name>\w+)(\[(?P<index>\d+)\])?")
_NUMBER = re.compile("bool|u?int(8|16|32|64)|float(32|64)")


class MessageField:
    """Reads one number from messages that were received as `rospy.AnyMsg`."""

    def __init__(self, datatype: str, path: str) -> None:
        """Find the field, such as `data` or `a.b[0]`, in a type such as `std_msgs/Float64`.

        Raises:
            InvalidValueError: The type is not installed here, or has no such number; the message
                names its fields.
        """
        self._path = path
        reason: object = ""
        try:
            self._type = roslib.message.get_message_class(datatype)
        except (ValueError, ImportError) as error:
            self._type, reason = None, error
        if self._type is None:
            raise InvalidValueError(
                Message(
                    "the message type {type} is not installed here; check its name, or install "
                    "its package",
                    type=datatype,
                    details=reason,
                ),
                fault=CONFIGURATION,
            )
        # A name, and the index in a list.
        self._steps: List[Tuple[str, Optional[int]]] = []
        fields = _fields(datatype)
        for part in path.split("."):
            found = _PART.fullmatch(part)
            text = fields.get(found["name"], "") if found else ""
            inside, bracket, _length = text.partition("[")
            if found is None or not inside or bool(bracket) != (found["index"] is not None):
                break
            self._steps.append((found["name"], int(found["index"]) if bracket else None))
            fields = _fields(inside) or fields
        else:
            if _NUMBER.fullmatch(inside):
                return
        raise InvalidValueError(
            Message(
                "{type} has no number {field}; its fields are: {fields}; one value of a list is "
                "written with its index, such as {example}",
                type=datatype,
                field=path,
                fields=", ".join(f"{name} ({one})" for name, one in fields.items()),
                example="data[0]",
            ),
            fault=CONFIGURATION,
        )

    def read(self, received: Any) -> float:
        """Return the number in a message.

        Raises:
            InvalidValueError: It is of another type, damaged, or its list is too short.
        """
        header = connection_header(received)
        if (header["type"], header["md5sum"]) != (self._type._type, self._type._md5sum):
            raise InvalidValueError(
                Message(
                    "messages of type {found} arrive; sensors.yaml says {wanted}",
                    found=header["type"],
                    wanted=self._type._type,
                    details=f"{header['md5sum']}, not {self._type._md5sum}",
                ),
                fault=CONFIGURATION,
            )
        try:
            value = deserialized(self._type, received._buff)
            for name, index in self._steps:
                value = getattr(value, name)
                if index is not None:
                    value = value[index]
            return float(value)
        except (genpy.DeserializationError, struct.error, IndexError) as error:
            raise InvalidValueError(
                Message(
                    "a message does not hold {field}, which sensors.yaml names",
                    field=self._path,
                    details=error,
                ),
                fault=CONFIGURATION,
            ) from error


def _fields(datatype: str) -> Dict[str, str]:
    """Return the types of the fields of a message by their names; none of what is no message."""
    kind = roslib.message.get_message_class(datatype) if "/" in datatype else None
    return {} if kind is None else dict(zip(kind.__slots__, kind._slot_types))

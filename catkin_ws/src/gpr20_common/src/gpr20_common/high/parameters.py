"""Parameters from the ROS parameter server, checked against a dataclass."""

from __future__ import annotations

from typing import Collection, Type, TypeVar

import rospy

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.records import record_from

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
    place = rospy.resolve_name(namespace).rstrip("/")
    values = rospy.get_param(place, {})
    if not isinstance(values, dict):
        raise InvalidValueError(
            Message(
                "{place} is {value}; it must be a group of parameters",
                place=place,
                value=repr(values),
            )
        )
    own = {name: value for name, value in values.items() if name not in others}
    return record_from(record_class, own, place)

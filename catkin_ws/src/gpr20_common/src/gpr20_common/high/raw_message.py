"""Messages as rospy has them: their bytes, who sent them, their moments."""

from __future__ import annotations

import io
from typing import Any, Dict, Type, TypeVar

import genpy
import rospy

MessageType = TypeVar("MessageType", bound=genpy.Message)


def serialized(message: Any) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def deserialized(message_type: Type[MessageType], data: bytes) -> MessageType:
    """Return the message that these bytes are, or raise a genpy.DeserializationError."""
    message = message_type()
    message.deserialize(data)
    return message


def preserialized(message_type: Type[MessageType], data: bytes) -> MessageType:
    """Return a message of this type that is sent as exactly these bytes; its fields are empty."""

    class Preserialized(message_type):  # type: ignore[valid-type, misc]
        __slots__ = ()

        def serialize(self, buff: Any) -> None:
            buff.write(data)

    return Preserialized()


def connection_header(received: Any) -> Dict[str, str]:
    """Return the header of the connection that brought a message or request to a callback."""
    header: Dict[str, str] = received._connection_header  # rospy adds it
    return header


def microseconds(moment: rospy.Time) -> int:
    """Return a moment as whole microseconds since 1970, the rest cut off."""
    return int(moment.to_nsec() // 1000)


def ros_time(time_us: int) -> rospy.Time:
    """Return a moment [microseconds since 1970, UTC] as ROS knows it."""
    return rospy.Time(0, 1000 * time_us)

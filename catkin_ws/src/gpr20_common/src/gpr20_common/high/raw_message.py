"""Messages that are serialized already, so that nothing is serialized twice."""

from __future__ import annotations

import io
from typing import Any, Type, TypeVar

import genpy

MessageType = TypeVar("MessageType", bound=genpy.Message)


def serialized(message: Any) -> bytes:
    """Return the bytes of a message as ROS sends them."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def deserialized(message_type: Type[MessageType], data: bytes) -> MessageType:
    """Return the message that these bytes are.

    Raises:
        genpy.DeserializationError: They are not one of this type.
    """
    message = message_type()
    message.deserialize(data)
    return message


def preserialized(message_type: Type[MessageType], data: bytes) -> MessageType:
    """Return a message of this type that is sent as exactly these bytes.

    Its fields are empty: it is made to be published or sent as part of a request.
    """

    class Preserialized(message_type):  # type: ignore[valid-type, misc]
        __slots__ = ()

        def serialize(self, buff: Any) -> None:
            buff.write(data)

    return Preserialized()

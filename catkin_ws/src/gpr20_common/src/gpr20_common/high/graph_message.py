"""A message for people on the ROS graph: its complete English text, and what clients translate."""

from __future__ import annotations

from typing import Any, Dict

from gpr20_common.message import Message, received_message


def message_fields(message: Message) -> Dict[str, str]:
    """Return the fields `message` and `message_json` of a ROS message, response or result."""
    return {"message": str(message), "message_json": message.to_json()}


def message_from(answer: Any) -> Message:
    """Return the message of something that has the fields `message` and `message_json`."""
    return received_message(answer.message, answer.message_json)

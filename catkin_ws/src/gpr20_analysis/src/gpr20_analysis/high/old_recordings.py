"""Completes the messages of older recordings, so that the nodes of today receive them."""

from __future__ import annotations

import dataclasses
import struct
from typing import Any, Dict, List, Tuple

from gpr20_msgs.msg import (
    AxisActionResult,
    ControlStatus,
    CurrentCoordinate,
    ImagingProgress,
    NodeDescription,
    RobotConfiguration,
    ServiceStatus,
    SurveyCoverage,
    Trace,
)
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import trace_message

FORMER_MD5SUM = "3b9779b1131ed5c2e1d850c2f8562476"
_LENGTH = struct.Struct("<I")
SEQUENCE_BYTES, TIME_BYTES, BOOL_BYTES, FLOAT64_BYTES = 4, 8, 1, 8
# A description of today ends with three further texts: version, revision, host.
ADDED_TEXTS = bytes(3 * _LENGTH.size)
# And the configuration with one: fault_code.
ADDED_TEXT = bytes(_LENGTH.size)


class _Cursor:
    """Reads through a serialized message."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self.place = 0

    def skip(self, size: int) -> None:
        """Skip values of a fixed size.

        Raises:
            ValueError: The message is shorter.
        """
        self.place += size
        if self.place > len(self._data):
            raise ValueError("a recorded robot_configuration is cut off")

    def length(self) -> int:
        """Return the length of a text or list, and skip it."""
        before = self.place
        self.skip(_LENGTH.size)
        return int(_LENGTH.unpack_from(self._data, before)[0])

    def text(self) -> None:
        """Skip a text."""
        self.skip(self.length())


def completed_configuration(data: bytes) -> bytes:
    """Return a serialized RobotConfiguration of today, with empty texts for what is new.

    Args:
        data: The serialized message of the former definition.

    Raises:
        ValueError: It is cut off.
    """
    cursor = _Cursor(data)
    cursor.skip(SEQUENCE_BYTES + TIME_BYTES)
    cursor.text()  # frame_id
    cursor.skip(BOOL_BYTES)  # known
    cursor.text()  # message
    cursor.text()  # message_json
    cursor.skip(BOOL_BYTES)  # simulated
    parts: List[bytes] = []
    begin = 0
    for _node in range(cursor.length()):
        cursor.text()  # node
        cursor.text()  # hardware
        cursor.skip(BOOL_BYTES + FLOAT64_BYTES)  # simulated, time_scale
        cursor.text()  # configuration_json
        parts += [data[begin : cursor.place], ADDED_TEXTS]
        begin = cursor.place
    return b"".join((*parts, data[begin:], ADDED_TEXT))


# Bytes of an empty string or an empty list in a ROS message.
EMPTY = 4
# And of a zero of an axis: its number and time.
ZERO = 12
# By the checksum of the old definition: the present type, and the length of the fields that it
# adds at its end. They are empty or zero.
ADDED: Dict[str, Tuple[type, int]] = {
    "7b530785257ca423f317a80d75c5dad5": (ControlStatus, 4 * EMPTY),
    "a03e61f3a68474fd87c9325d30026060": (ControlStatus, 3 * EMPTY),
    "bc17b4aae71496146bf73f0025ac7b5c": (ControlStatus, 2 * EMPTY),
    "8830f4d1986e7bfcd8944b9db55ce297": (SurveyCoverage, 2 * EMPTY),
    "d2ff0e17e24af241635b0fa72eb91531": (AxisActionResult, 2 * EMPTY + ZERO),
    "f06ebb79ed3434417ea61b7366a83ad7": (AxisActionResult, EMPTY + ZERO),
    "0190c6a34a26aa1f2b312556adc2f9c5": (AxisActionResult, ZERO),
    "e061ccf0018c3c5d62199e8edb7b6a7e": (CurrentCoordinate, ZERO + EMPTY),
    "590625d6ef1577da2231acdc855d35aa": (NodeDescription, 3 * EMPTY),
    "eaf89b67ef3f427e785f46baa81d1eff": (RobotConfiguration, EMPTY),
    "34280dde11767b5f69c2e30ae831bbb6": (ServiceStatus, EMPTY),
    "56f3d0ffa64de48d2b6c063794fe5ea1": (ImagingProgress, EMPTY),
}
PRESENT = {
    trace_message.MD5SUM,
    *(kind._md5sum for kind, _length in ADDED.values()),  # type: ignore[attr-defined]
}


def completed(message: RecordedMessage) -> RecordedMessage:
    """Return a message of a recording as its topic carries it today.

    A survey that was resumed with a later version has the later messages of a topic under
    another name (`gpr20_survey.recording.topic_types`); they return to their topic.

    Args:
        message: Of any type; one that has not changed is returned as it is.
    """
    if message.md5sum in ADDED:
        kind, length = ADDED[message.md5sum]
        return _of_type(kind, message, message.data + bytes(length))
    if message.md5sum in trace_message.FORMER_MD5SUMS:
        return _of_type(Trace, message, trace_message.completed(message.data, message.md5sum))
    if message.md5sum == FORMER_MD5SUM:
        return _completed_configuration(message)
    if message.md5sum in PRESENT:
        return dataclasses.replace(message, topic=_own_topic(message))
    return message


def _completed_configuration(message: RecordedMessage) -> RecordedMessage:
    try:
        data = completed_configuration(message.data)
    except ValueError:
        return message  # no subscriber takes it, and the replay continues
    return _of_type(RobotConfiguration, message, data)


def _of_type(kind: Any, message: RecordedMessage, data: bytes) -> RecordedMessage:
    return dataclasses.replace(
        message,
        topic=_own_topic(message),
        md5sum=kind._md5sum,
        definition=kind._full_text,
        data=data,
    )


def _own_topic(message: RecordedMessage) -> str:
    ending = f"_{message.md5sum[:8]}"
    return message.topic[: -len(ending)] if message.topic.endswith(ending) else message.topic

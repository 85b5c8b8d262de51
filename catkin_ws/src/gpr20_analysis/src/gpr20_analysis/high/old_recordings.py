"""Completes the messages of older recordings, so that the nodes of today receive them."""

from __future__ import annotations

import dataclasses
from typing import Any, Dict, Tuple

from gpr20_analysis.high import old_configuration
from gpr20_msgs.msg import (
    AxisActionResult,
    CandidateList,
    ControlStatus,
    ImagingProgress,
    NodeDescription,
    RobotConfiguration,
    ServiceStatus,
    SurveyCoverage,
    Trace,
)
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import trace_message

# Bytes of an empty string or an empty list in a ROS message.
EMPTY = 4
# By the checksum of the old definition: the present type, and the length of the fields that it
# adds at its end. They are empty or zero.
ADDED: Dict[str, Tuple[type, int]] = {
    "7b530785257ca423f317a80d75c5dad5": (ControlStatus, 2 * EMPTY),
    "a03e61f3a68474fd87c9325d30026060": (ControlStatus, EMPTY),
    "8830f4d1986e7bfcd8944b9db55ce297": (SurveyCoverage, 2 * EMPTY),
    "d2ff0e17e24af241635b0fa72eb91531": (AxisActionResult, 2 * EMPTY),
    "f06ebb79ed3434417ea61b7366a83ad7": (AxisActionResult, EMPTY),
    "3741ab00ba640a2a8da407c0f664e814": (CandidateList, 4 + EMPTY),
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
    if message.md5sum == old_configuration.FORMER_MD5SUM:
        return _completed_configuration(message)
    if message.md5sum in PRESENT:
        return dataclasses.replace(message, topic=_own_topic(message))
    return message


def _completed_configuration(message: RecordedMessage) -> RecordedMessage:
    try:
        data = old_configuration.completed_configuration(message.data)
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

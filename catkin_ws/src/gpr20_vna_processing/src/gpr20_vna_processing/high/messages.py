"""ROS messages from and to the storage's own records."""

from __future__ import annotations

from typing import Any, Optional

import rospy
from std_msgs.msg import String

from gpr20_common.high.raw_message import serialized
from gpr20_msgs.msg import Trace as TraceMessage
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.trace import Trace

TRACE_TOPIC = "trace"
METADATA_TOPIC = "survey_metadata"


def microseconds(moment: rospy.Time) -> int:
    """Return a moment as whole microseconds since 1970, the rest cut off."""
    return moment.secs * utc_time.US_PER_S + moment.nsecs // utc_time.NS_PER_US


def ros_time(time_us: int) -> rospy.Time:
    """Return a moment [us since 1970] as ROS knows it."""
    seconds, rest_us = divmod(time_us, utc_time.US_PER_S)
    return rospy.Time(seconds, rest_us * utc_time.NS_PER_US)


class RosMessages:
    """Serializes the messages that the storage itself puts on the graph."""

    def trace(self, trace: Trace, time_ns: int) -> RecordedMessage:
        """Serialize a trace as a message of the topic `trace`."""
        return _recorded(TRACE_TOPIC, TraceMessage, trace_message.encode(trace), time_ns)

    def recorded_trace(self, message: RecordedMessage) -> Optional[Trace]:
        """Return the trace of a recorded message, or None if it is no trace.

        Raises:
            TraceRefusedError: It cannot be read or holds a wrong value.
        """
        if message.datatype != trace_message.DATATYPE:
            return None
        return trace_message.decode(message.data, message.md5sum)

    def metadata(self, text: str, time_ns: int) -> RecordedMessage:
        """Serialize the survey's description as a message of `survey_metadata`."""
        return _recorded(METADATA_TOPIC, String, serialized(String(text)), time_ns, latching=True)


def _recorded(
    topic: str, message_type: Any, data: bytes, time_ns: int, latching: bool = False
) -> RecordedMessage:
    return RecordedMessage(
        topic=rospy.resolve_name(topic),
        datatype=message_type._type,
        md5sum=message_type._md5sum,
        definition=message_type._full_text,
        data=data,
        time_ns=time_ns,
        latching=latching,
    )

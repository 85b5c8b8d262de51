"""ROS messages from and to the storage's own records."""

from __future__ import annotations

import io
from typing import Any, Optional

import genpy
import numpy as np
import rospy
from std_msgs.msg import String

from gpr20_msgs.msg import Trace
from gpr20_vna_processing.errors import TraceRefusedError
from gpr20_vna_processing.low.recording import RecordedMessage
from gpr20_vna_processing.mid import utc_time
from gpr20_vna_processing.mid.trace_record import TraceRecord

TRACE_TOPIC = "trace"
METADATA_TOPIC = "survey_metadata"


def microseconds(moment: rospy.Time) -> int:
    """Return a moment as whole microseconds since 1970, the rest cut off."""
    return moment.secs * utc_time.US_PER_S + moment.nsecs // utc_time.NS_PER_US


def ros_time(time_us: int) -> rospy.Time:
    """Return a moment [us since 1970] as ROS knows it."""
    seconds, rest_us = divmod(time_us, utc_time.US_PER_S)
    return rospy.Time(seconds, rest_us * utc_time.NS_PER_US)


def trace_record(message: Trace) -> TraceRecord:
    """Return the trace of a message, checked.

    Raises:
        TraceRefusedError: A value is not allowed.
    """
    return TraceRecord(
        format=message.format,
        survey_id=message.survey_id,
        sample_id=message.sample_id,
        index=message.index,
        timestamp_us=microseconds(message.timestamp),
        x_coord_mm=message.x_coord_mm,
        y_coord_mm=message.y_coord_mm,
        z_coord_deg=message.z_coord_deg,
        antennae_height_m=message.antennae_height_m,
        frequency_hz=np.array(message.frequency_hz, dtype=np.float64),
        s21_real=np.array(message.s21_real, dtype=np.float64),
        s21_imag=np.array(message.s21_imag, dtype=np.float64),
        sweep_started_us=microseconds(message.sweep_started),
        sweep_ended_us=microseconds(message.sweep_ended),
        quality=tuple(message.quality),
    )


def trace_message(trace: TraceRecord) -> Trace:
    """Return the message of a trace."""
    return Trace(
        format=trace.format,
        survey_id=trace.survey_id,
        sample_id=trace.sample_id,
        index=trace.index,
        timestamp=ros_time(trace.timestamp_us),
        x_coord_mm=trace.x_coord_mm,
        y_coord_mm=trace.y_coord_mm,
        z_coord_deg=trace.z_coord_deg,
        antennae_height_m=trace.antennae_height_m,
        frequency_hz=trace.frequency_hz.tolist(),
        s21_real=trace.s21_real.tolist(),
        s21_imag=trace.s21_imag.tolist(),
        sweep_started=ros_time(trace.sweep_started_us),
        sweep_ended=ros_time(trace.sweep_ended_us),
        quality=list(trace.quality),
    )


class RosMessages:
    """Serializes the messages that the storage itself puts on the graph."""

    def trace(self, trace: TraceRecord, time_ns: int) -> RecordedMessage:
        """Serialize a trace as a message of the topic `trace`."""
        return _serialized(TRACE_TOPIC, trace_message(trace), time_ns)

    def recorded_trace(self, message: RecordedMessage) -> Optional[TraceRecord]:
        """Return the trace of a recorded message, or None if it is no trace.

        Raises:
            TraceRefusedError: It cannot be read or holds a wrong value.
        """
        if message.datatype != Trace._type:
            return None
        if message.md5sum != Trace._md5sum:
            raise TraceRefusedError(
                f"a trace was recorded with another version of {Trace._type}: "
                f"{message.md5sum[:64]}, not {Trace._md5sum}"
            )
        trace = Trace()
        try:
            trace.deserialize(message.data)
        except (genpy.DeserializationError, UnicodeDecodeError) as error:
            raise TraceRefusedError(f"a recorded trace is not whole: {error}") from error
        return trace_record(trace)

    def metadata(self, text: str, time_ns: int) -> RecordedMessage:
        """Serialize the survey's description as a message of `survey_metadata`."""
        return _serialized(METADATA_TOPIC, String(text), time_ns, latching=True)


def _serialized(topic: str, message: Any, time_ns: int, latching: bool = False) -> RecordedMessage:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return RecordedMessage(
        topic=rospy.resolve_name(topic),
        datatype=message._type,
        md5sum=message._md5sum,
        definition=message._full_text,
        data=buffer.getvalue(),
        time_ns=time_ns,
        latching=latching,
    )

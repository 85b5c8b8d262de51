"""The two topics that the storage itself publishes and records."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Optional

from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

TRACE_TOPIC = "trace"
METADATA_TOPIC = "survey_metadata"
# std_msgs/String
TEXT_TYPE, TEXT_MD5SUM, TEXT_DEFINITION = (
    "std_msgs/String",
    "992ce8a1687cec8c8bd883ec73ca41d1",
    "string data\n",
)


@dataclass(frozen=True)
class SurveyTopics:
    """Makes the messages of these topics; the same bytes are published and recorded."""

    trace_definition: str
    """Full text of the message type gpr20_msgs/Trace."""
    trace_topic: str = f"/{TRACE_TOPIC}"
    """Absolute name."""
    metadata_topic: str = f"/{METADATA_TOPIC}"
    """Absolute name."""

    def trace(self, trace: Trace, time_ns: int) -> RecordedMessage:
        """Return a trace as a message, received at a moment [ns since 1970, UTC]."""
        return RecordedMessage(
            self.trace_topic,
            trace_message.DATATYPE,
            trace_message.MD5SUM,
            self.trace_definition,
            trace_message.encode(trace),
            time_ns,
        )

    def metadata(self, text: str, time_ns: int) -> RecordedMessage:
        """Return the content of survey.json as a latched message."""
        content = text.encode()
        data = struct.pack("<I", len(content)) + content
        return RecordedMessage(
            self.metadata_topic, TEXT_TYPE, TEXT_MD5SUM, TEXT_DEFINITION, data, time_ns, True
        )


def recorded_trace(message: RecordedMessage) -> Optional[Trace]:
    """Return the trace of a recorded message, or None if it is no trace.

    Raises:
        TraceRefusedError: It is a trace, but cannot be read or holds a wrong value.
    """
    if message.datatype != trace_message.DATATYPE:
        return None
    return trace_message.decode(message.data, message.md5sum)

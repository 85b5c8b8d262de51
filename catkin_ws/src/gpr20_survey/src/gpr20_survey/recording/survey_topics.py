"""The topics that the storage itself records."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping, Optional

from gpr20_survey import faults
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder.log_record import LogRecord, record_of_line
from gpr20_survey.recording import replay_message
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.replay_message import REPLAY_TOPIC, RecordedSurvey
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

TRACE_TOPIC = "trace"
METADATA_TOPIC = "survey_metadata"
LOG_TOPIC = "survey_log"
# std_msgs/String
TEXT_TYPE, TEXT_MD5SUM, TEXT_DEFINITION = (
    "std_msgs/String",
    "992ce8a1687cec8c8bd883ec73ca41d1",
    "string data\n",
)


@dataclass(frozen=True)
class SurveyTopics:
    """Makes the messages of these topics; the bytes that are published are recorded."""

    trace_definition: str
    """Full text of the message type gpr20_msgs/Trace."""
    trace_topic: str = f"/{TRACE_TOPIC}"
    """Absolute name."""
    metadata_topic: str = f"/{METADATA_TOPIC}"
    """Absolute name."""
    log_topic: str = f"/{LOG_TOPIC}"
    """Absolute name."""
    replay_topic: str = f"/{REPLAY_TOPIC}"
    """Absolute name; recorded only, so that it is published when the recording is played."""

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
        return _text(self.metadata_topic, text.encode(), time_ns, latching=True)

    def log(self, record: LogRecord, time_ns: int) -> RecordedMessage:
        """Return a record of the survey's log as a message, added at a moment [ns]."""
        return _text(self.log_topic, record.line()[:-1], time_ns, latching=False)

    def replay(self, description: Mapping[str, Any], folder: Path, time_ns: int) -> RecordedMessage:
        """Return the latched message by which a replay of the survey is recognized."""
        return RecordedMessage(
            self.replay_topic,
            replay_message.DATATYPE,
            replay_message.MD5SUM,
            replay_message.DEFINITION,
            RecordedSurvey.of(description, folder).encode(),
            time_ns,
            True,
        )


def recorded_log(message: RecordedMessage) -> Optional[LogRecord]:
    """Return the record of the survey's log in a message, or None if it holds none that is right.

    The robot may have a namespace.
    """
    if message.datatype != TEXT_TYPE or message.topic.rsplit("/", 1)[-1] != LOG_TOPIC:
        return None
    return record_of_line(message.data[4:])


def _text(topic: str, content: bytes, time_ns: int, latching: bool) -> RecordedMessage:
    data = struct.pack("<I", len(content)) + content
    return RecordedMessage(topic, TEXT_TYPE, TEXT_MD5SUM, TEXT_DEFINITION, data, time_ns, latching)


def is_metadata_topic(topic: str) -> bool:
    """Return whether a topic holds the survey's metadata, whatever the robot's namespace."""
    return topic.rsplit("/", 1)[-1] == METADATA_TOPIC


def recorded_trace(message: RecordedMessage) -> Optional[Trace]:
    """Return the trace of a recorded message, or None if it is no trace.

    Raises:
        TraceRefusedError: It is a trace, but cannot be read or holds a wrong value.
    """
    if message.datatype != trace_message.DATATYPE:
        return None
    try:
        return trace_message.decode(message.data, message.md5sum)
    except TraceRefusedError as error:
        if error.message.fault is faults.TRACE_OTHER_VERSION:
            raise
        # It was right when it was recorded.
        raise TraceRefusedError(error.message, fault=faults.TRACE_DAMAGED) from error

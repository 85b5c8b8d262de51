"""The topics that the storage itself records.

`replay` is among them: players of recordings publish it with the others, so that nobody takes a
replay for a robot.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, Callable, Mapping, Optional

from gpr20_survey.folder.log_record import LogRecord, record_of_line
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.trace_form import pack_text

TRACE_TOPIC = "trace"
METADATA_TOPIC = "survey_metadata"
LOG_TOPIC = "survey_log"
REPLAY_TOPIC = "replay"
OWN_TOPICS = (TRACE_TOPIC, METADATA_TOPIC, LOG_TOPIC, REPLAY_TOPIC)
TEXT_TYPE = "std_msgs/String"
TEXT = (TEXT_TYPE, "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n")
TRACE = (trace_message.DATATYPE, trace_message.MD5SUM, trace_message.DEFINITION)
REPLAY_TYPE = "gpr20_msgs/Replay"
REPLAY_MD5SUM = "d7879b9021dbe8893e0328198f6f53d5"
REPLAY_DEFINITION = """\
uint8 PLAYING=0
uint8 PAUSED=1
uint8 ENDED=2
string survey_id
string started
string folder
uint8 state
float64 rate
float64 position_s
float64 length_s
"""
REPLAY = (REPLAY_TYPE, REPLAY_MD5SUM, REPLAY_DEFINITION)
# state, rate, position [s], length [s]: playing, and the rest unknown.
_IN_A_RECORDING = struct.pack("<B3d", 0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SurveyTopics:
    """Makes the messages of these topics; the bytes that are published are recorded."""

    resolve: Callable[[str], str] = lambda name: f"/{name}"
    """Returns the absolute name of a topic."""

    def trace(self, trace: Trace, time_ns: int) -> RecordedMessage:
        """Return a trace as a message, received at a moment [ns since 1970, UTC]."""
        return RecordedMessage(
            self.resolve(TRACE_TOPIC), *TRACE, trace_message.encode(trace), time_ns
        )

    def metadata(self, text: str, time_ns: int) -> RecordedMessage:
        return RecordedMessage(self.resolve(METADATA_TOPIC), *TEXT, pack_text(text), time_ns, True)

    def log(self, record: LogRecord, time_ns: int) -> RecordedMessage:
        """Return a record of the survey's log as a message, added at a moment [ns]."""
        text = record.line()[:-1].decode()
        return RecordedMessage(self.resolve(LOG_TOPIC), *TEXT, pack_text(text), time_ns)

    def replay(
        self, description: Mapping[str, Any], folder: PurePath, time_ns: int
    ) -> RecordedMessage:
        """Return the latched message by which a replay of the survey is recognized.

        It is recorded only, so that it is published when the recording is played.
        """
        named = (*(str(description.get(key, "")) for key in ("survey_id", "started")), folder.name)
        data = b"".join([*map(pack_text, named), _IN_A_RECORDING])
        return RecordedMessage(self.resolve(REPLAY_TOPIC), *REPLAY, data, time_ns, True)


def recorded_log(message: RecordedMessage) -> Optional[LogRecord]:
    """Return the record of the survey's log in a message, or None if it holds none that is right.

    The robot may have a namespace.
    """
    if message.datatype != TEXT_TYPE or message.topic.rsplit("/", 1)[-1] != LOG_TOPIC:
        return None
    return record_of_line(message.data[4:])

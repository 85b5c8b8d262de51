"""The message that says which survey a recording shows: gpr20_msgs/Replay, serialized.

Players of recordings publish it with the other topics, so that nobody takes a replay for a robot.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, Mapping

REPLAY_TOPIC = "replay"
DATATYPE = "gpr20_msgs/Replay"
# Of the definition below, as ROS computes it.
MD5SUM = "d7879b9021dbe8893e0328198f6f53d5"

DEFINITION = """\
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

_LENGTH = struct.Struct("<I")
# state, rate, position [s], length [s]: playing, and the rest unknown.
_IN_A_RECORDING = struct.pack("<B3d", 0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RecordedSurvey:
    """The survey of a recording.

    Attributes:
        survey_id: UUID.
        started: Start of the survey, ISO 8601, UTC; empty if it is not known.
        folder: Name of its folder; empty if it is not known.
    """

    survey_id: str
    started: str = ""
    folder: str = ""

    @classmethod
    def of(cls, description: Mapping[str, Any], folder: PurePath) -> RecordedSurvey:
        """Return the survey of a folder.

        Args:
            description: What its log says of it.
            folder: The survey's folder.
        """
        texts = (description.get(key) for key in ("survey_id", "started"))
        survey_id, started = (text if isinstance(text, str) else "" for text in texts)
        return cls(survey_id, started, folder.name)

    @classmethod
    def decode(cls, data: bytes) -> RecordedSurvey:
        """Return the survey of a serialized message.

        Raises:
            ValueError: It is not one.
        """
        texts, place = [], 0
        for _ in range(3):
            try:
                (size,) = _LENGTH.unpack_from(data, place)
            except struct.error as error:
                raise ValueError("the message is incomplete") from error
            place += _LENGTH.size
            texts.append(data[place : place + size].decode("utf-8", "replace"))
            place += size
        return cls(*texts)

    def encode(self) -> bytes:
        """Return the serialized message of a recording."""
        texts = [
            text.encode("utf-8", "replace") for text in (self.survey_id, self.started, self.folder)
        ]
        return b"".join((*(_LENGTH.pack(len(one)) + one for one in texts), _IN_A_RECORDING))

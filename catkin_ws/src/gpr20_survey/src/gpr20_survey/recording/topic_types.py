"""One message type per topic of a recording."""

from __future__ import annotations

import dataclasses
from typing import AbstractSet, Dict, Mapping, Optional, Set

from gpr20_survey.recording.recording import RecordedMessage

# Topics that are recorded under another name; more are a fault of their publishers.
MAX_RENAMED = 100


class TopicTypes:
    """Names the topics of a recording so that each has one type.

    A survey may be resumed with another version of the software, whose messages have other
    definitions. `rosbag play` and `replay.launch` make one publisher per topic, with the type of
    its first message: messages of another type would arrive as nonsense. They are recorded under
    the name of their topic with the beginning of the type's checksum, such as
    `/control_status_7b530785`.
    """

    def __init__(self, recorded: Mapping[str, AbstractSet[str]]) -> None:
        """Begin with the types that the recording holds already.

        Args:
            recorded: The checksums of the types of each topic.
        """
        self._types: Dict[str, Set[str]] = {topic: set(sums) for topic, sums in recorded.items()}
        self._renamed: Set[str] = set()

    def named(self, message: RecordedMessage) -> Optional[RecordedMessage]:
        """Return the message under the name that its topic has in the recording.

        Returns:
            None if the topic has far too many types.
        """
        if message.md5sum in self._types.setdefault(message.topic, {message.md5sum}):
            return message
        name = f"{message.topic}_{message.md5sum[:8]}"
        if name not in self._renamed and len(self._renamed) >= MAX_RENAMED:
            return None
        self._renamed.add(name)
        if message.md5sum not in self._types.setdefault(name, {message.md5sum}):
            return None
        return dataclasses.replace(message, topic=name)

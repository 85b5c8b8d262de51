"""A message as recordings hold it, whatever their format."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RecordedMessage:
    """One serialized ROS 1 message and what a reader needs to decode it."""

    topic: str
    """Absolute name of the topic."""
    datatype: str
    """Such as "std_msgs/String"."""
    md5sum: str
    definition: str
    """Full text of the message type with all types it contains."""
    data: bytes
    time_ns: int
    """When it was received [ns since 1970, UTC]."""
    latching: bool = False
    """Whether the publisher sends its last message to late subscribers."""

    @property
    def size_bytes(self) -> int:
        """How much memory it takes in all [bytes]."""
        return len(self.data) + len(self.definition) + len(self.topic)

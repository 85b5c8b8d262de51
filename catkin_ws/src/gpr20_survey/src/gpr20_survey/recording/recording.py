"""What a recording file takes, whatever its format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

# More than any record of the storage: a message and a chunk together have less than a third.
MAX_RECORD_BYTES = 64 << 20


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
    """Whether the publisher keeps the last message for late subscribers."""

    @property
    def size_bytes(self) -> int:
        """How much memory it takes, all told [bytes]."""
        return len(self.data) + len(self.definition) + len(self.topic)


class Recording(Protocol):
    """One file that holds messages of many topics.

    `write` and `begin_chunk` only collect; nothing is promised before `commit` returns.
    After a `commit` that failed everything collected is still there and the next one
    writes it again.
    """

    @property
    def name(self) -> str:
        """File name, for messages."""

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit [bytes]."""

    def in_place(self) -> bool:
        """Say whether the file that is written is still the one of its name."""

    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""

    def begin_chunk(self) -> None:
        """End the group of messages that are compressed and indexed together."""

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good."""

    def finish(self) -> None:
        """Write index and summary, and close the file; may be repeated after a failure."""

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""

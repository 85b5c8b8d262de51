"""A recording: one file that holds messages of many topics, whatever its format."""

from __future__ import annotations

import abc
from dataclasses import dataclass
from pathlib import Path

from gpr20_survey.files.append_only_file import AppendOnlyFile

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
    """Whether the publisher sends its last message to late subscribers."""

    @property
    def size_bytes(self) -> int:
        """How much memory it takes in all [bytes]."""
        return len(self.data) + len(self.definition) + len(self.topic)


class Recording(abc.ABC):
    """One file that messages are appended to.

    Attributes:
        is_believed: Whether the file has checksums: only then a commit makes it durable.

    `write` and `begin_chunk` only collect; nothing is promised before `commit` returns.
    After a `commit` that failed everything collected is still there and the next one
    writes it again.
    """

    is_believed = True

    def __init__(self, file: AppendOnlyFile) -> None:
        """Take an empty file."""
        self._file = file
        self._finishing = False  # the index is collected, nothing else may follow

    @property
    def name(self) -> str:
        """File name, for messages."""
        return self._file.path.name

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit, without the chunk in progress [bytes]."""
        return self._file.collected_bytes

    def in_place(self) -> bool:
        """Return whether the file that is written still has its name."""
        return self._file.in_place()

    @abc.abstractmethod
    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""

    @abc.abstractmethod
    def begin_chunk(self) -> None:
        """End the group of messages that are compressed and indexed together."""

    def write_alone(self, message: RecordedMessage) -> None:
        """Collect a message in a chunk of its own.

        Readers of traces need not unpack other topics.
        """
        self.begin_chunk()
        self.write(message)
        self.begin_chunk()

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good.

        What has no checksums is readable then, but durable only when it is finished.

        Raises:
            FileReplacedError: The file was moved, removed or replaced.
            OSError: The disk refused; everything collected remains for the next commit.
        """
        if not self._finishing:
            self.begin_chunk()
            self._file.commit(self.is_believed)

    def take_place_of(self, path: Path) -> None:
        """Give the file the name of another, which it replaces; return when that is durable.

        Raises:
            OSError: The disk refused.
        """
        self._file.take_place_of(path)

    @abc.abstractmethod
    def finish(self) -> None:
        """Write the index and close the file; may be repeated after a failure.

        Raises:
            FileReplacedError: The file was moved, removed or replaced.
            OSError: The disk refused.
        """

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""
        self._file.release()

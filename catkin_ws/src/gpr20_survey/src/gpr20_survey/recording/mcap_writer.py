"""The recording of a survey while it runs: an MCAP file that loses nothing that was committed."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Tuple

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import MCAP0_MAGIC, Writer

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.errors import IrregularFileError
from gpr20_survey.files.durable_files import open_new, put_in_place, sync_path

MAGIC = MCAP0_MAGIC
LIBRARY = "gpr20_vna_processing"


@dataclass(frozen=True)
class RecordedMessage:
    """A serialized ROS 1 message as recordings hold it, and what a reader needs to decode it."""

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


class _Collected(io.BytesIO):
    """What waits for a commit; its places are those in the file."""

    committed = 0  # length of what is durable before it [bytes]

    def tell(self) -> int:
        return self.committed + super().tell()


class McapFile:
    """Writes messages into an MCAP file of profile ros1 (zstd, with checksums).

    `write` and `write_alone` only collect; nothing is promised before `commit` returns. The
    library writes into the memory and never to the disk: after a commit that failed everything
    collected is still there, and the next one writes the same bytes again to the same place.

    A record of an MCAP file begins with its length, so a file cut anywhere is read up to the cut.
    The library holds the index of the whole file.

    A topic has one type. A survey may be resumed with another version of the software, whose
    messages have other definitions; players make one publisher per topic, with the type of its
    first message. Messages of another type are recorded under the name of their topic with the
    beginning of the type's checksum, such as `/control_status_7b530785`.
    """

    def __init__(self, path: Path) -> None:
        """Create the file, which must not exist; its head is on the disk after the first commit.

        Raises:
            OSError: The file exists or the disk refused.
        """
        self._path = path
        self._descriptor = open_new(path, os.O_CREAT | os.O_EXCL | os.O_RDWR)
        sync_path(path.parent)
        self._collected = _Collected()
        self._writer = Writer(self._collected, enable_data_crcs=True)
        self._finishing = False  # the index is collected, nothing else may follow
        self._types: Dict[str, str] = {}  # checksum of the type of each topic
        self._schemas: Dict[Tuple[str, str], int] = {}
        self._channels: Dict[Tuple[str, str], int] = {}
        self._writer.start(Profile.ROS1, LIBRARY)

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit, without the chunk in progress [bytes]."""
        return self._collected.tell() - self._collected.committed

    def in_place(self) -> bool:
        """Return whether the file that is written still has its name."""
        try:
            there = os.stat(str(self._path), follow_symlinks=False)
        except OSError:
            return False
        return os.path.samestat(there, os.fstat(self._descriptor))

    def take_place_of(self, path: Path) -> None:
        """Give the file the name of another, which it replaces; return when that is durable.

        Raises:
            OSError: The disk refused.
        """
        put_in_place(self._path, path)
        self._path = path

    def write(self, message: RecordedMessage) -> None:
        channel, time_ns = self._channel_of(message), message.time_ns
        self._writer.add_message(channel, time_ns, message.data, time_ns)

    def write_alone(self, message: RecordedMessage) -> None:
        """Collect a message in a chunk of its own: damage to others does not touch it."""
        self._writer.flush()
        self.write(message)
        self._writer.flush()

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good.

        Raises:
            IrregularFileError: The file was moved, removed or replaced.
            OSError: The disk refused; everything collected remains for the next commit.
        """
        if not self._finishing:
            self._writer.flush()
            self._commit()

    def finish(self) -> None:
        """Write the summary and close the file.

        Raises:
            IrregularFileError: The file was moved, removed or replaced.
            OSError: The disk refused; the call may be repeated.
        """
        if not self._finishing:
            self._writer.finish()
            self._finishing = True
        self._commit()
        self.abandon()

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def _commit(self) -> None:
        offset, rest = self._collected.committed, memoryview(self._collected.getvalue())
        if not rest:
            return
        while rest:
            written = os.pwrite(self._descriptor, rest, offset)
            rest, offset = rest[written:], offset + written
        os.fsync(self._descriptor)
        if not self.in_place():
            raise IrregularFileError(
                Message(
                    "it was moved, removed or replaced while it was written; if the survey's "
                    "folder was moved or renamed, put it back, then resume the survey"
                ),
                self._path,
                fault=faults.FOLDER_MOVED,
            )
        self._collected.committed = offset
        self._collected.seek(0)
        self._collected.truncate()

    def _channel_of(self, message: RecordedMessage) -> int:
        topic, md5sum = message.topic, message.md5sum
        while self._types.setdefault(topic, md5sum) != md5sum:
            topic = f"{topic}_{md5sum[:8]}"
        key = (topic, md5sum)
        if key not in self._channels:
            kind = (message.datatype, message.definition)
            if kind not in self._schemas:
                self._schemas[kind] = self._writer.register_schema(
                    message.datatype, SchemaEncoding.ROS1, message.definition.encode()
                )
            metadata = {"md5sum": md5sum, "latching": "1" if message.latching else "0"}
            self._channels[key] = self._writer.register_channel(
                topic, MessageEncoding.ROS1, self._schemas[kind], metadata
            )
        return self._channels[key]

"""A ROS bag that loses nothing that was committed."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import NamedTuple

import genpy
import rosbag

from gpr20_vna_processing.low.committed_file import CommittedFile
from gpr20_vna_processing.low.recording import RecordedMessage

NS_PER_S = 1_000_000_000


def _sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


# A chunk without content (bag format 2.0, "Chunk"). `rosbag reindex` looks at the record
# behind a chunk before it accepts the chunk: if that record is torn it drops, and cuts off,
# the whole chunk before. So a whole record always stands there before a trace is
# acknowledged. The next chunk is written over it: same fields, same lengths.
EMPTY_CHUNK = _sized(
    _sized(b"op=\x05") + _sized(b"compression=none") + _sized(b"size=" + struct.pack("<I", 0))
) + struct.pack("<I", 0)


class _MessageType(NamedTuple):
    """Stands for the generated class that rosbag asks for a type's names."""

    md5sum: str
    definition: str

    @property
    def _md5sum(self) -> str:
        return self.md5sum

    @property
    def _full_text(self) -> str:
        return self.definition


class BagFile:
    """Writes messages into a new bag (uncompressed: noise does not compress)."""

    def __init__(self, path: Path) -> None:
        """Create the file.

        Raises:
            OSError: The file exists or the disk refused.
        """
        self.name = path.name
        self._file = CommittedFile(path, trailer=EMPTY_CHUNK)
        self._indexed = False
        self._bag = rosbag.Bag(self._file, "w")
        self._file.commit()

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit [bytes]."""
        return self._file.collected_bytes

    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""
        header = {
            "topic": message.topic,
            "type": message.datatype,
            "md5sum": message.md5sum,
            "message_definition": message.definition,
            "latching": "1" if message.latching else "0",
        }
        self._bag.write(
            message.topic,
            (
                message.datatype,
                message.data,
                message.md5sum,
                _MessageType(message.md5sum, message.definition),
            ),
            genpy.Time(*divmod(message.time_ns, NS_PER_S)),
            raw=True,
            connection_header=header,
        )

    def begin_chunk(self) -> None:
        """End the chunk in progress."""
        self._bag.flush()
        # Kept by rosbag only for reading back; it would grow with every message.
        self._bag._connection_indexes.clear()
        self._bag._chunk_headers.clear()

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good.

        Raises:
            OSError: The disk refused; everything collected is kept for the next commit.
        """
        if self._indexed:
            return  # the rest is for `finish`
        self.begin_chunk()
        self._file.commit()

    def finish(self) -> None:
        """Write the index and close the file.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        if not self._indexed:
            self.commit()
            self._file.keep_trailer()
            self._bag.close()
            self._indexed = True
        # `rosbag reindex` gives up on a bag whose index is torn, but passes over a record
        # whose length is zero.
        self._file.commit(first_byte_last=True)
        self._file.release()

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""
        self._file.release()

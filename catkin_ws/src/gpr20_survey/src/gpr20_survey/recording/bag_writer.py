"""A ROS bag that loses nothing that was committed."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List, Tuple

from gpr20_survey.files.append_only_file import AppendOnlyFile
from gpr20_survey.recording import bag_format
from gpr20_survey.recording.bag_format import Connection, Indexes
from gpr20_survey.recording.recording import RecordedMessage, Recording

CHUNK_BYTES = 768 * 1024  # a chunk ends when it is larger; the size that rosbag uses
HEADER_FIELDS_BYTES = 128

# A chunk without content. `rosbag reindex` looks at the record behind a chunk before it
# accepts the chunk: if that record is torn it drops, and cuts off, the whole chunk before.
# So a whole record is always there before a trace is acknowledged. The next chunk is
# written over it: same fields, same lengths.
EMPTY_CHUNK = bag_format.chunk_record(b"")


class BagFile(Recording):
    """Writes messages into a bag (uncompressed: noise does not compress).

    A bag has no checksums. It is written for the readers of ROS, and again from the MCAP where it
    is damaged. The stock writer of rosbag would leave a bag of which `rosbag reindex` loses the
    last chunk.
    """

    is_believed = False

    def __init__(self, path: Path) -> None:
        """Create the file; its head is on the disk after the first commit.

        Raises:
            OSError: The file exists or the disk refused.
        """
        super().__init__(AppendOnlyFile(path, trailer=EMPTY_CHUNK))
        self._connections: Dict[Tuple[str, str], Connection] = {}
        self._chunk = bytearray()
        self._indexes: Indexes = {}
        self._chunk_infos: List[bytes] = []
        self._file.write(bag_format.MAGIC + bag_format.file_header(0, 0, 0))

    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""
        connection = self._connection_of(message)
        entry = (message.time_ns, len(self._chunk))
        self._chunk += bag_format.message_record(connection.number, message)
        self._indexes.setdefault(connection.number, []).append(entry)
        if len(self._chunk) > CHUNK_BYTES:
            self.begin_chunk()

    def begin_chunk(self) -> None:
        """End the chunk in progress."""
        if not self._chunk:
            return
        self._chunk_infos.append(bag_format.chunk_info_record(self._file.tell(), self._indexes))
        self._file.write(bag_format.chunk_record(bytes(self._chunk)))
        self._file.write(bag_format.index_records(self._indexes))
        self._chunk.clear()
        self._indexes.clear()

    def finish(self) -> None:
        """Write the index and close the file.

        Raises:
            FileReplacedError: The file was moved, removed or replaced.
            OSError: The disk refused; the call may be repeated.
        """
        self.commit()
        self._finishing = True
        index_place = self._file.tell() + len(EMPTY_CHUNK)
        connections = map(bag_format.connection_record, self._connections.values())
        # `rosbag reindex` gives up on a bag whose index is torn, but passes over a record
        # whose length is zero.
        self._file.write_tail(b"".join([*connections, *self._chunk_infos]))
        header = bag_format.file_header(index_place, len(self._connections), len(self._chunk_infos))
        # The fields alone: they lie in one sector, which a disk writes whole.
        self._file.overwrite(len(bag_format.MAGIC), header[:HEADER_FIELDS_BYTES])
        self._file.release()

    def _connection_of(self, message: RecordedMessage) -> Connection:
        key = message.topic, message.md5sum
        if key not in self._connections:
            self._connections[key] = Connection(
                len(self._connections),
                message.topic,
                message.datatype,
                message.md5sum,
                message.definition,
                message.latching,
            )
            self._chunk += bag_format.connection_record(self._connections[key])
        return self._connections[key]

"""A ROS bag that loses nothing that was committed."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, Tuple

from gpr20_survey.files.append_only_file import CommittedFile
from gpr20_survey.recording import bag_format
from gpr20_survey.recording.bag_format import Connection, Entry
from gpr20_survey.recording.recording import RecordedMessage

CHUNK_BYTES = 768 * 1024  # a chunk ends when it is larger; the size that rosbag uses
PIECE_BYTES = 256 * 1024
HEADER_FIELDS_BYTES = 128

# A chunk without content. `rosbag reindex` looks at the record behind a chunk before it
# accepts the chunk: if that record is torn it drops, and cuts off, the whole chunk before.
# So a whole record always stands there before a trace is acknowledged. The next chunk is
# written over it: same fields, same lengths.
EMPTY_CHUNK = bag_format.chunk_record(b"")


class BagFile:
    """Writes messages into a bag (uncompressed: noise does not compress).

    Only the chunk in progress is in memory: the index is made from the file at the end.
    """

    def __init__(self, path: Path) -> None:
        """Create the file.

        Raises:
            OSError: The file exists or the disk refused.
        """
        self._begin(path, CommittedFile(path, trailer=EMPTY_CHUNK), ())
        self._file.write(bag_format.MAGIC + bag_format.file_header(0, 0, 0))
        self._file.commit()

    @classmethod
    def resumed(cls, path: Path, length: int, connections: Iterable[Connection]) -> BagFile:
        """Go on behind the last whole chunk of a bag; its index and all else there is cut off.

        Args:
            path: The bag.
            length: Where the last whole chunk with its index records ends [bytes].
            connections: Those of the chunks before.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        bag = cls.__new__(cls)
        bag._begin(path, CommittedFile.resumed(path, length, EMPTY_CHUNK), connections)
        try:
            # First: a header never names an index that is not there.
            bag._write_header(0, 0)
            bag._file.cut()
        except OSError:
            bag.abandon()
            raise
        return bag

    def _begin(self, path: Path, file: CommittedFile, connections: Iterable[Connection]) -> None:
        self.name = path.name
        self._file = file
        self._connections = {_key(one): one for one in connections}
        self._chunk = bytearray()
        self._indexes: Dict[int, List[Entry]] = {}
        self._chunks = 0
        self._finishing = False

    @property
    def collected_bytes(self) -> int:
        """How much waits for a commit [bytes]."""
        return self._file.collected_bytes + len(self._chunk)

    def in_place(self) -> bool:
        """Say whether the file that is written is still the one of its name."""
        return self._file.in_place()

    def write(self, message: RecordedMessage) -> None:
        """Collect a message."""
        connection = self._connections.get(_key(message))
        if connection is None:
            connection = self._connect(message)
        entry = (message.time_ns, len(self._chunk))
        self._chunk += bag_format.message_record(connection.number, message)
        self._indexes.setdefault(connection.number, []).append(entry)
        if len(self._chunk) > CHUNK_BYTES:
            self.begin_chunk()

    def begin_chunk(self) -> None:
        """End the chunk in progress."""
        if not self._chunk:
            return
        self._file.write(bag_format.chunk_record(bytes(self._chunk)))
        for number, entries in self._indexes.items():
            self._file.write(bag_format.index_record(number, sorted(entries)))
        self._chunk.clear()
        self._indexes.clear()

    def commit(self) -> None:
        """Write everything collected to the disk; return when it is there for good.

        Raises:
            OSError: The disk refused; everything collected is kept for the next commit.
        """
        if self._finishing:
            return  # the rest is for `finish`
        self.begin_chunk()
        self._file.commit()

    def finish(self) -> None:
        """Write the index and close the file.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        self.commit()
        self._finishing = True
        # `rosbag reindex` gives up on a bag whose index is torn, but passes over a record
        # whose length is zero.
        self._chunks = 0
        self._file.write_tail(_in_pieces(self._index_records()))
        self._write_header(self._file.committed_bytes + len(EMPTY_CHUNK), self._chunks)
        self._file.release()

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""
        self._file.release()

    def _write_header(self, index_place: int, chunks: int) -> None:
        header = bag_format.file_header(index_place, len(self._connections), chunks)
        # The fields alone: they lie in one sector, which a disk writes whole.
        self._file.overwrite(len(bag_format.MAGIC), header[:HEADER_FIELDS_BYTES])

    def _connect(self, message: RecordedMessage) -> Connection:
        connection = Connection(
            len(self._connections),
            message.topic,
            message.datatype,
            message.md5sum,
            message.definition,
            message.latching,
        )
        self._connections[_key(message)] = connection
        self._chunk += bag_format.connection_record(connection)
        return connection

    def _index_records(self) -> Iterator[bytes]:
        for connection in self._connections.values():
            yield bag_format.connection_record(connection)
        for place, indexes in self._written_chunks():
            self._chunks += 1
            yield bag_format.chunk_info_record(place, indexes)

    def _written_chunks(self) -> Iterator[Tuple[int, Dict[int, List[Entry]]]]:
        """Yield the place and the indexes of each chunk, from the file itself."""
        place, end = bag_format.DATA_START, self._file.committed_bytes
        chunk = -1
        indexes: Dict[int, List[Entry]] = {}
        while place < end:
            header, data_place, size = self._record_head(place)
            if header.kind == bag_format.CHUNK:
                if indexes:
                    yield chunk, indexes
                chunk, indexes = place, {}
            else:
                data = self._file.read_at(data_place, size)
                entries = bag_format.read_index(header._replace(data=data))
                indexes[header.number("conn")] = entries
            place = data_place + size
        if indexes:
            yield chunk, indexes

    def _record_head(self, place: int) -> Tuple[bag_format.Record, int, int]:
        head = self._file.read_at(place, 256)
        (header_size,) = struct.unpack_from("<I", head)
        (size,) = struct.unpack_from("<I", head, 4 + header_size)
        fields = bag_format.unpack_fields(head[4 : 4 + header_size])
        return bag_format.Record(fields, b"", 0), place + 8 + header_size, size


def _key(one: object) -> Tuple[str, str]:
    return one.topic, one.md5sum  # type: ignore[attr-defined]


def _in_pieces(records: Iterable[bytes]) -> Iterator[bytes]:
    """Join records into pieces of bounded size."""
    piece = bytearray()
    for one in records:
        piece += one
        if len(piece) > PIECE_BYTES:
            yield bytes(piece)
            piece.clear()
    if piece:
        yield bytes(piece)

"""An MCAP file that loses nothing that was committed."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Dict, Iterator, List, Tuple

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    DataEnd,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    Schema,
)
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding

from gpr20_survey.files.append_only_file import CommittedFile
from gpr20_survey.recording.mcap_summary import summary_pieces
from gpr20_survey.recording.recording import RecordedMessage

MAGIC = b"\x89MCAP0\r\n"
LIBRARY = "gpr20_vna_processing"
CHUNK_BYTES = 1 << 20  # a chunk ends when it is larger


def packed(*records: McapRecord) -> bytes:
    """Return records as bytes."""
    builder = RecordBuilder()
    for one in records:
        one.write(builder)
    return bytes(builder.end())


class McapTypes:
    """The schemas and channels of a file, by their numbers, and how many messages each has."""

    def __init__(self) -> None:
        self.schemas: Dict[int, Schema] = {}
        self.channels: Dict[int, Channel] = {}
        self.counts: Dict[int, int] = {}

    def channel_of(self, message: RecordedMessage) -> Tuple[Channel, List[McapRecord]]:
        """Return the channel of a message and what must be written before its first one."""
        for channel in self.channels.values():
            if (channel.topic, channel.metadata.get("md5sum")) == (message.topic, message.md5sum):
                return channel, []
        new: List[McapRecord] = []
        schema = self._schema_of(message, new)
        metadata = {"md5sum": message.md5sum, "latching": "1" if message.latching else "0"}
        channel = Channel(
            max(self.channels, default=0) + 1,
            message.topic,
            MessageEncoding.ROS1,
            metadata,
            schema.id,
        )
        self.channels[channel.id] = channel
        return channel, [*new, channel]

    def _schema_of(self, message: RecordedMessage, new: List[McapRecord]) -> Schema:
        data = message.definition.encode()
        for schema in self.schemas.values():
            if (schema.name, schema.data) == (message.datatype, data):
                return schema
        number = max(self.schemas, default=0) + 1
        schema = Schema(number, data, SchemaEncoding.ROS1, message.datatype)
        self.schemas[number] = schema
        new.append(schema)
        return schema


class McapFile:
    """Writes messages into an MCAP file of profile ros1 (zstd, with checksums).

    A record of an MCAP file says its length, so a file cut anywhere is read up to the cut.
    Only the chunk in progress is in memory: the summary is made from the file at the end.
    """

    def __init__(
        self, path: Path, metadata: Dict[str, str], attachment: bytes, time_ns: int
    ) -> None:
        """Create the file.

        Args:
            path: Must not exist.
            metadata: About the survey, as texts.
            attachment: The survey's description as JSON.
            time_ns: When the survey started [ns since 1970, UTC].

        Raises:
            OSError: The file exists or the disk refused.
        """
        self._begin(path, CommittedFile(path), McapTypes(), 0)
        head = packed(
            Header(Profile.ROS1, LIBRARY),
            Metadata("gpr20.survey", metadata),
            Attachment(time_ns, time_ns, "survey.json", "application/json", attachment),
        )
        self._append(MAGIC + head)
        self._file.commit()

    @classmethod
    def resumed(cls, path: Path, length: int, types: McapTypes, crc: int) -> McapFile:
        """Go on behind the last whole chunk of a file; its summary and all else is cut off.

        Args:
            path: The file.
            length: Where the last whole chunk with its message indexes ends [bytes].
            types: Schemas and channels of the chunks before.
            crc: CRC32 of the bytes before.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        mcap = cls.__new__(cls)
        mcap._begin(path, CommittedFile.resumed(path, length), types, crc)
        try:
            mcap._file.cut()
        except OSError:
            mcap.abandon()
            raise
        return mcap

    def _begin(self, path: Path, file: CommittedFile, types: McapTypes, crc: int) -> None:
        self.name = path.name
        self._file = file
        self._types = types
        self._crc = crc  # of all bytes committed or collected
        self._chunk = bytearray()
        self._indexes: Dict[int, MessageIndex] = {}
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
        channel, new = self._types.channel_of(message)
        self._chunk += packed(*new)
        count = self._types.counts[channel.id] = self._types.counts.get(channel.id, 0) + 1
        index = self._indexes.setdefault(channel.id, MessageIndex(channel.id, []))
        index.records.append((message.time_ns, len(self._chunk)))
        self._chunk += packed(
            Message(channel.id, message.time_ns, message.data, message.time_ns, count)
        )
        if len(self._chunk) > CHUNK_BYTES:
            self.begin_chunk()

    def begin_chunk(self) -> None:
        """End the chunk in progress."""
        if not self._chunk:
            return
        data = bytes(self._chunk)
        times = [time for index in self._indexes.values() for time, _ in index.records]
        chunk = Chunk(
            compression="zstd",
            data=zstandard.compress(data),
            message_end_time=max(times),
            message_start_time=min(times),
            uncompressed_crc=zlib.crc32(data),
            uncompressed_size=len(data),
        )
        self._append(packed(chunk, *self._indexes.values()))
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
        """Write the summary and close the file.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        self.commit()
        self._finishing = True
        self._file.write_tail(self._tail())
        self._file.release()

    def abandon(self) -> None:
        """Close the file as it is on the disk; what was not committed is lost."""
        self._file.release()

    def _append(self, data: bytes) -> None:
        self._crc = zlib.crc32(data, self._crc)
        self._file.write(data)

    def _tail(self) -> Iterator[bytes]:
        data_end = packed(DataEnd(self._crc))
        yield data_end
        start = self._file.committed_bytes + len(data_end)
        yield from summary_pieces(
            self._written_records(),
            start,
            list(self._types.schemas.values()),
            list(self._types.channels.values()),
        )
        yield MAGIC

    def _written_records(self) -> Iterator[Tuple[int, int, bytes]]:
        """Yield the place, the length and the bytes of each record, of chunks the head alone."""
        place, end = len(MAGIC), self._file.committed_bytes
        while place < end:
            opcode, size = struct.unpack("<BQ", self._file.read_at(place, 9))
            head = min(size, 128) if opcode == Opcode.CHUNK else size
            yield place, 9 + size, self._file.read_at(place, 9 + head)
            place += 9 + size

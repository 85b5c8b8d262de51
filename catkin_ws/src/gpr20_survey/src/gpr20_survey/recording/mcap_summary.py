"""The summary at the end of an MCAP file, made from its records."""

from __future__ import annotations

import io
import struct
import zlib
from typing import Iterable, Iterator, List, Optional, Sequence, Tuple

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

PIECE_BYTES = 256 * 1024


def summary_pieces(
    records: Iterable[Tuple[int, int, bytes]],
    start: int,
    schemas: Sequence[Schema],
    channels: Sequence[Channel],
) -> Iterator[bytes]:
    """Yield the summary section and the footer, a bounded part of it at a time.

    Args:
        records: Place, length and bytes of each record of the data section; of a chunk the
            head is enough.
        start: Where the summary begins [bytes].
        schemas: All schemas of the file.
        channels: All channels of the file.
    """
    summary = _Summary(start)
    yield from summary.group(Opcode.SCHEMA, schemas)
    yield from summary.group(Opcode.CHANNEL, channels)
    contents = _Contents(len(schemas), len(channels))
    yield from summary.group(Opcode.CHUNK_INDEX, contents.chunk_indexes(records))
    yield from summary.group(Opcode.ATTACHMENT_INDEX, contents.attachments)
    yield from summary.group(Opcode.METADATA_INDEX, contents.metadata)
    yield from summary.group(Opcode.STATISTICS, [contents.statistics])
    yield from summary.end()


class _Summary:
    """Packs groups of records and keeps where each lies."""

    def __init__(self, start: int) -> None:
        self._start = self._place = start
        self._crc = 0
        self._offsets: List[SummaryOffset] = []

    def group(self, opcode: Opcode, records: Iterable[McapRecord]) -> Iterator[bytes]:
        start = self._place
        yield from self._pieces(records)
        if self._place > start:
            self._offsets.append(SummaryOffset(opcode, start, self._place - start))

    def end(self) -> Iterator[bytes]:
        offsets_start = self._place
        yield from self._pieces(self._offsets)
        footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, self._start, offsets_start)
        builder = RecordBuilder()
        crc = zlib.crc32(footer, self._crc)
        Footer(self._start, offsets_start, crc).write(builder)
        yield bytes(builder.end())

    def _pieces(self, records: Iterable[McapRecord]) -> Iterator[bytes]:
        builder = RecordBuilder()
        for one in records:
            one.write(builder)
            if builder.count > PIECE_BYTES:
                yield self._counted(builder)
        if builder.count:
            yield self._counted(builder)

    def _counted(self, builder: RecordBuilder) -> bytes:
        piece = bytes(builder.end())
        self._place += len(piece)
        self._crc = zlib.crc32(piece, self._crc)
        return piece


class _Contents:
    """Goes over the data section once and counts what is in it."""

    def __init__(self, schemas: int, channels: int) -> None:
        self.attachments: List[AttachmentIndex] = []
        self.metadata: List[MetadataIndex] = []
        self.statistics = Statistics(0, channels, {}, 0, 0, 0, 0, 0, schemas)

    def chunk_indexes(self, records: Iterable[Tuple[int, int, bytes]]) -> Iterator[ChunkIndex]:
        chunk: Optional[ChunkIndex] = None
        for place, length, data in records:
            stream = ReadDataStream(io.BytesIO(data[9:]))
            if data[0] == Opcode.MESSAGE_INDEX and chunk is not None:
                self._add_index(chunk, place, length, MessageIndex.read(stream))
                continue
            if chunk is not None:
                yield chunk
            chunk = None
            if data[0] == Opcode.CHUNK:
                chunk = self._begin_chunk(place, length, stream)
            elif data[0] == Opcode.ATTACHMENT:
                self._add_attachment(place, length, Attachment.read(stream))
            elif data[0] == Opcode.METADATA:
                self.metadata.append(MetadataIndex(place, length, Metadata.read(stream).name))
                self.statistics.metadata_count += 1
        if chunk is not None:
            yield chunk

    def _begin_chunk(self, place: int, length: int, stream: ReadDataStream) -> ChunkIndex:
        start_time, end_time, uncompressed_size = (stream.read8() for _ in range(3))
        stream.read4()  # CRC
        statistics = self.statistics
        first = statistics.chunk_count == 0
        statistics.chunk_count += 1
        statistics.message_start_time = (
            start_time if first else min(statistics.message_start_time, start_time)
        )
        statistics.message_end_time = max(statistics.message_end_time, end_time)
        return ChunkIndex(
            chunk_length=length,
            chunk_start_offset=place,
            compression=stream.read_prefixed_string(),
            compressed_size=stream.read8(),
            message_end_time=end_time,
            message_index_length=0,
            message_index_offsets={},
            message_start_time=start_time,
            uncompressed_size=uncompressed_size,
        )

    def _add_index(self, chunk: ChunkIndex, place: int, length: int, index: MessageIndex) -> None:
        chunk.message_index_offsets[index.channel_id] = place
        chunk.message_index_length += length
        counts = self.statistics.channel_message_counts
        counts[index.channel_id] = counts.get(index.channel_id, 0) + len(index.records)
        self.statistics.message_count += len(index.records)

    def _add_attachment(self, place: int, length: int, one: Attachment) -> None:
        self.statistics.attachment_count += 1
        self.attachments.append(
            AttachmentIndex(
                place,
                length,
                one.log_time,
                one.create_time,
                len(one.data),
                one.name,
                one.media_type,
            )
        )

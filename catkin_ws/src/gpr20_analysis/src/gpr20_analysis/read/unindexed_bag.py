"""The messages of a bag without its index, as a killed recorder or a truncated copy leaves it.

Reads bags of any writer from the beginning. Of a chunk that was cut off, the messages that are
there in full are read, unless it is compressed.
"""

from __future__ import annotations

import bz2
import mmap
import struct
from typing import Any, BinaryIO, Dict, Iterator, Optional, Union

import lz4.frame

from gpr20_survey.recording import bag_format
from gpr20_survey.recording.bag_format import BagFormatError, Connection, Record
from gpr20_survey.recording.recording import MAX_RECORD_BYTES, RecordedMessage

Content = Union[bytes, mmap.mmap]
FIELDS_OF_HEADER = (b"index_pos=", b"conn_count=", b"chunk_count=")
INDEX_KINDS = (bytes([bag_format.CONNECTION]), bytes([bag_format.CHUNK_INFO]))


def complete_messages(stream: BinaryIO) -> Iterator[RecordedMessage]:
    """Yield every message that is there in full, in the order of the file.

    Args:
        stream: A regular file.

    Raises:
        OSError: The file cannot be read.
    """
    if stream.seek(0, 2) <= bag_format.DATA_START:
        return
    with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        yield from _messages(content, bag_format.DATA_START, {})


def has_whole_index(stream: BinaryIO) -> bool:
    """Return whether the index that the header of a bag names is there in full.

    Args:
        stream: A regular file.

    Raises:
        OSError: The file cannot be read.
    """
    stream.seek(0)
    head = stream.read(bag_format.DATA_START)
    places = [head.find(field) for field in FIELDS_OF_HEADER]
    if min(places) < 0 or len(head) < bag_format.DATA_START:
        return False
    index, connections, chunks = (
        struct.unpack_from("<Q" if number == 0 else "<I", head, place + len(field))[0]
        for number, (place, field) in enumerate(zip(places, FIELDS_OF_HEADER))
    )
    if index < bag_format.DATA_START or index > stream.seek(0, 2):
        return False
    with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return _has_records(content, index, connections + chunks)


def _has_records(content: mmap.mmap, place: int, wanted: int) -> bool:
    """Return whether so many records of an index are at a place, one behind the other."""
    found = 0
    while place < len(content) and found < wanted:
        try:
            record = bag_format.read_record(content, place)  # type: ignore[arg-type]
        except BagFormatError:
            break
        # Behind the index there is nothing; a hole would give records without a kind.
        if record.fields.get("op") not in INDEX_KINDS:
            break
        found += 1
        place = record.end
    return found >= wanted


def _messages(
    content: Content, place: int, connections: Dict[int, Connection]
) -> Iterator[RecordedMessage]:
    while place < len(content):
        try:
            one = bag_format.read_record(content, place)  # type: ignore[arg-type]
        except BagFormatError:
            # Only the chunk that was being written is torn; a recorder that is killed leaves the
            # length of its last chunk 0, so the messages follow as if they were outside.
            inside = _torn_chunk(content, place)
            if inside is None:
                return
            place = inside
            continue
        try:
            kind = one.kind
            if kind == bag_format.CONNECTION:
                found = bag_format.read_connection(one)
                connections[found.number] = found
            elif kind == bag_format.MESSAGE:
                yield bag_format.message_of(one, connections)
            elif kind == bag_format.CHUNK:
                yield from _messages(_chunk(one), 0, connections)
        except BagFormatError:
            return
        place = one.end


def _torn_chunk(content: Content, place: int) -> Optional[int]:
    """Return where the data of an uncompressed chunk begin whose end is missing."""
    if place + 4 > len(content):
        return None
    (size,) = struct.unpack_from("<I", content, place)
    data = place + 4 + size + 4
    if data > len(content):
        return None
    try:
        fields = bag_format.unpack_fields(content[place + 4 : place + 4 + size])
    except BagFormatError:
        return None
    is_chunk = fields.get("op") == bytes([bag_format.CHUNK])
    return data if is_chunk and fields.get("compression") == b"none" else None


def _chunk(chunk: Record) -> bytes:
    compression = chunk.fields.get("compression", b"")
    try:
        if compression == b"none":
            return chunk.data
        if compression == b"bz2":
            return _bounded(bz2.BZ2Decompressor(), chunk.data)
        if compression == b"lz4":
            return _bounded(lz4.frame.LZ4FrameDecompressor(), chunk.data)
    except (OSError, ValueError, RuntimeError) as error:
        raise BagFormatError("a compressed chunk is damaged") from error
    raise BagFormatError("a chunk has an unknown compression")


def _bounded(decompressor: Any, data: bytes) -> bytes:
    # A few damaged bytes must not fill the memory.
    content = bytes(decompressor.decompress(data, max_length=MAX_RECORD_BYTES))
    if not decompressor.eof:
        raise BagFormatError("a compressed chunk is cut off or too large")
    return content

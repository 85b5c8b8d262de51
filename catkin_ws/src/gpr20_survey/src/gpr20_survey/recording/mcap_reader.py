"""Reading the recording of a survey: whole, torn or damaged.

The library's readers end at a fault, and hold or sort what is behind it.
"""

from __future__ import annotations

import contextlib
import io
import mmap
import os
import struct
import zlib
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import breakup_chunk

from gpr20_common.message import Message
from gpr20_survey.files.regular_files import open_regular
from gpr20_survey.recording.mcap_writer import MAGIC, RecordedMessage

# More than any record of the storage: a message and a chunk together have less than a third.
MAX_RECORD_BYTES = 64 << 20
# The name of the compression, behind opcode, length, two times, size and checksum.
COMPRESSION, COMPRESSION_PLACE = b"\x04\0\0\0zstd", 37
# Opcode, length, start of the summary and of its offsets, checksum of the summary.
FOOTER = struct.Struct("<BQQQ4s")
END_BYTES = FOOTER.size + len(MAGIC)
# Opcode, length, checksum of all before it.
DATA_END = struct.Struct("<BQ4s")
# Opcode and length of a record.
RECORD = struct.Struct("<BQ")
# Of a chunk also two times and its size without compression.
CHUNK_HEAD = struct.Struct("<BQQQQ")
# At most what a bag has beside its messages: definitions of types, and an index.
BAG_HEAD_BYTES, BAG_TO_INDEX = 4 << 20, 8
BETWEEN = (Opcode.HEADER, Opcode.ATTACHMENT, Opcode.MESSAGE_INDEX)

Kind = Tuple[str, str, str, str]
"""Of the messages of a channel: topic, datatype, checksum and definition."""
TORN = (McapError, zstandard.ZstdError, struct.error, ValueError, KeyError, OverflowError)
"""What reading a record raises that is not whole."""


class StoredMcap:
    """Reads what is whole in a file written by `McapFile`.

    A tail that was torn by a crash is no fault: nothing in it was acknowledged.

    Attributes:
        path: The file; it may be missing.
        faults: What is damaged before the end; complete when `messages` has ended.
    """

    def __init__(self, path: Path) -> None:
        """Take the path; nothing is read yet."""
        self.path = path
        self.faults: List[Message] = []
        self._schemas: Dict[int, Schema] = {}
        self._types: Dict[int, Tuple[Kind, bool]] = {}

    def messages(self, datatype: str = "") -> Iterator[RecordedMessage]:
        """Yield every message of the whole chunks, in the order of the file.

        Args:
            datatype: Type of the messages; empty: of all types.
        """
        self.faults, self._schemas, self._types = [], {}, {}
        content = _mapped(self.path)
        place, ended = len(MAGIC), False
        if content[:place] != MAGIC and len(content) >= place:
            self.faults.append(
                Message("{file} does not begin like an MCAP file", file=self.path.name)
            )
        while place < len(content) and not ended:
            try:
                opcode, data, end = _record(content, place)
                ended = opcode == Opcode.DATA_END and _sum(content, place) == data
                found = [] if ended else self._messages(opcode, data, datatype)
            except TORN as error:
                end = _next_chunk(content, place + 1)
                if end < len(content):
                    self._damaged(f"byte {place}: {str(error) or type(error).__name__}")
            else:
                yield from found
            place = end
        if not self.faults and self.is_finished():
            self._check_sums(content)

    def is_finished(self) -> bool:
        content = _mapped(self.path)
        return len(content) > len(MAGIC) + END_BYTES and content[-len(MAGIC) :] == MAGIC

    def bag_bytes(self) -> int:
        """Return what a bag takes at most [bytes], as if lz4 did not pack it; 0 without a file."""
        content, place = _mapped(self.path), len(MAGIC)
        size = BAG_HEAD_BYTES * bool(content)
        while place + CHUNK_HEAD.size <= len(content):
            opcode, length, _start, _end, unpacked = CHUNK_HEAD.unpack_from(content, place)
            place += RECORD.size + length
            counted = min(length, len(content))  # damaged sizes must not refuse every survey
            if opcode == Opcode.CHUNK:
                counted = min(unpacked, MAX_RECORD_BYTES) * 129 // 128
            size += counted * (BAG_TO_INDEX if opcode == Opcode.MESSAGE_INDEX else 1)
        return max(size, len(content))

    def _messages(self, opcode: int, data: bytes, datatype: str) -> List[RecordedMessage]:
        if opcode in BETWEEN:
            return []
        if opcode != Opcode.CHUNK:
            raise ValueError(f"a record of kind {opcode} is where a chunk should be")
        messages = []
        for record in breakup_chunk(_chunk(data), validate_crc=True):
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._types[record.id] = type_of(self._schemas[record.schema_id], record)
            elif isinstance(record, McapMessage):
                own, latching = self._types[record.channel_id]
                if datatype in ("", own[1]):
                    messages.append(RecordedMessage(*own, record.data, record.log_time, latching))
        return messages

    def _check_sums(self, content: bytes) -> None:
        """Find damage outside the chunks, also of a length that hid the end of the data."""
        place = len(content) - END_BYTES
        opcode, size, summary, _offsets, expected = FOOTER.unpack_from(content, place)
        is_footer = (opcode, size) == (Opcode.FOOTER, FOOTER.size - RECORD.size)
        data = max(0, summary - DATA_END.size)
        end = DATA_END.pack(Opcode.DATA_END, 4, _sum(content, data))
        if (
            not is_footer
            or _sum(content, place + FOOTER.size - 4, summary) != expected
            or content[data:summary] != end
        ):
            self._damaged("a checksum outside its chunks is wrong")

    def _damaged(self, details: str) -> None:
        self.faults.append(Message("{file} is damaged", file=self.path.name, details=details))


def type_of(schema: Schema, channel: Channel) -> Tuple[Kind, bool]:
    """Return what stands before the data of a channel's messages, and whether it latches."""
    md5sum = channel.metadata.get("md5sum", "")
    own = (channel.topic, schema.name, md5sum, schema.data.decode())
    return own, channel.metadata.get("latching") == "1"


def _sum(content: bytes, end: int, start: int = 0) -> bytes:
    return zlib.crc32(memoryview(content)[start:end]).to_bytes(4, "little")


def _record(content: bytes, place: int) -> Tuple[int, bytes, int]:
    """Return kind and content of the record at a place, and the place of the next one."""
    start = place + RECORD.size
    opcode, size = RECORD.unpack(content[place:start])
    end = start + size
    if end > len(content):
        raise ValueError("a record is torn")
    if size > MAX_RECORD_BYTES:
        raise ValueError(f"a record claims {size} bytes")
    return opcode, content[start:end], end


def _chunk(data: bytes) -> Chunk:
    """Return the chunk of the content of a record."""
    chunk = Chunk.read(ReadDataStream(io.BytesIO(data)))
    if chunk.compression != "zstd" or not chunk.uncompressed_crc:
        raise ValueError("the storage does not write such chunks")
    # A damaged size must not fill the memory.
    size = zstandard.frame_content_size(chunk.data)
    if size != chunk.uncompressed_size or size > MAX_RECORD_BYTES:
        raise ValueError("the size of a chunk is wrong")
    return chunk


def _next_chunk(content: bytes, place: int) -> int:
    """Return where the next whole chunk begins, or the end: a torn tail has none."""
    while True:
        found = content.find(COMPRESSION, place + COMPRESSION_PLACE)
        if found < 0:
            return len(content)
        place = found - COMPRESSION_PLACE
        with contextlib.suppress(*TORN):
            opcode, data, _end = _record(content, place)
            if opcode == Opcode.CHUNK and breakup_chunk(_chunk(data), validate_crc=True):
                return place
        place += 1


def _mapped(path: Path) -> Any:
    """Return the content of a file, read as it is looked at; empty if it is missing.

    Raises:
        OSError: The file cannot be read.
    """
    with contextlib.suppress(FileNotFoundError), open(open_regular(path), "rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        # A slice of a map is bytes, which is all that the readers need.
        return mmap.mmap(stream.fileno(), size, prot=mmap.PROT_READ) if size else b""
    return b""

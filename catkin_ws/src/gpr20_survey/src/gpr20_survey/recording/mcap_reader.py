"""Reading an MCAP file that may be torn or damaged: the library's readers end at a fault."""

from __future__ import annotations

import contextlib
import io
import struct
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Dict, Iterator, List, Optional, Tuple

import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import breakup_chunk

from gpr20_common.message import Message
from gpr20_survey.recording.mcap_writer import MAGIC
from gpr20_survey.recording.recording import MAX_RECORD_BYTES, RecordedMessage
from gpr20_survey.recording.stored_recording import damaged, mapped

# The name of the compression, behind opcode, length, two times, size and checksum.
COMPRESSION, COMPRESSION_PLACE = b"\x04\0\0\0zstd", 37
# Opcode, length, start of the summary and of its offsets, checksum of the summary.
FOOTER = struct.Struct("<BQQQI")
# Opcode, length, checksum of all before it.
DATA_END = struct.Struct("<BQI")
HEAD = (Opcode.HEADER, Opcode.METADATA, Opcode.ATTACHMENT)

TORN = (McapError, zstandard.ZstdError, struct.error, ValueError, KeyError, OverflowError)
"""What reading a record raises that is not whole."""


class StoredMcap:
    """Reads what is whole in a file written by `McapFile`.

    A tail that was torn by a crash is no fault: nothing in it was acknowledged.

    Attributes:
        path: The file; it may be missing.
        faults: What is damaged before the end, as far as `messages` has come.
    """

    def __init__(self, path: Path) -> None:
        """Take the path; nothing is read yet."""
        self.path = path
        self.faults: List[Message] = []
        self._schemas: Dict[int, Schema] = {}
        self._channels: Dict[int, Channel] = {}

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield every message of the whole chunks, in the order of the file."""
        self.faults, self._schemas, self._channels = [], {}, {}
        content = mapped(self.path)
        place = len(MAGIC)
        if content[:place] != MAGIC and len(content) >= place:
            self.faults.append(
                Message("{file} does not begin like an MCAP file", file=self.path.name)
            )
        while place < len(content):
            try:
                opcode, data, end = _record(content, place)
                if opcode == Opcode.DATA_END:
                    self._check_sum(content, place, data)
                    return
                found = self._messages(opcode, data)
            except TORN as error:
                place = self._next_chunk(content, place, str(error) or type(error).__name__)
                continue
            yield from found
            place = end

    def frame_faults(self) -> List[Message]:
        """Return what is damaged anywhere in the file, by its two checksums, if it was finished."""
        content = mapped(self.path)
        footer = len(content) - len(MAGIC) - FOOTER.size
        if footer < len(MAGIC) or content[-len(MAGIC) :] != MAGIC:
            return []  # `messages` has found all that is there
        opcode, size, start, _offset_start, expected = FOOTER.unpack(
            content[footer : footer + FOOTER.size]
        )
        covered = memoryview(content)[start : footer + FOOTER.size - 4]
        if (opcode, size) != (Opcode.FOOTER, FOOTER.size - 9) or zlib.crc32(covered) != expected:
            return [damaged(self.path, "the checksum of its summary is wrong")]
        # A damaged length can hide the end of the data from `messages`.
        data = memoryview(content)[: start - DATA_END.size]
        end = DATA_END.unpack(content[len(data) : start])
        if end in ((Opcode.DATA_END, 4, 0), (Opcode.DATA_END, 4, zlib.crc32(data))):
            return []
        return [damaged(self.path, "the checksum of its data is wrong")]

    def _messages(self, opcode: int, data: bytes) -> List[RecordedMessage]:
        if opcode in HEAD or opcode == Opcode.MESSAGE_INDEX:
            return []
        if opcode != Opcode.CHUNK:
            raise ValueError(f"a record of kind {opcode} is where a chunk should be")
        messages = []
        for record in breakup_chunk(uncompressed(data)):
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._channels[record.id] = record
            elif isinstance(record, McapMessage):
                messages.append(self._message(record))
        return messages

    def _message(self, message: McapMessage) -> RecordedMessage:
        channel = self._channels[message.channel_id]
        return recorded_message(self._schemas[channel.schema_id], channel, message)

    def _check_sum(self, content: bytes, end: int, data: bytes) -> None:
        expected = DataEnd.read(_stream(data)).data_section_crc
        if not self.faults and expected not in (0, zlib.crc32(memoryview(content)[:end])):
            self.faults.append(damaged(self.path, "its checksum is wrong"))

    def _next_chunk(self, content: bytes, place: int, reason: str) -> int:
        """Return where the next whole chunk begins; a torn tail has none."""
        start = place + 1
        while True:
            found = content.find(COMPRESSION, start + COMPRESSION_PLACE)
            if found < 0:
                return len(content)
            start = found - COMPRESSION_PLACE
            if _is_chunk(content, start):
                self.faults.append(damaged(self.path, f"byte {place}: {reason}"))
                return start
            start += 1


def recorded_message(schema: Schema, channel: Channel, message: McapMessage) -> RecordedMessage:
    """Return a message of an MCAP file."""
    return RecordedMessage(
        channel.topic,
        schema.name,
        channel.metadata.get("md5sum", ""),
        schema.data.decode(),
        message.data,
        message.log_time,
        channel.metadata.get("latching") == "1",
    )


def read_attachment(path: Path, name: str) -> Optional[bytes]:
    """Return an attachment before the first chunk, if it is there and its checksum is right.

    Raises:
        OSError: The file cannot be read.
    """
    content = mapped(path)
    place = len(MAGIC)
    with contextlib.suppress(*TORN):
        while True:
            opcode, data, end = _record(content, place)
            if opcode not in HEAD:
                return None
            if opcode == Opcode.ATTACHMENT:
                found = Attachment.read(_stream(data))
                # The library reads over the checksum of an attachment, but writes it.
                if found.name == name and _written(found) == content[place:end]:
                    return bytes(found.data)
            place = end
    return None


def _written(record: Attachment) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def _record(content: bytes, place: int) -> Tuple[int, bytes, int]:
    if place + 9 > len(content):
        raise ValueError("a record is torn")
    opcode, size = struct.unpack("<BQ", content[place : place + 9])
    end = place + 9 + size
    if end > len(content):
        raise ValueError("a record is torn")
    if size > MAX_RECORD_BYTES:
        raise ValueError(f"a record claims {size} bytes")
    return opcode, content[place + 9 : end], end


def uncompressed(data: bytes) -> Chunk:
    """Return the chunk of a record's content, unpacked; raises one of `TORN` if it is not whole."""
    chunk = Chunk.read(_stream(data))
    # The size in the frame is checked first: a damaged one must not fill the memory.
    if chunk.compression != "zstd" or chunk.uncompressed_size > MAX_RECORD_BYTES:
        raise ValueError("the storage does not write such chunks")
    if zstandard.frame_content_size(chunk.data) != chunk.uncompressed_size:
        raise ValueError("the size of a chunk is wrong")
    content = zstandard.decompress(chunk.data)
    if zlib.crc32(content) != chunk.uncompressed_crc:
        raise ValueError("the checksum of a chunk is wrong")
    return replace(chunk, compression="", data=content)


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(data))


def _is_chunk(content: bytes, place: int) -> bool:
    try:
        opcode, data, _ = _record(content, place)
        return opcode == Opcode.CHUNK and bool(uncompressed(data).data)
    except TORN:
        return False

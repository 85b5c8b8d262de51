"""Reading an MCAP file that may be torn or damaged."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
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

from gpr20_survey.recording.mcap_writer import MAGIC, McapFile, McapTypes, packed
from gpr20_survey.recording.recording import MAX_RECORD_BYTES, RecordedMessage
from gpr20_survey.recording.stored_recording import mapped

# The name of the compression, behind opcode, length, two times, size and checksum.
COMPRESSION, COMPRESSION_PLACE = b"\x04\0\0\0zstd", 37

# Makes an empty file of the same survey at a path.
McapFactory = Callable[[Path], McapFile]
# What stands before the chunks; the attachment has a checksum, which its form contains.
HEAD_RECORDS: Dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.METADATA: Metadata,
    Opcode.ATTACHMENT: Attachment,
}

_TORN = (McapError, zstandard.ZstdError, struct.error, ValueError, KeyError, OverflowError)


class StoredMcap:
    """Implements `StoredRecording` for a file written by `McapFile`."""

    has_checksums = True

    def __init__(self, path: Path, create: McapFactory) -> None:
        """Take the path; nothing is read yet."""
        self.path = path
        self.faults: List[str] = []
        self._create = create
        self._types = McapTypes()
        self._end = 0
        self._crc = 0
        self._chunks = 0

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield every message of the whole chunks, in the order of the file."""
        self.faults, self._types = [], McapTypes()
        self._end = self._crc = self._chunks = 0
        content = mapped(self.path)
        place = len(MAGIC)
        if content[:place] != MAGIC and len(content) >= place:
            self.faults.append(f"{self.path.name} does not begin as an MCAP file does")
        while place < len(content):
            try:
                found, next_place = self._step(content, place)
            except _TORN as error:
                place = self._next_chunk(content, place, str(error) or type(error).__name__)
                continue
            if next_place > place:
                self._accept(content, next_place)
            yield from found
            if next_place == place:
                break  # the end of the data section
            place = next_place

    def resume(self) -> McapFile:
        """Cut off what follows the last whole chunk and go on there."""
        if not self._chunks:
            # Killed at its very beginning: perhaps not even the head is there.
            self.path.unlink(missing_ok=True)
            return self._create(self.path)
        return McapFile.resumed(self.path, self._end, self._types, self._crc)

    def create(self, path: Path) -> McapFile:
        """Begin an empty file of the same survey elsewhere."""
        return self._create(path)

    def _accept(self, content: bytes, end: int) -> None:
        self._crc = zlib.crc32(content[self._end : end], self._crc)
        self._end = end

    def _step(self, content: bytes, place: int) -> Tuple[List[RecordedMessage], int]:
        """Return the messages of the record at a place and where the next step begins."""
        opcode, data, end = _record(content, place)
        if opcode == Opcode.DATA_END:
            self._check_sum(data)
            return [], place
        if opcode in HEAD_RECORDS:
            _check_form(content[place:end], HEAD_RECORDS[opcode].read(_stream(data)))
            return [], end
        if opcode != Opcode.CHUNK:
            raise ValueError(f"a record of kind {opcode} stands where a chunk should")
        messages, expected = self._content(data)
        _check_chunk(content[place:end], data, messages)
        found: Dict[int, List[Tuple[int, int]]] = {}
        while len(found) < len(expected):
            place = end
            opcode, data, end = _record(content, place)
            if opcode != Opcode.MESSAGE_INDEX:
                raise ValueError("a chunk has no message index")
            index = MessageIndex.read(_stream(data))
            _check_form(content[place:end], index)
            found[index.channel_id] = index.records
        if found != expected:
            raise ValueError("a chunk and its message index contradict each other")
        self._chunks += 1
        return messages, end

    def _check_sum(self, data: bytes) -> None:
        expected = DataEnd.read(_stream(data)).data_section_crc
        if not self.faults and expected not in (0, self._crc):
            self.faults.append(f"{self.path.name} is damaged: its checksum is another")

    def _content(
        self, data: bytes
    ) -> Tuple[List[RecordedMessage], Dict[int, List[Tuple[int, int]]]]:
        content = _uncompressed(data)
        messages: List[RecordedMessage] = []
        entries: Dict[int, List[Tuple[int, int]]] = {}
        place = 0
        while place < len(content):
            opcode, data, end = _record(content, place)
            stream = _stream(data)
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self._types.schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(stream)
                self._types.channels[channel.id] = channel
            elif opcode == Opcode.MESSAGE:
                message = Message.read(stream, len(data))
                messages.append(self._message(message))
                entries.setdefault(message.channel_id, []).append((message.log_time, place))
            else:
                raise ValueError(f"a chunk holds a record of kind {opcode}")
            place = end
        return messages, entries

    def _message(self, message: Message) -> RecordedMessage:
        channel = self._types.channels[message.channel_id]
        schema = self._types.schemas[channel.schema_id]
        counts = self._types.counts
        counts[channel.id] = max(counts.get(channel.id, 0), message.sequence)
        return RecordedMessage(
            channel.topic,
            schema.name,
            channel.metadata.get("md5sum", ""),
            schema.data.decode(),
            message.data,
            message.log_time,
            channel.metadata.get("latching") == "1",
        )

    def _next_chunk(self, content: bytes, place: int, reason: str) -> int:
        """Return where the next whole chunk begins; a torn tail has none."""
        start = place + 1
        while True:
            found = content.find(COMPRESSION, start + COMPRESSION_PLACE)
            if found < 0:
                return len(content)
            start = found - COMPRESSION_PLACE
            if _is_chunk(content, start):
                self.faults.append(f"{self.path.name} is damaged at byte {place}: {reason}")
                return start
            start += 1


def read_attachment(path: Path, name: str) -> Optional[bytes]:
    """Return an attachment before the first chunk, if it is there and its checksum is right.

    Raises:
        OSError: The file cannot be read.
    """
    content = mapped(path)
    place = len(MAGIC)
    try:
        while True:
            opcode, data, end = _record(content, place)
            if opcode not in HEAD_RECORDS:
                return None
            record = HEAD_RECORDS[opcode].read(_stream(data))
            if opcode == Opcode.ATTACHMENT and record.name == name:
                _check_form(content[place:end], record)
                return bytes(record.data)
            place = end
    except _TORN:
        return None


def _record(content: bytes, place: int) -> Tuple[int, bytes, int]:
    if place + 9 > len(content):
        raise ValueError("a record is torn")
    opcode, size = struct.unpack("<BQ", content[place : place + 9])
    end = place + 9 + size
    if end > len(content):
        raise ValueError("a record is torn")
    if size > MAX_RECORD_BYTES:
        raise ValueError(f"a record says that it has {size} bytes")
    return opcode, content[place + 9 : end], end


def _uncompressed(data: bytes) -> bytes:
    chunk = Chunk.read(_stream(data))
    # The size is asked of the frame first: a damaged one must not fill the memory.
    if chunk.compression != "zstd" or chunk.uncompressed_size > MAX_RECORD_BYTES:
        raise ValueError("a chunk is not as the storage writes it")
    if zstandard.frame_content_size(chunk.data) != chunk.uncompressed_size:
        raise ValueError("a chunk has another size than it says")
    content = zstandard.decompress(chunk.data)
    if zlib.crc32(content) != chunk.uncompressed_crc:
        raise ValueError("the checksum of a chunk is wrong")
    return content


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(data))


def _check_chunk(written: bytes, data: bytes, messages: List[RecordedMessage]) -> None:
    times = [message.time_ns for message in messages]
    chunk = replace(
        Chunk.read(_stream(data)), message_start_time=min(times), message_end_time=max(times)
    )
    _check_form(written, chunk)


def _check_form(written: bytes, record: McapRecord) -> None:
    """Refuse a record that is not as `McapFile` writes it: other readers stumble over less."""
    if written != packed(record):
        raise ValueError("a record has another form than the storage writes")


def _is_chunk(content: bytes, place: int) -> bool:
    try:
        opcode, data, _ = _record(content, place)
        return opcode == Opcode.CHUNK and bool(_uncompressed(data))
    except _TORN:
        return False

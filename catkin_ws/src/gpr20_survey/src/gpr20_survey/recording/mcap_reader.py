"""Reading the recording of a survey: whole, torn or damaged, or a single trace of it.

The library's readers end at a fault, and hold or sort what is behind it.
"""

from __future__ import annotations

import contextlib
import io
import mmap
import os
import struct
import zlib
from bisect import bisect_left
from pathlib import Path
from typing import Any, BinaryIO, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, ChunkIndex, DataEnd, McapRecord, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader

from gpr20_common.message import Message
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.recording.mcap_writer import MAGIC
from gpr20_survey.recording.recording import MAX_RECORD_BYTES, RecordedMessage
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

# The name of the compression, behind opcode, length, two times, size and checksum.
COMPRESSION, COMPRESSION_PLACE = b"\x04\0\0\0zstd", 37
# Opcode, length, start of the summary and of its offsets, checksum of the summary.
FOOTER = struct.Struct("<BQQQI")
# Opcode, length, checksum of all before it.
DATA_END = struct.Struct("<BQI")
# Opcode and length of a record, and the channel with which the index of a chunk's messages begins.
RECORD = struct.Struct("<BQ")
RECORD_AND_CHANNEL = struct.Struct("<BQH")
# Channel, number, and two times of a message, before its data.
MESSAGE = struct.Struct("<HIQQ")
END_BYTES = FOOTER.size + len(MAGIC)
HEAD = (Opcode.HEADER, Opcode.METADATA, Opcode.ATTACHMENT)
DEFINITIONS: Dict[int, Any] = {Opcode.SCHEMA: Schema, Opcode.CHANNEL: Channel}
GUESSES = 2

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
        self._channels: Dict[int, RecordedMessage] = {}  # what its messages have in common

    def messages(self, datatype: str = "") -> Iterator[RecordedMessage]:
        """Yield every message of the whole chunks, in the order of the file.

        Args:
            datatype: Type of the messages; empty: of all types.
        """
        self.faults, self._schemas, self._channels = [], {}, {}
        content = _mapped(self.path)
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
                found = self._messages(opcode, data, datatype)
            except TORN as error:
                place = self._next_chunk(content, place, str(error) or type(error).__name__)
                continue
            yield from found
            place = end

    def is_finished(self) -> bool:
        """Return whether the file has its end."""
        return _mapped(self.path)[-len(MAGIC) :] == MAGIC

    def frame_faults(self) -> List[Message]:
        """Return what is damaged anywhere in the file, by its two checksums, if it was finished."""
        content = _mapped(self.path)
        footer = len(content) - len(MAGIC) - FOOTER.size
        if footer < len(MAGIC) or not self.is_finished():
            return []  # `messages` has found all that is there
        opcode, size, start, _offset_start, expected = FOOTER.unpack(
            content[footer : footer + FOOTER.size]
        )
        found = zlib.crc32(memoryview(content)[start : footer + FOOTER.size - 4])
        if (opcode, size, found) != (Opcode.FOOTER, FOOTER.size - RECORD.size, expected):
            return [_damaged(self.path, "the checksum of its summary is wrong")]
        # A damaged length can hide the end of the data from `messages`.
        data = memoryview(content)[: start - DATA_END.size]
        end = DATA_END.unpack(content[len(data) : start])
        if end in ((Opcode.DATA_END, 4, 0), (Opcode.DATA_END, 4, zlib.crc32(data))):
            return []
        return [_damaged(self.path, "the checksum of its data is wrong")]

    def _messages(self, opcode: int, data: bytes, datatype: str) -> List[RecordedMessage]:
        if opcode in HEAD or opcode == Opcode.MESSAGE_INDEX:
            return []
        if opcode != Opcode.CHUNK:
            raise ValueError(f"a record of kind {opcode} is where a chunk should be")
        messages = []
        for kind, content in _records_in(_unpacked(data)):
            if kind == Opcode.SCHEMA:
                schema = Schema.read(_stream(content))
                self._schemas[schema.id] = schema
            elif kind == Opcode.CHANNEL:
                channel = Channel.read(_stream(content))
                self._channels[channel.id] = _common(self._schemas[channel.schema_id], channel)
            elif kind == Opcode.MESSAGE:
                number, _count, time_ns, _published_ns = MESSAGE.unpack_from(content)
                common = self._channels[number]
                if datatype in ("", common.datatype):
                    messages.append(_of(common, content[MESSAGE.size :], time_ns))
        return messages

    def _check_sum(self, content: bytes, end: int, data: bytes) -> None:
        expected = DataEnd.read(_stream(data)).data_section_crc
        if not self.faults and expected not in (0, zlib.crc32(memoryview(content)[:end])):
            self.faults.append(_damaged(self.path, "its checksum is wrong"))

    def _next_chunk(self, content: bytes, place: int, reason: str) -> int:
        """Return where the next whole chunk begins; a torn tail has none."""
        start = place + 1
        while True:
            found = content.find(COMPRESSION, start + COMPRESSION_PLACE)
            if found < 0:
                return len(content)
            start = found - COMPRESSION_PLACE
            if _is_chunk(content, start):
                self.faults.append(_damaged(self.path, f"byte {place}: {reason}"))
                return start
            start += 1


def recorded_message(schema: Schema, channel: Channel, message: McapMessage) -> RecordedMessage:
    """Return a message that the library has read."""
    return _of(_common(schema, channel), message.data, message.log_time)


def _common(schema: Schema, channel: Channel) -> RecordedMessage:
    return RecordedMessage(
        channel.topic,
        schema.name,
        channel.metadata.get("md5sum", ""),
        schema.data.decode(),
        b"",
        0,
        channel.metadata.get("latching") == "1",
    )


def _of(one: RecordedMessage, data: bytes, time_ns: int) -> RecordedMessage:
    return RecordedMessage(
        one.topic, one.datatype, one.md5sum, one.definition, data, time_ns, one.latching
    )


def read_attachment(path: Path, name: str) -> Optional[bytes]:
    """Return an attachment before the first chunk, if it is there and its checksum is right.

    Raises:
        OSError: The file cannot be read.
    """
    content = _mapped(path)
    place = len(MAGIC)
    with contextlib.suppress(*TORN):
        while True:
            opcode, data, end = _record(content, place)
            if opcode not in HEAD:
                return None
            if opcode == Opcode.ATTACHMENT:
                found = Attachment.read(_stream(data))
                # The library reads over the checksum of an attachment, but writes it.
                is_whole = zlib.crc32(data[:-4]) == int.from_bytes(data[-4:], "little")
                if is_whole and found.name == name:
                    return bytes(found.data)
            place = end
    return None


def _record(content: bytes, place: int) -> Tuple[int, bytes, int]:
    start = place + RECORD.size
    if start > len(content):
        raise ValueError("a record is torn")
    opcode, size = RECORD.unpack(content[place:start])
    end = start + size
    if end > len(content):
        raise ValueError("a record is torn")
    if size > MAX_RECORD_BYTES:
        raise ValueError(f"a record claims {size} bytes")
    return opcode, content[start:end], end


def _unpacked(data: bytes) -> bytes:
    """Return what a chunk holds, by the content of its record.

    Raises:
        ValueError: Or another of `TORN`: it is not whole.
    """
    chunk = Chunk.read(_stream(data))
    # The size in the frame is checked first: a damaged one must not fill the memory.
    if chunk.compression != "zstd" or chunk.uncompressed_size > MAX_RECORD_BYTES:
        raise ValueError("the storage does not write such chunks")
    if zstandard.frame_content_size(chunk.data) != chunk.uncompressed_size:
        raise ValueError("the size of a chunk is wrong")
    content = zstandard.decompress(chunk.data)
    if zlib.crc32(content) != chunk.uncompressed_crc:
        raise ValueError("the checksum of a chunk is wrong")
    return content


def _records_in(content: bytes) -> Iterator[Tuple[int, bytes]]:
    """Yield the kind and the content of each record of an unpacked chunk."""
    place = 0
    while place < len(content):
        kind, size = RECORD.unpack_from(content, place)
        place += RECORD.size
        yield kind, content[place : place + size]
        place += size


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(data))


def _is_chunk(content: bytes, place: int) -> bool:
    try:
        opcode, data, _ = _record(content, place)
        return opcode == Opcode.CHUNK and bool(_unpacked(data))
    except TORN:
        return False


def _damaged(path: Path, details: str) -> Message:
    return Message("{file} is damaged", file=path.name, details=details)


def _mapped(path: Path) -> bytes:
    """Return the content of a file, read as it is looked at; empty if it is missing.

    Raises:
        OSError: The file cannot be read.
    """
    try:
        descriptor = open_regular(path)
    except FileNotFoundError:
        return b""
    try:
        size = os.fstat(descriptor).st_size
        # A slice of a map is bytes, which is all that the readers need.
        return mmap.mmap(descriptor, size, prot=mmap.PROT_READ) if size else b""  # type: ignore
    finally:
        os.close(descriptor)


class McapTraces:
    """Where the traces are in a file written by `McapFile`: each has a chunk of its own.

    They are nearly always in the order of the plan, so that a trace is where its rank among the
    stored ones says, shifted by those that were stored later. One that is elsewhere is not found.

    The file is read and not mapped: a map that waits for the disk holds up every other thread.
    """

    def __init__(self, path: Path, indices: Sequence[int]) -> None:
        """Read the summary of the file; while it is written, the heads of its records.

        Args:
            path: The file; it may be missing, unreadable, torn or damaged.
            indices: Places in the plan of the stored traces, ascending.
        """
        self._path, self._indices = path, indices
        self._shift = 0
        self._schemas: Dict[int, str] = {}
        self._md5sums: Dict[int, Optional[str]] = {}  # of each channel; None: not of traces
        self._chunks: List[Tuple[int, int]] = []  # place and length of those with a trace
        with self._opened() as file, contextlib.suppress(OSError, *TORN):
            if not self._read_summary(file.fileno()):
                self._walk(file.fileno())

    @contextlib.contextmanager
    def finder(self) -> Iterator[Callable[[int], Optional[Trace]]]:
        """Open the file; give a function that returns the trace of a place in the plan.

        It returns None if the trace is not where it should be, or is not whole.
        """
        with self._opened() as file:
            yield lambda index: self._find(file.fileno(), index)

    def _opened(self) -> BinaryIO:
        try:
            return open(open_regular(self._path), "rb")
        except OSError:
            return open(os.devnull, "rb")

    def _find(self, descriptor: int, index: int) -> Optional[Trace]:
        rank = bisect_left(self._indices, index)
        for _guess in range(GUESSES):
            number = rank + self._shift
            trace = self._read(descriptor, number)
            if trace is None or trace.index == index:
                return trace
            self._shift = number - bisect_left(self._indices, trace.index)
        return None

    def _read(self, descriptor: int, number: int) -> Optional[Trace]:
        if not 0 <= number < len(self._chunks):
            return None
        try:
            for kind, content in _records_of(descriptor, self._chunks[number]):
                if kind == Opcode.MESSAGE:
                    md5sum = self._md5sums.get(MESSAGE.unpack_from(content)[0])
                    data = content[MESSAGE.size :]
                    return None if md5sum is None else trace_message.decode(data, md5sum)
        except (OSError, TraceRefusedError, *TORN):
            return None  # its JSON file decides, and says why
        return None

    def _read_summary(self, descriptor: int) -> bool:
        size = os.fstat(descriptor).st_size
        end = os.pread(descriptor, END_BYTES, max(0, size - END_BYTES))
        if len(end) < END_BYTES or not end.endswith(MAGIC):
            return False
        *_head, start, _offsets, expected = FOOTER.unpack(end[: FOOTER.size])
        if not END_BYTES <= size - start <= MAX_RECORD_BYTES:
            return False
        summary = os.pread(descriptor, size - start, start)
        if zlib.crc32(summary[: -len(MAGIC) - 4]) != expected:
            return False
        for record in StreamReader(io.BytesIO(summary), skip_magic=True).records:
            if not isinstance(record, ChunkIndex):
                self._note(record)
            elif any(self._md5sums.get(one) is not None for one in record.message_index_offsets):
                self._chunks.append((record.chunk_start_offset, record.chunk_length))
        return True

    def _walk(self, descriptor: int) -> None:
        """Find the chunks up to the torn end, which raises one of `TORN`."""
        place, chunk = len(MAGIC), (0, 0)
        while True:
            head = os.pread(descriptor, RECORD_AND_CHANNEL.size, place)
            opcode, size, channel = RECORD_AND_CHANNEL.unpack(head)
            size += RECORD.size
            if opcode == Opcode.CHUNK:
                chunk = place, size
            elif opcode == Opcode.MESSAGE_INDEX:
                if channel not in self._md5sums:
                    # Its definition is in the chunk that uses it first.
                    for kind, content in _records_of(descriptor, chunk):
                        if kind in DEFINITIONS:
                            self._note(DEFINITIONS[kind].read(_stream(content)))
                if self._md5sums[channel] is not None:
                    self._chunks.append(chunk)
            elif opcode not in HEAD:
                return
            place += size

    def _note(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif isinstance(record, Channel):
            is_trace = self._schemas.get(record.schema_id) == trace_message.DATATYPE
            self._md5sums[record.id] = record.metadata.get("md5sum", "") if is_trace else None


def _records_of(descriptor: int, chunk: Tuple[int, int]) -> Iterator[Tuple[int, bytes]]:
    place, size = chunk
    # A size that is wrong must not fill the memory.
    if size > MAX_RECORD_BYTES:
        raise ValueError(f"a chunk claims {size} bytes")
    return _records_in(_unpacked(os.pread(descriptor, size, place)[RECORD.size :]))

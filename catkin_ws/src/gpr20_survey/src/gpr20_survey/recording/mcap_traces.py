"""Single traces of an MCAP file, found by its index without reading the others."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import zlib
from bisect import bisect_left
from pathlib import Path
from typing import BinaryIO, Callable, Dict, Iterator, List, Optional, Sequence, Tuple

from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, McapRecord, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader, breakup_chunk

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.recording.mcap_reader import FOOTER, HEAD, TORN, uncompressed
from gpr20_survey.recording.mcap_writer import MAGIC
from gpr20_survey.recording.recording import MAX_RECORD_BYTES
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace

# Opcode and length of a record, and the channel with which the index of a chunk's messages begins.
RECORD = struct.Struct("<BQ")
RECORD_AND_CHANNEL = struct.Struct("<BQH")
END_BYTES = FOOTER.size + len(MAGIC)
GUESSES = 2


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
            for message in _records_of(descriptor, self._chunks[number]):
                if isinstance(message, McapMessage):
                    md5sum = self._md5sums.get(message.channel_id)
                    return None if md5sum is None else trace_message.decode(message.data, md5sum)
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
                    for record in _records_of(descriptor, chunk):
                        self._note(record)
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


def _records_of(descriptor: int, chunk: Tuple[int, int]) -> List[McapRecord]:
    place, size = chunk
    # A size that is wrong must not fill the memory.
    if size > MAX_RECORD_BYTES:
        raise ValueError(f"a chunk claims {size} bytes")
    return breakup_chunk(uncompressed(os.pread(descriptor, size, place)[RECORD.size :]))

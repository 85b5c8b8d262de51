"""Reading a bag that may be torn or damaged."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Dict, Iterator, List, Tuple

from gpr20_survey.recording import bag_format
from gpr20_survey.recording.bag_format import BagFormatError, Connection, Entry, Record
from gpr20_survey.recording.bag_writer import EMPTY_CHUNK, BagFile
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.stored_recording import mapped

# How every chunk begins, behind the length of its header.
CHUNK_START = EMPTY_CHUNK[4 : EMPTY_CHUNK.index(b"none") + 4]


class StoredBag:
    """Implements `StoredRecording` for a bag written by `BagFile`."""

    has_checksums = False

    def __init__(self, path: Path) -> None:
        """Take the path; nothing is read yet."""
        self.path = path
        self.faults: List[str] = []
        self._connections: Dict[int, Connection] = {}
        self._end = 0

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield every message of the whole chunks, in the order of the file."""
        self.faults, self._connections = [], {}
        content = mapped(self.path)
        place = self._end = bag_format.DATA_START
        if len(content) < place:
            self._end = 0
            return
        if content[:13] != bag_format.MAGIC:
            self.faults.append(f"{self.path.name} does not begin as a bag does")
        while place < len(content):
            try:
                found, place = self._chunk(content, place)
            except BagFormatError as error:
                place = self._next_chunk(content, place, str(error))
                continue
            if found:
                self._end = place
            yield from found

    def resume(self) -> BagFile:
        """Cut off what follows the last whole chunk and go on there."""
        if not self._end:
            # Killed at its very beginning: not even the header is there.
            self.path.unlink(missing_ok=True)
            return BagFile(self.path)
        return BagFile.resumed(self.path, self._end, self._connections.values())

    def create(self, path: Path) -> BagFile:
        """Begin an empty bag elsewhere."""
        return BagFile(path)

    def _chunk(self, content: bytes, place: int) -> Tuple[List[RecordedMessage], int]:
        chunk = bag_format.read_record(content, place)
        if chunk.kind in (bag_format.CONNECTION, bag_format.CHUNK_INFO):
            return [], len(content)  # the index of the whole file; nothing comes behind it
        if chunk.kind != bag_format.CHUNK or chunk.number("size") != len(chunk.data):
            raise BagFormatError("a chunk is not whole")
        _check_form(content, place, chunk, bag_format.chunk_record(chunk.data))
        messages, expected = self._content(chunk.data)
        place = chunk.end
        found: Dict[int, List[Entry]] = {}
        while len(found) < len(expected):
            index = bag_format.read_record(content, place)
            if index.kind != bag_format.INDEX:
                raise BagFormatError("a chunk has no index")
            number, entries = index.number("conn"), bag_format.read_index(index)
            _check_form(content, place, index, bag_format.index_record(number, entries))
            found[number] = entries
            place = index.end
        if found != {number: sorted(entries) for number, entries in expected.items()}:
            raise BagFormatError("a chunk and its index contradict each other")
        return messages, place

    def _content(self, data: bytes) -> Tuple[List[RecordedMessage], Dict[int, List[Entry]]]:
        messages: List[RecordedMessage] = []
        entries: Dict[int, List[Entry]] = {}
        place = 0
        while place < len(data):
            one = bag_format.read_record(data, place)
            if one.kind == bag_format.CONNECTION:
                connection = bag_format.read_connection(one)
                _check_form(data, place, one, bag_format.connection_record(connection))
                if self._connections.setdefault(connection.number, connection) != connection:
                    raise BagFormatError("a connection is told twice")
            elif one.kind == bag_format.MESSAGE:
                message, number = self._message(one), one.number("conn")
                _check_form(data, place, one, bag_format.message_record(number, message))
                messages.append(message)
                entries.setdefault(number, []).append((message.time_ns, place))
            else:
                raise BagFormatError("a chunk holds a strange record")
            place = one.end
        return messages, entries

    def _message(self, one: Record) -> RecordedMessage:
        connection = self._connections.get(one.number("conn"))
        if connection is None:
            raise BagFormatError("a message belongs to no connection")
        return RecordedMessage(
            connection.topic,
            connection.datatype,
            connection.md5sum,
            connection.definition,
            one.data,
            one.time_ns("time"),
            connection.latching,
        )

    def _next_chunk(self, content: bytes, place: int, reason: str) -> int:
        """Return where the next whole chunk begins; a torn tail has none."""
        start = place
        while True:
            found = content.find(CHUNK_START, start + 5)
            start = found - 4
            if found < 0:
                return len(content)
            if _is_chunk(content, start):
                self.faults.append(f"{self.path.name} is damaged at byte {place}: {reason}")
                return start


def _check_form(content: bytes, place: int, one: Record, written: bytes) -> None:
    """Refuse a record that is not as `BagFile` writes it: other readers stumble over less."""
    if content[place : one.end] != written:
        raise BagFormatError("a record has another form than the storage writes")


def _is_chunk(content: bytes, place: int) -> bool:
    try:
        chunk = bag_format.read_record(content, place)
        # The empty chunk ends every bag and says nothing of what was before it.
        return bool(chunk.data) and len(chunk.data) == chunk.number("size")
    except (BagFormatError, struct.error):
        return False

"""Reading a bag that may be torn or damaged."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Dict, Iterator, List, Optional, Tuple

from gpr20_common.message import Message
from gpr20_survey.recording import bag_format
from gpr20_survey.recording.bag_format import BagFormatError, Connection, Indexes, Record
from gpr20_survey.recording.bag_writer import EMPTY_CHUNK, BagFile, connection_key
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.stored_recording import damaged, mapped

# How every chunk begins, behind the length of its header.
CHUNK_START = EMPTY_CHUNK[4 : EMPTY_CHUNK.index(b"none") + 4]


class StoredBag:
    """Implements `StoredRecording` for a bag written by `BagFile`."""

    has_checksums = False

    def __init__(self, path: Path) -> None:
        """Take the path; nothing is read yet."""
        self.path = path
        self.faults: List[Message] = []
        self._begin()

    def _begin(self) -> None:
        # Of the whole chunks alone: damaged bytes must not affect what follows.
        self._connections: Dict[int, Connection] = {}
        self._chunk_infos: List[bytes] = []
        self._end = 0  # where their last index ends; 0 without a head [bytes]

    def resume(self) -> Optional[BagFile]:
        """Continue the file behind the last whole chunk, after `messages` has come to the end.

        Returns:
            None, and nothing is changed, if it is not a bag that `BagFile` could have begun.

        Raises:
            OSError: The disk refused; the call may be repeated.
        """
        connections = list(self._connections.values())
        different = len(set(map(connection_key, connections))) == len(connections)
        if not self._end or not different or [*self._connections] != [*range(len(connections))]:
            return None
        return BagFile.resumed(self.path, self._end, connections, self._chunk_infos)

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield every message of the whole chunks, in the order of the file."""
        self.faults = []
        self._begin()
        content = mapped(self.path)
        place = bag_format.DATA_START
        if len(content) < place:
            return
        if content[:13] != bag_format.MAGIC:
            self.faults.append(Message("{file} does not begin like a bag", file=self.path.name))
        self._end = place
        while place < len(content):
            try:
                found, place = self._chunk(content, place)
            except BagFormatError as error:
                place = self._next_chunk(content, place, str(error))
                continue
            yield from found

    def frame_faults(self) -> List[Message]:
        """Return what is damaged before and behind the chunks; `messages` must have ended.

        Behind the last whole chunk of a bag that was not finished, a crash may leave anything.
        """
        content = mapped(self.path)
        if len(content) < bag_format.DATA_START or not self._end:
            return []
        header = content[len(bag_format.MAGIC) : bag_format.DATA_START]
        index_place = self._end + len(EMPTY_CHUNK)
        connections = list(map(bag_format.connection_record, self._connections.values()))
        index = b"".join([*connections, *self._chunk_infos])
        finished = bag_format.file_header(index_place, len(connections), len(self._chunk_infos))
        if header == bag_format.file_header(0, 0, 0) or (
            header == finished and content[self._end :] == EMPTY_CHUNK + index
        ):
            return []
        return [damaged(self.path, "its header or its index is wrong")]

    def _chunk(self, content: bytes, place: int) -> Tuple[List[RecordedMessage], int]:
        """Return the messages of the chunk at a place and where the next one begins."""
        chunk = bag_format.read_record(content, place)
        if chunk.kind in (bag_format.CONNECTION, bag_format.CHUNK_INFO):
            return [], len(content)  # the index of the whole file; nothing comes behind it
        if content[place : chunk.end] != bag_format.chunk_record(chunk.data):
            raise BagFormatError("a chunk is not as the storage writes it")
        messages, indexes, connections = self._content(chunk.data)
        index = bag_format.index_records(indexes)
        end = chunk.end + len(index)
        if content[chunk.end : end] != index:
            raise BagFormatError("a chunk and its index contradict each other")
        if messages:
            self._connections, self._end = connections, end
            self._chunk_infos.append(bag_format.chunk_info_record(place, indexes))
        return messages, end

    def _content(self, data: bytes) -> Tuple[List[RecordedMessage], Indexes, Dict[int, Connection]]:
        connections = dict(self._connections)
        messages: List[RecordedMessage] = []
        indexes: Indexes = {}
        place = 0
        while place < len(data):
            one = bag_format.read_record(data, place)
            if one.kind == bag_format.CONNECTION:
                connection = bag_format.read_connection(one)
                if data[place : one.end] != bag_format.connection_record(connection):
                    raise BagFormatError("a connection is not as the storage writes it")
                if connections.setdefault(connection.number, connection) != connection:
                    raise BagFormatError("a connection has two types")
            elif one.kind == bag_format.MESSAGE:
                messages.append(message_of(one, connections))
                indexes.setdefault(one.number("conn"), []).append((messages[-1].time_ns, place))
            else:
                raise BagFormatError("a chunk holds a record of an unknown kind")
            place = one.end
        return messages, indexes, connections

    def _next_chunk(self, content: bytes, place: int, reason: str) -> int:
        """Return where the next whole chunk begins; a torn tail has none."""
        start = place
        while True:
            found = content.find(CHUNK_START, start + 5)
            start = found - 4
            if found < 0:
                return len(content)
            if _is_chunk(content, start):
                self.faults.append(damaged(self.path, f"byte {place}: {reason}"))
                return start


def _is_chunk(content: bytes, place: int) -> bool:
    try:
        chunk = bag_format.read_record(content, place)
        # The empty chunk ends every bag and holds no information on what was before it.
        return bool(chunk.data) and len(chunk.data) == chunk.number("size")
    except (BagFormatError, struct.error):
        return False


def message_of(one: Record, connections: Dict[int, Connection]) -> RecordedMessage:
    """Return the message of a record.

    Raises:
        BagFormatError: It belongs to no connection.
    """
    connection = connections.get(one.number("conn"))
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

"""Records of a ROS bag, format 2.0 (http://wiki.ros.org/Bags/Format/2.0)."""

from __future__ import annotations

import struct
from typing import Dict, List, NamedTuple, Tuple

from gpr20_survey.recording.recording import MAX_RECORD_BYTES, RecordedMessage
from gpr20_survey.trace import utc_time

MAGIC = b"#ROSBAG V2.0\n"
# Of the file header with its padding, without the two lengths: rosbag writes it again at this
# size when it repairs a bag.
HEADER_BYTES = 4096
DATA_START = len(MAGIC) + HEADER_BYTES + 8

MESSAGE, FILE_HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7

Fields = Dict[str, bytes]
Entry = Tuple[int, int]  # time [ns], offset in the chunk [bytes]
Indexes = Dict[int, List[Entry]]  # of each connection of a chunk


class BagFormatError(ValueError):
    """Bytes are no record of a bag."""


class Connection(NamedTuple):
    """A topic with its type, as a bag numbers it."""

    number: int
    topic: str
    datatype: str
    md5sum: str
    definition: str
    latching: bool


class Record(NamedTuple):
    """One record and where the next one begins [bytes]."""

    fields: Fields
    data: bytes
    end: int

    @property
    def kind(self) -> int:
        """The record's op."""
        return self.number("op", "<B")

    def number(self, name: str, form: str = "<I") -> int:
        """Return a field that is a number.

        Raises:
            BagFormatError: There is no such field.
        """
        value = self.fields.get(name, b"")
        if len(value) != struct.calcsize(form):
            raise BagFormatError(f"field {name} is missing")
        return int(struct.unpack(form, value)[0])

    def time_ns(self, name: str) -> int:
        """Return a field that is a time [ns since 1970]."""
        return unpack_time(self.fields.get(name, b""))


def sized(data: bytes) -> bytes:
    """Return bytes behind their length."""
    return struct.pack("<I", len(data)) + data


def pack_time(time_ns: int) -> bytes:
    """Return a time [ns since 1970] as two numbers of 32 bits."""
    return struct.pack("<II", *divmod(time_ns, utc_time.NS_PER_S))


def unpack_time(data: bytes) -> int:
    """Return the time [ns since 1970] of eight bytes.

    Raises:
        BagFormatError: It is no time.
    """
    if len(data) != 8:
        raise BagFormatError("a time is missing")
    seconds, rest_ns = struct.unpack("<II", data)
    if rest_ns >= utc_time.NS_PER_S:
        raise BagFormatError(f"a time has {rest_ns} ns")
    return int(seconds * utc_time.NS_PER_S + rest_ns)


def pack_fields(fields: Fields) -> bytes:
    """Return name=value fields, each behind its length."""
    return b"".join(sized(name.encode() + b"=" + value) for name, value in fields.items())


def unpack_fields(data: bytes) -> Fields:
    """Return the fields of a header.

    Raises:
        BagFormatError: The bytes are no fields.
    """
    fields: Fields = {}
    place = 0
    while place < len(data):
        if place + 4 > len(data):
            raise BagFormatError("a header is torn")
        (size,) = struct.unpack_from("<I", data, place)
        place += 4
        name, equals, value = data[place : place + size].partition(b"=")
        if not equals or place + size > len(data):
            raise BagFormatError("a header is torn")
        fields[name.decode("latin-1")] = value
        place += size
    return fields


def record(op: int, fields: Fields, data: bytes) -> bytes:
    """Return a record."""
    return sized(pack_fields({"op": bytes([op]), **fields})) + sized(data)


def read_record(data: bytes, place: int) -> Record:
    """Return the record at a place.

    Raises:
        BagFormatError: There is no whole record.
    """
    parts = []
    for _ in range(2):
        if place + 4 > len(data):
            raise BagFormatError("a record is torn")
        (size,) = struct.unpack_from("<I", data, place)
        place += 4 + size
        if place > len(data):
            raise BagFormatError("a record is torn")
        if size > MAX_RECORD_BYTES:
            raise BagFormatError(f"a record claims {size} bytes")
        parts.append(data[place - size : place])
    return Record(unpack_fields(parts[0]), parts[1], place)


def file_header(index_place: int, connections: int, chunks: int) -> bytes:
    """Return the first record, padded; the place is 0 while there is no index."""
    fields = {
        "op": bytes([FILE_HEADER]),
        "index_pos": struct.pack("<Q", index_place),
        "conn_count": struct.pack("<I", connections),
        "chunk_count": struct.pack("<I", chunks),
    }
    header = pack_fields(fields)
    return sized(header) + sized(b" " * (HEADER_BYTES - len(header)))


def connection_record(connection: Connection) -> bytes:
    """Return the record that holds the type of a topic."""
    topic = connection.topic.encode()
    details = {
        "topic": topic,
        "type": connection.datatype.encode(),
        "md5sum": connection.md5sum.encode(),
        "message_definition": connection.definition.encode(),
        "latching": b"1" if connection.latching else b"0",
    }
    fields = {"conn": struct.pack("<I", connection.number), "topic": topic}
    return record(CONNECTION, fields, pack_fields(details))


def read_connection(one: Record) -> Connection:
    """Return the content of a connection record.

    Raises:
        BagFormatError: Something is missing in it.
    """
    details = unpack_fields(one.data)
    if details.get("topic") != one.fields.get("topic"):
        raise BagFormatError("a connection has two topics")
    try:
        return Connection(
            one.number("conn"),
            one.fields["topic"].decode(),
            details["type"].decode(),
            details["md5sum"].decode(),
            details["message_definition"].decode(),
            details.get("latching") == b"1",
        )
    except (KeyError, UnicodeDecodeError) as error:
        raise BagFormatError(f"a connection is incomplete: {error}") from error


def message_record(number: int, message: RecordedMessage) -> bytes:
    """Return the record of a message of a connection."""
    fields = {"conn": struct.pack("<I", number), "time": pack_time(message.time_ns)}
    return record(MESSAGE, fields, message.data)


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


def chunk_record(data: bytes) -> bytes:
    """Return a chunk without compression: noise does not compress."""
    fields = {"compression": b"none", "size": struct.pack("<I", len(data))}
    return record(CHUNK, fields, data)


def index_records(indexes: Indexes) -> bytes:
    """Return the index of each connection in the chunk before it."""
    return b"".join(_index_record(number, sorted(entries)) for number, entries in indexes.items())


def _index_record(number: int, entries: List[Entry]) -> bytes:
    fields = {
        "ver": struct.pack("<I", 1),
        "conn": struct.pack("<I", number),
        "count": struct.pack("<I", len(entries)),
    }
    data = b"".join(pack_time(time) + struct.pack("<I", offset) for time, offset in entries)
    return record(INDEX, fields, data)


def chunk_info_record(place: int, indexes: Indexes) -> bytes:
    """Return the record of a chunk in the index of the whole file."""
    times = [time for entries in indexes.values() for time, _ in entries]
    fields = {
        "ver": struct.pack("<I", 1),
        "chunk_pos": struct.pack("<Q", place),
        "start_time": pack_time(min(times)),
        "end_time": pack_time(max(times)),
        "count": struct.pack("<I", len(indexes)),
    }
    counts = (struct.pack("<II", number, len(entries)) for number, entries in indexes.items())
    return record(CHUNK_INFO, fields, b"".join(counts))

"""The traces of a survey's recordings, by readers that are not this project's."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, Iterator

import zstandard
from mcap.exceptions import McapError
from mcap.reader import McapReader, NonSeekingReader, make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

TRACE = "gpr20_msgs/msg/Trace"


def bag_traces(path: Path) -> Iterator[Any]:
    """Yield the messages of the traces in a bag that has its index."""
    with AnyReader([path]) as reader:
        connections = [one for one in reader.connections if one.topic == "/trace"]
        # Without any, the reader would return every message.
        if connections:
            for connection, _time, raw in reader.messages(connections):
                yield reader.deserialize(raw, connection.msgtype)


def mcap_traces(path: Path) -> Iterator[Any]:
    """Yield the messages of the traces in an MCAP file that has ended."""
    with path.open("rb") as file:
        yield from _messages_of(make_reader(file, validate_crcs=True))


def torn_mcap_traces(path: Path) -> Iterator[Any]:
    """Yield the same, read forward, without the index, up to where the file was torn."""
    with path.open("rb") as file:
        try:
            yield from _messages_of(NonSeekingReader(file))
        except (McapError, EOFError, struct.error, ValueError, zstandard.ZstdError):
            # Torn here; what was acknowledged must have come before.
            return


def _messages_of(reader: McapReader) -> Iterator[Any]:
    types = get_typestore(Stores.ROS1_NOETIC)
    for schema, _channel, message in reader.iter_messages(["/trace"], log_time_order=False):
        if schema is not None and TRACE not in types.types:
            types.register(get_types_from_msg(schema.data.decode(), TRACE))
        yield types.deserialize_ros1(message.data, TRACE)

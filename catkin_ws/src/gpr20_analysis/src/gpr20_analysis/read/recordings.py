"""The messages of a bag or an MCAP file.

Finished files are read by the standard libraries. Of a file that was cut off, all complete
messages are read.
"""

from __future__ import annotations

import contextlib
import os
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Dict, Iterator, List, Optional

from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader
from mcap.records import Channel, Chunk
from mcap.records import Message as McapMessage
from mcap.stream_reader import breakup_chunk
from mcap.summary import Summary
from rosbags.rosbag1 import Reader

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.read.unindexed_bag import complete_messages, has_whole_index
from gpr20_common.message import Message, in_a_row
from gpr20_survey.folder.survey_folder import SURVEY_FILE
from gpr20_survey.recording.mcap_reader import StoredMcap, recorded_message
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.survey_topics import is_metadata_topic
from gpr20_survey.trace import trace_message, utc_time

BAG, MCAP = ".bag", ".mcap"
BAG_MAGIC, MCAP_MAGIC = b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n"
INDEX_POSITION = b"index_pos="
RECORD_HEAD_BYTES = 9  # opcode and length
CUT_OFF = Message(
    "the recording was cut off, so it has no complete index; all complete messages before that "
    "place were read"
)


@dataclass
class OpenRecording:
    """An open recording."""

    traces: Iterator[RecordedMessage]
    """Every trace; raises UnreadableFileError where the file is damaged."""
    count: int = 0
    """Number of traces by its index; 0 without an index."""
    metadata: Optional[str] = None
    """Content of survey.json at the start of the survey."""
    notes: List[Message] = field(default_factory=list)


def open_recording(path: Path) -> OpenRecording:
    """Open a bag or an MCAP file, finished or cut off.

    Raises:
        UnreadableFileError: It is neither, or its index is damaged.
        OSError: It cannot be read.
    """
    if not is_finished(path):
        described = (one for one in _complete_messages(path) if is_metadata_topic(one.topic))
        metadata = next((_text(one.data) for one in described), None)
        traces = (one for one in _complete_messages(path) if _is_trace_type(one.datatype))
        return OpenRecording(traces, 0, metadata, [CUT_OFF])
    with _failing_as_unreadable(path):
        return _open_bag(path) if is_bag(path) else _open_mcap(path)


def trace_messages(path: Path, finished: bool) -> Iterator[RecordedMessage]:
    """Yield every recorded trace, in the order of the file.

    Args:
        path: Bag or MCAP file.
        finished: Whether it must have an index, which is then used for reading.

    Raises:
        UnreadableFileError: It is damaged, or cannot be read to its end.
    """
    if not finished:
        return (one for one in _complete_messages(path) if one.datatype == trace_message.DATATYPE)
    return _bag_traces(path) if is_bag(path) else _mcap_traces(path, None)


def mcap_messages(path: Path) -> Iterator[RecordedMessage]:
    """Yield the messages of an MCAP file in order of time; of a cut-off file, the complete ones.

    Raises:
        UnreadableFileError: The file is damaged before its end.
        OSError: It cannot be read.
    """
    if not is_finished(path):
        yield from _whole_messages(path)
        return
    with _failing_as_unreadable(path), path.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            if schema is not None:
                yield recorded_message(schema, channel, message)


def mcap_length_s(path: Path) -> float:
    """Return the time between the first and the last message of an MCAP file [s].

    Of a file that was cut off it is not known: 0.

    Raises:
        UnreadableFileError: The file is damaged.
        OSError: It cannot be read.
    """
    if not is_finished(path):
        return 0.0
    with _failing_as_unreadable(path), path.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    if summary is None or summary.statistics is None:
        return 0.0
    statistics = summary.statistics
    length_ns = max(0, statistics.message_end_time - statistics.message_start_time)
    return length_ns / utc_time.NS_PER_S


def is_finished(path: Path) -> bool:
    """Return whether a bag or an MCAP file has its index.

    Raises:
        UnreadableFileError: It is neither.
        OSError: It cannot be read.
    """
    magic = BAG_MAGIC if is_bag(path) else MCAP_MAGIC
    with path.open("rb") as stream:
        if stream.read(len(magic)) != magic:
            kind = "bag" if is_bag(path) else "MCAP"
            raise UnreadableFileError(
                Message(
                    "{file} is not a {kind} file: it begins differently", file=path.name, kind=kind
                ),
                fault=faults.RECORDING_DAMAGED,
            )
        if path.suffix == MCAP:
            stream.seek(max(len(magic), stream.seek(0, os.SEEK_END) - len(magic)))
            return stream.read() == magic
        head = stream.read(4096)
    place = head.find(INDEX_POSITION)
    if place < 0:
        raise UnreadableFileError(
            Message("{file} has no bag header", file=path.name), fault=faults.RECORDING_DAMAGED
        )
    place += len(INDEX_POSITION)
    return head[place : place + 8] != bytes(8) and has_whole_index(path)


def is_bag(path: Path) -> bool:
    """Return whether a name is that of a bag; `rosbag record` names one that it writes .active."""
    return path.name.endswith((BAG, f"{BAG}.active"))


def is_recording(path: Path) -> bool:
    """Return whether a name is that of a bag or an MCAP file."""
    return is_bag(path) or path.suffix == MCAP


def _open_bag(path: Path) -> OpenRecording:
    with Reader(str(path)) as reader:
        count = sum(one.msgcount for one in reader.connections if _is_trace(one))
        described = [one for one in reader.connections if is_metadata_topic(one.topic)]
        found = (bytes(data) for _, _, data in reader.messages(described) if described)
        metadata = next((_text(data) for data in found), None)
    return OpenRecording(_bag_traces(path), count, metadata)


def _open_mcap(path: Path) -> OpenRecording:
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        attached = {one.name: one.data for one in reader.iter_attachments()}
        summary = reader.get_summary()
    metadata = attached[SURVEY_FILE].decode("utf-8", "replace") if SURVEY_FILE in attached else None
    count = 0
    if summary is not None and summary.statistics is not None:
        counts = summary.statistics.channel_message_counts
        count = sum(counts.get(number, 0) for number in _trace_channels(summary))
    return OpenRecording(_mcap_traces(path, summary), count, metadata)


def _bag_traces(path: Path) -> Iterator[RecordedMessage]:
    with _failing_as_unreadable(path), Reader(str(path)) as reader:
        connections = [one for one in reader.connections if _is_trace(one)]
        for connection, time_ns, data in reader.messages(connections) if connections else ():
            yield RecordedMessage(
                connection.topic,
                trace_message.DATATYPE,
                connection.digest,
                "",
                bytes(data),
                time_ns,
            )


def _mcap_traces(path: Path, summary: Optional[Summary]) -> Iterator[RecordedMessage]:
    with _failing_as_unreadable(path), path.open("rb") as stream:
        summary = summary or make_reader(stream, validate_crcs=True).get_summary()
        if summary is None:
            raise UnreadableFileError(
                Message("{file} has no MCAP summary", file=path.name),
                fault=faults.RECORDING_DAMAGED,
            )
        channels = _trace_channels(summary)
        for message in _chunk_messages(stream, summary, channels):
            channel = channels[message.channel_id]
            yield recorded_message(summary.schemas[channel.schema_id], channel, message)


def _chunk_messages(
    stream: BinaryIO, summary: Summary, channels: Dict[int, Channel]
) -> Iterator[McapMessage]:
    # The library's own iteration sorts by time or holds every message in memory, which takes as
    # long as the reading itself.
    for index in sorted(summary.chunk_indexes, key=lambda one: one.chunk_start_offset):
        # A chunk without a message index may contain any channel.
        if index.message_index_offsets and not channels.keys() & index.message_index_offsets.keys():
            continue
        stream.seek(index.chunk_start_offset + RECORD_HEAD_BYTES)
        chunk = Chunk.read(ReadDataStream(stream))
        for record in breakup_chunk(chunk, validate_crc=True):
            if isinstance(record, McapMessage) and record.channel_id in channels:
                yield record


def _trace_channels(summary: Summary) -> Dict[int, Channel]:
    return {
        channel.id: channel
        for channel in summary.channels.values()
        if channel.schema_id in summary.schemas
        and summary.schemas[channel.schema_id].name == trace_message.DATATYPE
    }


def _complete_messages(path: Path) -> Iterator[RecordedMessage]:
    """Yield every message that is there in full in a recording that has no index yet."""
    if is_bag(path):
        return complete_messages(path)
    return _whole_messages(path)


def _whole_messages(path: Path) -> Iterator[RecordedMessage]:
    """Yield every message of the whole chunks of an MCAP file that has no index yet."""
    stored = StoredMcap(path)
    yield from stored.messages()
    if stored.faults:
        raise UnreadableFileError(in_a_row(stored.faults), fault=faults.RECORDING_DAMAGED)


@contextlib.contextmanager
def _failing_as_unreadable(path: Path) -> Iterator[None]:
    try:
        yield
    except UnreadableFileError:
        raise
    except Exception as error:
        # The libraries unpack without checks: damaged bytes raise exceptions of any kind.
        raise UnreadableFileError(
            Message("{file} is damaged", file=path.name, details=repr(error)),
            fault=faults.RECORDING_DAMAGED,
        ) from error


def _is_trace(connection: Any) -> bool:
    return _is_trace_type(connection.msgtype)


def _is_trace_type(name: str) -> bool:
    return bool(name.replace("/msg/", "/") == trace_message.DATATYPE)


def _text(data: bytes) -> str:
    (size,) = struct.unpack_from("<I", data)
    if size + 4 != len(data):
        raise UnreadableFileError(
            Message("the recorded survey.json is incomplete"), fault=faults.RECORDING_DAMAGED
        )
    return data[4:].decode("utf-8", "replace")

"""The messages of a bag or an MCAP file.

Finished files are read by the standard libraries. Of a file that was cut off, all complete
messages are read.
"""

from __future__ import annotations

import contextlib
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, Callable, Dict, Iterable, Iterator, List, Optional, Sequence

from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader
from mcap.records import Channel, Chunk
from mcap.records import Message as McapMessage
from mcap.stream_reader import breakup_chunk
from mcap.summary import Summary

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.read.recording_files import (
    bag_reader,
    failing_as_unreadable,
    is_bag,
    is_finished,
    opened,
)
from gpr20_analysis.read.unindexed_bag import complete_messages
from gpr20_common.message import Message, in_a_row
from gpr20_survey.folder.log_record import LogRecord
from gpr20_survey.folder.survey_folder import SURVEY_FILE
from gpr20_survey.recording.mcap_reader import StoredMcap, recorded_message
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.survey_topics import LOG_TOPIC, is_metadata_topic, recorded_log
from gpr20_survey.trace import trace_message, utc_time

RECORD_HEAD_BYTES = 9  # opcode and length
Wanted = Callable[[str, str], bool]
"""Returns whether messages of a topic and a type are read."""
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
    log: Sequence[LogRecord] = ()
    """What was added to the survey's log while it was recorded."""
    notes: List[Message] = field(default_factory=list)


def open_recording(path: Path) -> OpenRecording:
    """Open a bag or an MCAP file, finished or cut off; the path may be a link.

    Raises:
        UnreadableFileError: It is neither, or its index is damaged.
        OSError: It cannot be read.
    """
    if not is_finished(path, follow_link=True):
        described = (one for one in _linked_messages(path) if is_metadata_topic(one.topic))
        metadata = next((_text(one.data) for one in described), None)
        traces = (one for one in _linked_messages(path) if _is_trace(one.topic, one.datatype))
        return OpenRecording(traces, 0, metadata, _log(_linked_messages(path)), [CUT_OFF])
    with failing_as_unreadable(path):
        return _open_bag(path) if is_bag(path) else _open_mcap(path)


def trace_messages(path: Path, finished: bool) -> Iterator[RecordedMessage]:
    """Yield every recorded trace, in the order of the file.

    Args:
        path: Bag or MCAP file, no link.
        finished: Whether it must have an index, which is then used for reading.

    Raises:
        UnreadableFileError: It is damaged, or cannot be read to its end.
    """
    if not finished:
        messages = _complete_messages(path, path)
        return (one for one in messages if _is_trace(one.topic, one.datatype))
    read = _bag_messages if is_bag(path) else _mcap_messages
    return read(path, _is_trace, False)


def mcap_messages(path: Path, follow_link: bool) -> Iterator[RecordedMessage]:
    """Yield the messages of an MCAP file in order of time; of a cut-off file, the complete ones.

    Args:
        path: The file.
        follow_link: Whether it may be a symbolic link.

    Raises:
        UnreadableFileError: The file is damaged before its end.
        OSError: It cannot be read.
    """
    if not is_finished(path, follow_link):
        yield from _whole_messages(path, path.resolve() if follow_link else path)
        return
    with failing_as_unreadable(path), opened(path, follow_link) as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            if schema is not None:
                yield recorded_message(schema, channel, message)


def mcap_length_s(path: Path, follow_link: bool) -> float:
    """Return the time between the first and the last message of an MCAP file [s].

    Of a file that was cut off it is not known: 0.

    Args:
        path: The file.
        follow_link: Whether it may be a symbolic link.

    Raises:
        UnreadableFileError: The file is damaged.
        OSError: It cannot be read.
    """
    if not is_finished(path, follow_link):
        return 0.0
    with failing_as_unreadable(path), opened(path, follow_link) as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    if summary is None or summary.statistics is None:
        return 0.0
    statistics = summary.statistics
    length_ns = max(0, statistics.message_end_time - statistics.message_start_time)
    return length_ns / utc_time.NS_PER_S


def _open_bag(path: Path) -> OpenRecording:
    with bag_reader(path, follow_link=True) as reader:
        count = sum(one.msgcount for one in reader.connections if _is_trace(one.topic, one.msgtype))
    described = _bag_messages(path, lambda topic, _name: is_metadata_topic(topic), True)
    metadata = next((_text(one.data) for one in described), None)
    log = _log(_bag_messages(path, _is_log, True))
    return OpenRecording(_bag_messages(path, _is_trace, True), count, metadata, log)


def _open_mcap(path: Path) -> OpenRecording:
    with opened(path, follow_link=True) as stream:
        reader = make_reader(stream, validate_crcs=True)
        attached = {one.name: one.data for one in reader.iter_attachments()}
        summary = reader.get_summary()
    metadata = attached[SURVEY_FILE].decode("utf-8", "replace") if SURVEY_FILE in attached else None
    count = 0
    if summary is not None and summary.statistics is not None:
        counts = summary.statistics.channel_message_counts
        count = sum(counts.get(number, 0) for number in _channels(summary, _is_trace))
    log = _log(_mcap_messages(path, _is_log, True))
    return OpenRecording(_mcap_messages(path, _is_trace, True), count, metadata, log)


def _log(messages: Iterable[RecordedMessage]) -> List[LogRecord]:
    """Return the records of the survey's log among messages, as far as they can be read."""
    found: List[LogRecord] = []
    with contextlib.suppress(UnreadableFileError):  # who reads the traces says so
        found.extend(one for one in map(recorded_log, messages) if one is not None)
    return found


def _bag_messages(path: Path, wanted: Wanted, follow_link: bool) -> Iterator[RecordedMessage]:
    with failing_as_unreadable(path), bag_reader(path, follow_link) as reader:
        connections = [one for one in reader.connections if wanted(one.topic, one.msgtype)]
        for connection, time_ns, data in reader.messages(connections) if connections else ():
            yield RecordedMessage(
                connection.topic,
                connection.msgtype.replace("/msg/", "/"),
                connection.digest,
                "",
                bytes(data),
                time_ns,
            )


def _mcap_messages(path: Path, wanted: Wanted, follow_link: bool) -> Iterator[RecordedMessage]:
    with failing_as_unreadable(path), opened(path, follow_link) as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
        if summary is None:
            raise UnreadableFileError(
                Message("{file} has no MCAP summary", file=path.name),
                fault=faults.RECORDING_DAMAGED,
            )
        channels = _channels(summary, wanted)
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


def _channels(summary: Summary, wanted: Wanted) -> Dict[int, Channel]:
    return {
        channel.id: channel
        for channel in summary.channels.values()
        if channel.schema_id in summary.schemas
        and wanted(channel.topic, summary.schemas[channel.schema_id].name)
    }


def _linked_messages(path: Path) -> Iterator[RecordedMessage]:
    """Yield what `_complete_messages` does of a recording that may be a symbolic link."""
    return _complete_messages(path, path.resolve())


def _complete_messages(path: Path, place: Path) -> Iterator[RecordedMessage]:
    """Yield every message that is there in full in a recording that has no index yet.

    Args:
        path: Its name.
        place: Where it is: the same, or what the name links to.
    """
    if not is_bag(path):
        yield from _whole_messages(path, place)
        return
    with opened(place, follow_link=False) as stream:
        yield from complete_messages(stream)


def _whole_messages(path: Path, place: Path) -> Iterator[RecordedMessage]:
    """Yield every message of the whole chunks of an MCAP file that has no index yet."""
    stored = StoredMcap(place)
    with failing_as_unreadable(path):
        yield from stored.messages()
    if stored.faults:
        raise UnreadableFileError(in_a_row(stored.faults), fault=faults.RECORDING_DAMAGED)


def _is_trace(_topic: str, name: str) -> bool:
    return name.replace("/msg/", "/") == trace_message.DATATYPE


def _is_log(topic: str, _name: str) -> bool:
    return topic.rsplit("/", 1)[-1] == LOG_TOPIC


def _text(data: bytes) -> str:
    (size,) = struct.unpack_from("<I", data)
    if size + 4 != len(data):
        raise UnreadableFileError(
            Message("the recorded survey.json is incomplete"), fault=faults.RECORDING_DAMAGED
        )
    return data[4:].decode("utf-8", "replace")

"""The traces of a bag and of an MCAP file, by stock readers."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO, Dict, Iterator, Optional

from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import breakup_chunk
from mcap.summary import Summary
from rosbags.rosbag1 import Reader

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.low.trace_decoder import DATATYPE, TRACE, TraceDecoder
from gpr20_survey.recording.stored_recording import StoredRecording

RECORD_HEAD_BYTES = 9  # opcode and length


def bag_traces(path: Path) -> Iterator[Dict[str, Any]]:
    """Yield the fields of every trace of a finished bag.

    Raises:
        UnreadableFileError: The bag cannot be read to its end.
    """
    decoder = TraceDecoder()
    try:
        with Reader(str(path)) as reader:
            for connection, _, data in reader.messages():
                if connection.msgtype == TRACE:
                    # The definition is a record of its own in newer versions of the library.
                    definition: Any = getattr(connection.msgdef, "data", connection.msgdef)
                    yield decoder.decode(bytes(data), definition, connection.digest)
    except UnreadableFileError:
        raise
    except Exception as error:
        # The library asserts and unpacks without checks: it fails in any way on damaged bytes.
        raise UnreadableFileError(f"{path.name} cannot be read: {error!r}") from error


def mcap_traces(path: Path, summary: Optional[Summary] = None) -> Iterator[Dict[str, Any]]:
    """Yield the fields of every trace of a finished MCAP file, in the order of the file.

    Args:
        path: The file.
        summary: Its summary, if it was read already.

    Raises:
        UnreadableFileError: The file cannot be read to its end, or a checksum is wrong.
    """
    decoder = TraceDecoder()
    try:
        with path.open("rb") as stream:
            summary = summary or make_reader(stream, validate_crcs=True).get_summary()
            if summary is None:
                raise UnreadableFileError(f"{path.name} has no summary")
            channels = trace_channels(summary)
            for message in _messages(stream, summary, channels):
                channel = channels[message.channel_id]
                schema = summary.schemas[channel.schema_id]
                md5sum = channel.metadata.get("md5sum", "")
                yield decoder.decode(message.data, schema.data.decode(), md5sum)
    except UnreadableFileError:
        raise
    except Exception as error:
        raise UnreadableFileError(f"{path.name} cannot be read: {error!r}") from error


def trace_channels(summary: Summary) -> Dict[int, Channel]:
    """Return the channels of an MCAP file that hold traces, by their numbers."""
    return {
        channel.id: channel
        for channel in summary.channels.values()
        if channel.schema_id in summary.schemas
        and summary.schemas[channel.schema_id].name == DATATYPE
    }


def _messages(
    stream: BinaryIO, summary: Summary, channels: Dict[int, Channel]
) -> Iterator[Message]:
    # The library's own iteration sorts by time, or keeps every message: each costs as much
    # as the reading itself.
    for index in sorted(summary.chunk_indexes, key=lambda one: one.chunk_start_offset):
        # A chunk without message index may hold anything.
        if index.message_index_offsets and not channels.keys() & index.message_index_offsets.keys():
            continue
        stream.seek(index.chunk_start_offset + RECORD_HEAD_BYTES)
        chunk = Chunk.read(ReadDataStream(stream))
        for record in breakup_chunk(chunk, validate_crc=True):
            if isinstance(record, Message) and record.channel_id in channels:
                yield record


def unfinished_traces(recording: StoredRecording) -> Iterator[Dict[str, Any]]:
    """Yield the fields of every trace of a recording that has no index yet.

    Raises:
        UnreadableFileError: It is damaged before its end.
    """
    decoder = TraceDecoder()
    for message in recording.messages():
        if message.datatype == DATATYPE:
            yield decoder.decode(message.data, message.definition, message.md5sum)
    if recording.faults:
        raise UnreadableFileError("; ".join(recording.faults))

"""The traces of a bag and of an MCAP file, by stock readers."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator

from mcap.reader import make_reader
from rosbags.rosbag1 import Reader

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.low.trace_decoder import DATATYPE, TRACE, TraceDecoder
from gpr20_vna_processing.low.stored_recording import StoredRecording


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


def mcap_traces(path: Path) -> Iterator[Dict[str, Any]]:
    """Yield the fields of every trace of a finished MCAP file.

    Raises:
        UnreadableFileError: The file cannot be read to its end, or a checksum is wrong.
    """
    decoder = TraceDecoder()
    try:
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            for schema, channel, message in reader.iter_messages():
                if schema is not None and schema.name == DATATYPE:
                    md5sum = channel.metadata.get("md5sum", "")
                    yield decoder.decode(message.data, schema.data.decode(), md5sum)
    except UnreadableFileError:
        raise
    except Exception as error:
        raise UnreadableFileError(f"{path.name} cannot be read: {error!r}") from error


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

"""A bag or an MCAP file opened as a survey: its traces, and its survey.json of the start."""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional

from mcap.reader import make_reader
from mcap.summary import Summary
from rosbags.rosbag1 import Reader

from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.low import recorded_messages
from gpr20_analysis.low.trace_decoder import TRACE
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import MAGIC
from gpr20_survey.recording.stored_recording import StoredRecording

METADATA_TOPIC = "survey_metadata"
ATTACHMENT = "survey.json"
BAG_HEAD = b"#ROSBAG V2.0\n"
INDEX_POSITION = b"index_pos="
CUT_OFF = "the recording was cut off before its index was written; what is whole was read"


@dataclass
class RecordedSurvey:
    """A recording, looked into."""

    traces: Iterator[Dict[str, Any]]
    """The fields of every trace; raises UnreadableFileError where it is damaged."""
    count: int = 0
    """How many traces it tells of; 0 if it has no index."""
    metadata: Optional[str] = None
    """survey.json as it was at the start."""
    notes: List[str] = field(default_factory=list)


def open_bag(path: Path) -> RecordedSurvey:
    """Open a bag, finished or cut off.

    Raises:
        UnreadableFileError: It is no bag, or its index is damaged.
        OSError: It cannot be read.
    """
    if not _bag_has_index(path):
        return _unfinished(StoredBag(path))
    try:
        with Reader(str(path)) as reader:
            count = sum(one.msgcount for one in reader.connections if one.msgtype == TRACE)
            described = [one for one in reader.connections if _is_metadata(one.topic)]
            found = (bytes(data) for _, _, data in reader.messages(described) if described)
            metadata = next((_text(data) for data in found), None)
    except Exception as error:
        # The library asserts and unpacks without checks: it fails in any way on damaged bytes.
        raise UnreadableFileError(f"{path.name} cannot be read: {error!r}") from error
    return RecordedSurvey(recorded_messages.bag_traces(path), count, metadata)


def open_mcap(path: Path) -> RecordedSurvey:
    """Open an MCAP file, finished or cut off.

    Raises:
        UnreadableFileError: It is no MCAP file, or its summary is damaged.
        OSError: It cannot be read.
    """
    if not mcap_has_end(path):
        return _unfinished(StoredMcap(path))
    try:
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            attached = {one.name: one.data for one in reader.iter_attachments()}
            summary = reader.get_summary()
    except Exception as error:
        raise UnreadableFileError(f"{path.name} cannot be read: {error!r}") from error
    metadata = attached[ATTACHMENT].decode("utf-8", "replace") if ATTACHMENT in attached else None
    traces = recorded_messages.mcap_traces(path, summary)
    return RecordedSurvey(traces, _mcap_count(summary), metadata)


def _unfinished(recording: StoredRecording) -> RecordedSurvey:
    described = (one for one in recording.messages() if _is_metadata(one.topic))
    metadata = next((_text(one.data) for one in described), None)
    traces = recorded_messages.unfinished_traces(recording)
    return RecordedSurvey(traces, 0, metadata, [CUT_OFF])


def _mcap_count(summary: Optional[Summary]) -> int:
    if summary is None or summary.statistics is None:
        return 0
    counts = summary.statistics.channel_message_counts
    return sum(counts.get(number, 0) for number in recorded_messages.trace_channels(summary))


def _bag_has_index(path: Path) -> bool:
    with path.open("rb") as stream:
        if stream.read(len(BAG_HEAD)) != BAG_HEAD:
            raise UnreadableFileError(f"{path.name} does not begin as a bag does")
        head = stream.read(4096)
    place = head.find(INDEX_POSITION)
    if place < 0:
        raise UnreadableFileError(f"{path.name} has no header of a bag")
    place += len(INDEX_POSITION)
    return head[place : place + 8] != bytes(8)


def mcap_has_end(path: Path) -> bool:
    """Say whether an MCAP file was finished.

    Raises:
        UnreadableFileError: It is no MCAP file.
        OSError: It cannot be read.
    """
    with path.open("rb") as stream:
        if stream.read(len(MAGIC)) != MAGIC:
            raise UnreadableFileError(f"{path.name} does not begin as an MCAP file does")
        stream.seek(max(len(MAGIC), stream.seek(0, os.SEEK_END) - len(MAGIC)))
        return stream.read() == MAGIC


def _is_metadata(topic: str) -> bool:
    return topic.rsplit("/", 1)[-1] == METADATA_TOPIC


def _text(data: bytes) -> str:
    (size,) = struct.unpack_from("<I", data)
    if size + 4 != len(data):
        raise UnreadableFileError("the survey's metadata are not whole")
    return data[4:].decode("utf-8", "replace")

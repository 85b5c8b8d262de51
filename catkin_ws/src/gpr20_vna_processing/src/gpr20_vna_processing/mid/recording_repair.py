"""Writing the recording of a survey again, with the traces that are right."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator, List

from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import StorageFailedError, TraceRefusedError
from gpr20_survey.faults import REPAIRED
from gpr20_survey.files import durable_files
from gpr20_survey.folder import trace_files
from gpr20_survey.folder.survey_folder import BAG_FILE, DAMAGED_FOLDER, MCAP_FILE, TRACES_FOLDER
from gpr20_survey.recording.mcap_writer import McapFile, new_mcap
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid.stored_traces import StoredTraces

SHOWN = 3  # faults of a recording that are named
COPIED_BYTES = 4 << 20  # what a copy holds in memory between two commits


def write_again(
    folder: Path,
    stored: StoredTraces,
    topics: SurveyTopics,
    start: Dict[str, Any],
    repairs: List[Message],
) -> McapFile:
    """Replace the MCAP of a survey, whose JSON files are whole; return it, open at its end.

    It is copied, because the index of the whole file is in the memory of its writer. The bag is
    removed: it is made of the recording when the survey ends again.

    Args:
        folder: The survey's folder.
        stored: What was found in it.
        topics: Makes messages of traces.
        start: The description with which the new MCAP begins.
        repairs: What is repaired is added here.

    Raises:
        StorageFailedError: A trace changed while it was read.
        OSError: The disk refused.
    """
    path = folder / MCAP_FILE
    temporary = durable_files.temporary_path(path)
    recording = new_mcap(temporary, start)
    try:
        for message in _messages(folder, stored, topics, start["survey_id"], repairs):
            if message.datatype == trace_message.DATATYPE:
                recording.write_alone(message)
            else:
                recording.write(message)
            if recording.collected_bytes > COPIED_BYTES:
                recording.commit()
        recording.commit()
        _keep_damaged(folder, stored, repairs)
        durable_files.remove_file(folder / BAG_FILE)
        recording.take_place_of(path)
    except BaseException:
        recording.abandon()
        temporary.unlink(missing_ok=True)  # it may have filled the disk
        raise
    return recording


def _keep_damaged(folder: Path, stored: StoredTraces, repairs: List[Message]) -> None:
    """Keep an MCAP that is not whole in `damaged/`, and the bag: each may hold more."""
    found = stored.mcap.faults
    if not (folder / MCAP_FILE).exists():
        found = [Message("{file} is missing", file=MCAP_FILE)]
    if not found:
        return
    for path in (folder / MCAP_FILE, folder / BAG_FILE):
        if path.exists():
            durable_files.keep_aside(path, folder / DAMAGED_FOLDER)
    named = in_a_row(found[:SHOWN])
    repairs.append(
        Message("rebuilt {file}: {faults}", file=MCAP_FILE, faults=named).with_fault(REPAIRED)
    )


def _messages(
    folder: Path,
    stored: StoredTraces,
    topics: SurveyTopics,
    survey_id: str,
    repairs: List[Message],
) -> Iterator[RecordedMessage]:
    """Yield every trace that is right once, and all other messages."""
    yield from stored.mcap.messages(stored.truth)
    prints = stored.mcap.prints
    missing = sorted(index for index, one in stored.truth.items() if prints.get(index) != one)
    for index in missing:
        path = folder / TRACES_FOLDER / stored.files.files[index].name
        trace = read_again(path, survey_id)
        yield topics.trace(trace, trace.timestamp_us * utc_time.NS_PER_US)
    if missing:
        repairs.append(
            Message("added {count} traces to {file}", count=len(missing), file=MCAP_FILE)
        )


def read_again(path: Path, survey_id: str) -> Trace:
    """Return the trace of a file that was whole before.

    Raises:
        StorageFailedError: It is not any more.
        OSError: The file cannot be read.
    """
    try:
        return trace_files.read_trace(path, survey_id)
    except TraceRefusedError as error:
        raise StorageFailedError(
            Message(
                "{path} changed while it was read: {reason}; try again",
                path=printable(path),
                reason=error.message,
            ),
            fault=faults.CHANGED,
        ) from error

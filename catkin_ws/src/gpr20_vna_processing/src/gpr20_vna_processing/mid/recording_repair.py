"""Writing the recordings of a survey again, from the traces that are right."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Iterator, List

from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import StorageFailedError, TraceRefusedError
from gpr20_survey.faults import REPAIRED
from gpr20_survey.files import durable_files
from gpr20_survey.folder import survey_folder, trace_files
from gpr20_survey.recording.bag_writer import BagFile
from gpr20_survey.recording.recording import RecordedMessage, Recording
from gpr20_survey.recording.recordings import new_mcap
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.recording.topic_types import TopicTypes
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid.stored_traces import StoredTraces

SHOWN = 3  # faults of a recording that are named
COPIED_BYTES = 4 << 20  # what a copy holds in memory between two commits


class RecordingRepair:
    """Writes the MCAP and the bag of one survey again, whose JSON files are whole.

    The MCAP is copied, because the index of the whole file is in the memory of its writer. The
    bag, which has no checksums, gets what the MCAP gets.
    """

    def __init__(
        self,
        folder: Path,
        stored: StoredTraces,
        topics: SurveyTopics,
        start: Dict[str, Any],
        repairs: List[Message],
    ) -> None:
        """Change nothing yet.

        Args:
            folder: The survey's folder.
            stored: What was found in it.
            topics: Makes messages of traces.
            start: The description with which the new MCAP begins.
            repairs: What is repaired is added here.
        """
        self._folder = folder
        self._stored = stored
        self._topics = topics
        self._start = start
        self._repairs = repairs
        self._types = TopicTypes(stored.mcap.types)

    def write(self) -> List[Recording]:
        """Replace both recordings by whole ones; return them, open at their ends.

        Raises:
            StorageFailedError: A trace changed while it was read.
            OSError: The disk refused.
        """
        paths = [self._folder / survey_folder.BAG_FILE, self._folder / survey_folder.MCAP_FILE]
        temporary = [durable_files.temporary_path(path) for path in paths]
        recordings: List[Recording] = []
        try:
            recordings.append(BagFile(temporary[0]))
            recordings.append(new_mcap(temporary[1], self._start))
            self._copy(recordings)
            self._keep_damaged(paths)
            for recording, path in zip(recordings, paths):
                recording.take_place_of(path)
        except BaseException:
            for recording in recordings:
                recording.abandon()
            for path in temporary:
                path.unlink(missing_ok=True)  # it may have filled the disk
            raise
        return recordings

    def _keep_damaged(self, paths: List[Path]) -> None:
        """Keep both recordings in `damaged/` if the MCAP is not whole: each may hold more."""
        mcap = self._stored.mcap
        missing = not mcap.stored.path.exists()
        if not mcap.faults and not missing:
            return
        for path in paths:
            if path.exists():
                durable_files.keep_aside(path, self._folder / survey_folder.DAMAGED_FOLDER)
        found = mcap.faults or [Message("{file} is missing", file=mcap.stored.path.name)]
        self._repairs.append(
            Message(
                "rebuilt {file}: {faults}",
                file=survey_folder.MCAP_FILE,
                faults=in_a_row(found[:SHOWN]),
            ).with_fault(REPAIRED)
        )

    def _copy(self, recordings: List[Recording]) -> None:
        """Write every trace that is right once, and all other messages."""
        for message in self._messages():
            for recording in recordings:
                if message.datatype == trace_message.DATATYPE:
                    recording.write_alone(message)
                else:
                    recording.write(message)
                if recording.collected_bytes > COPIED_BYTES:
                    recording.commit()
        for recording in recordings:
            recording.commit()

    def _messages(self) -> Iterator[RecordedMessage]:
        mcap, truth = self._stored.mcap, self._stored.truth
        right = mcap.places(truth)
        for place, message in enumerate(mcap.stored.messages()):
            if message.datatype != trace_message.DATATYPE or place in right:
                yield message
        present = {index for index, own in mcap.prints.items() if truth.get(index) == own}
        missing = sorted(truth.keys() - present)
        for index in missing:
            trace = self._read(index)
            message = self._topics.trace(trace, trace.timestamp_us * utc_time.NS_PER_US)
            yield self._types.named(message) or message
        if missing:
            self._repairs.append(
                Message(
                    "added {count} traces to {file}",
                    count=len(missing),
                    file=survey_folder.MCAP_FILE,
                )
            )

    def _read(self, index: int) -> Trace:
        name = self._stored.files.files[index].name
        path = self._folder / survey_folder.TRACES_FOLDER / name
        return read_again(path, self._start["survey_id"])


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

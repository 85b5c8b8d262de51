"""Making the recordings of a survey whole, from the traces that are true."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import AbstractSet, Any, Dict, List, Optional

from gpr20_common.message import Message, in_a_row
from gpr20_survey.errors import StorageFailedError, TraceRefusedError, printable
from gpr20_survey.faults import REPAIRED
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, survey_folder, trace_files
from gpr20_survey.recording.bag_writer import BagFile
from gpr20_survey.recording.recording import RecordedMessage, Recording
from gpr20_survey.recording.recordings import new_mcap
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.recording.topic_types import TopicTypes
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid.recorded_traces import RecordedTraces
from gpr20_vna_processing.mid.stored_forms import StoredForms

SHOWN = 3  # faults of a recording that are named
COPIED_BYTES = 4 << 20  # what a copy holds in memory between two commits


class RecordingRepair:
    """Repairs the bag and the MCAP of one survey, whose JSON files are whole."""

    def __init__(
        self,
        folder: Path,
        forms: StoredForms,
        topics: SurveyTopics,
        start: Dict[str, Any],
        repairs: List[Message],
    ) -> None:
        """Change nothing yet.

        Args:
            folder: The survey's folder.
            forms: What was found in it.
            topics: Makes messages of traces.
            start: The description with which a new MCAP begins.
            repairs: What is repaired is added here.
        """
        self._folder = folder
        self._damaged = folder / survey_folder.DAMAGED_FOLDER
        self._forms = forms
        self._topics = topics
        self._start = start
        self._repairs = repairs
        self._types = TopicTypes(forms.md5sums())

    def write(self) -> List[Recording]:
        """Make both recordings whole, remove the manifest and return them, open at their ends.

        Raises:
            StorageFailedError: A trace changed while it was read.
            OSError: The disk refused.
        """
        recordings: List[Recording] = []
        try:
            recordings.append(self._resume_bag() or self._write_again(self._forms.bag))
            recordings.append(self._write_again(self._forms.mcap))
            # Last: until now it vouches for files that were not changed yet.
            durable_files.remove_file(self._folder / manifest.MANIFEST_FILE)
        except BaseException:
            for recording in recordings:
                recording.abandon()
            raise
        return recordings

    def _resume_bag(self) -> Optional[Recording]:
        """Continue the bag without its torn tail or its index, if all before that is right."""
        bag = self._forms.stored_bag.resume() if self._forms.bag_is_right() else None
        if bag is None:
            return None
        try:
            missing = self._forms.truth.keys() - self._forms.bag.prints.keys()
            self._add(missing, bag, self._forms.bag.name)
        except BaseException:
            bag.abandon()
            raise
        return bag

    def _write_again(self, recorded: RecordedTraces) -> Recording:
        """Replace a recording by a whole new file; a damaged one stays in `damaged/`."""
        path = recorded.stored.path
        temporary = durable_files.temporary_path(path)
        new: Recording
        if recorded is self._forms.bag:
            new = BagFile(temporary)
        else:
            new = new_mcap(temporary, self._start)
        found = self._forms.faults_of(recorded)
        try:
            self._copy(recorded, new)
            if found and path.exists():
                durable_files.keep_aside(path, self._damaged)
            new.take_place_of(path)
        except BaseException:
            new.abandon()
            temporary.unlink(missing_ok=True)  # it may have filled the disk
            raise
        if found:
            self._repairs.append(
                Message(
                    "rebuilt {file}: {faults}", file=path.name, faults=in_a_row(found[:SHOWN])
                ).with_fault(REPAIRED)
            )
        return new

    def _copy(self, recorded: RecordedTraces, new: Recording) -> None:
        """Write every true trace once and all other messages."""
        missing = set(self._forms.truth)
        source = self._forms.source_of(recorded).stored
        for message in map(self._forms.with_certain_type, source.messages()):
            if message.datatype != trace_message.DATATYPE:
                if message.topic != self._topics.trace_topic:
                    new.write(message)
            else:
                trace = self._forms.true_trace(message)
                if trace is not None and trace.index in missing:
                    missing.remove(trace.index)
                    new.write_alone(self._of_same_type(trace, message))
            if new.collected_bytes > COPIED_BYTES:
                new.commit()
        self._add(missing, new, recorded.name)

    def _of_same_type(self, trace: Trace, message: RecordedMessage) -> RecordedMessage:
        """Return the message of a trace, with the version of its type that its topic has."""
        if message.md5sum in trace_message.FORMER_MD5SUMS:
            return replace(message, data=trace_message.encode(trace, message.md5sum))
        return replace(self._topics.trace(trace, message.time_ns), topic=message.topic)

    def _read(self, index: int) -> Trace:
        path = self._folder / survey_folder.TRACES_FOLDER / self._forms.files.files[index].name
        return read_again(path, self._start["survey_id"])

    def _add(self, missing: AbstractSet[int], new: Recording, name: str) -> None:
        for index in sorted(missing):
            trace = self._read(index)
            message = self._topics.trace(trace, trace.timestamp_us * utc_time.NS_PER_US)
            new.write_alone(self._types.named(message) or message)
            if new.collected_bytes > COPIED_BYTES:
                new.commit()
        new.commit()
        if missing:
            self._repairs.append(
                Message("added {count} traces to {file}", count=len(missing), file=name)
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

"""A survey whose folder is being written. Everything here runs on the storage thread."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Dict, List, Protocol, Sequence

from gpr20_vna_processing.errors import StorageFailedError, TraceRefusedError, storing
from gpr20_vna_processing.low import json_trace_file
from gpr20_vna_processing.low.recording import RecordedMessage, Recording
from gpr20_vna_processing.mid import survey_folder, survey_metadata, trace_json
from gpr20_vna_processing.mid.trace_record import TraceRecord

COMMIT_BYTES = 1 << 20


class MessageMaker(Protocol):
    """Makes the messages that the storage itself puts on the graph."""

    def trace(self, trace: TraceRecord, time_ns: int) -> RecordedMessage:
        """Serialize a trace as a message of the topic `trace`."""

    def metadata(self, text: str, time_ns: int) -> RecordedMessage:
        """Serialize the survey's description as a message of `survey_metadata`."""


class OpenSurvey:
    """The files of one survey: traces, recordings and survey.json."""

    def __init__(
        self,
        folder: Path,
        description: Dict[str, Any],
        recordings: Sequence[Recording],
        messages: MessageMaker,
        on_stored: Callable[[TraceRecord], None],
    ) -> None:
        """Take over the files.

        Args:
            folder: The survey's folder.
            description: The content of survey.json.
            recordings: Where every message goes; their files are just begun.
            messages: Serializes traces.
            on_stored: Told of every trace once, when it is durable.
        """
        self.folder = folder
        self.description = description
        self.survey_id: str = description["survey_id"]
        self.stored_traces = 0
        self._ending = False  # the recordings take nothing more
        self._recordings = list(recordings)
        self._messages = messages
        self._on_stored = on_stored
        self._names: Dict[int, str] = {}  # file of each index whose JSON is durable
        self._indices: Dict[str, int] = {}  # index of each sample
        self._uncommitted: Dict[int, TraceRecord] = {}  # in the recordings, not yet durable
        self._missing: Dict[int, List[Recording]] = {}  # recordings that lack a trace
        self._types: Dict[str, str] = {}  # type of each topic, by its checksum

    def store(self, trace: TraceRecord, time_ns: int) -> Path:
        """Store a trace in the JSON file and the recordings; return when all are durable.

        A trace that is stored already with the same content is not written again.

        Args:
            trace: The trace.
            time_ns: When it came [ns since 1970, UTC].

        Returns:
            The JSON file.

        Raises:
            TraceRefusedError: The trace is of another survey, or its index or sample_id
                are taken by another.
            StorageFailedError: The disk refused; storing the same trace again goes on
                where it failed.
        """
        self._check_survey(trace)
        self._keep_collected_small()
        message = self._messages.trace(trace, time_ns)
        path = self._store_json(trace)
        self._record_trace(trace, message)
        self.commit()
        return path

    def record(self, messages: Sequence[RecordedMessage]) -> int:
        """Record messages of other topics; return how many could not be.

        Raises:
            StorageFailedError: The disk refuses; the messages were not recorded.
        """
        self._keep_collected_small()
        if self._ending:
            return 0
        refused = 0
        for message in messages:
            known = self._types.setdefault(message.topic, message.md5sum)
            if known != message.md5sum:
                refused += 1
                continue
            for recording in self._recordings:
                recording.write(message)
        return refused

    def commit(self) -> None:
        """Make everything recorded so far durable, and tell of the traces among it.

        Raises:
            StorageFailedError: The disk refused.
        """
        for recording in self._recordings:
            with storing("the recording", self.folder / recording.name):
                recording.commit()
        self._tell_stored()

    def close(self, outcome: str, reason: str, ended: str) -> None:
        """Finish the recordings and write how the survey ended; may be repeated.

        Args:
            outcome: One word.
            reason: Why, for people.
            ended: When, as ISO 8601 text.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        self.commit()
        self._ending = True
        for recording in self._recordings:
            with storing("the end of the recording", self.folder / recording.name):
                recording.finish()
        ending = {
            "ended": ended,
            "outcome": outcome,
            "reason": reason,
            "stored_traces": self.stored_traces,
        }
        path = self.folder / survey_folder.SURVEY_FILE
        with storing("the end of the survey", path):
            json_trace_file.replace_file(
                path, survey_metadata.encode({**self.description, **ending})
            )

    def _keep_collected_small(self) -> None:
        # Memory must not grow while the disk is full.
        if any(one.collected_bytes > COMMIT_BYTES for one in self._recordings):
            self.commit()

    def abandon(self) -> None:
        """Leave the files as they are on the disk."""
        for recording in self._recordings:
            recording.abandon()

    def _check_survey(self, trace: TraceRecord) -> None:
        if self._ending:
            raise TraceRefusedError(
                f"{trace.label} is refused: the survey is being closed; call close_survey again"
            )
        if trace.survey_id != self.survey_id:
            raise TraceRefusedError(
                f"{trace.label} belongs to survey {trace.survey_id}, but {self.survey_id} is open"
            )
        index = self._indices.get(trace.sample_id, trace.index)
        if index != trace.index:
            raise TraceRefusedError(
                f"sample {trace.sample_id} is stored already with index {index}, "
                f"not {trace.index}; every sample needs an id of its own"
            )

    def _store_json(self, trace: TraceRecord) -> Path:
        content = trace_json.encode(trace)
        traces = self.folder / survey_folder.TRACES_FOLDER
        known = self._names.get(trace.index)
        if known is not None:
            path = traces / known
            self._check_same(trace, path, content)
            return path
        path = traces / survey_folder.trace_file_name(trace)
        with storing(trace.label, path):
            json_trace_file.write_new_file(path, content)
        self._names[trace.index] = path.name
        self._indices[trace.sample_id] = trace.index
        self._missing[trace.index] = list(self._recordings)
        return path

    def _check_same(self, trace: TraceRecord, path: Path, content: bytes) -> None:
        try:
            stored = path.read_bytes()
        except OSError as error:
            raise StorageFailedError(
                f"{trace.label} is stored already, but {path} cannot be read: {error.strerror}"
            ) from error
        if stored != content:
            raise TraceRefusedError(
                f"{trace.label} is refused: index {trace.index} is stored already with other "
                f"content in {path}, which was left alone"
            )

    def _record_trace(self, trace: TraceRecord, message: RecordedMessage) -> None:
        missing = self._missing.get(trace.index)
        while missing:
            # A chunk of its own: readers of traces need not unpack the other topics.
            missing[0].begin_chunk()
            missing[0].write(message)
            missing.pop(0)
        if missing is not None:
            del self._missing[trace.index]
            self._uncommitted[trace.index] = trace

    def _tell_stored(self) -> None:
        while self._uncommitted:
            trace = self._uncommitted.pop(next(iter(self._uncommitted)))
            self.stored_traces += 1
            self._on_stored(trace)

"""A survey whose folder is being written. Everything here runs on the storage thread."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, ContextManager, Dict, List, Mapping, Sequence, Set, Tuple

from gpr20_common.faults import IN_USE
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError, storing
from gpr20_survey.faults import DAMAGED
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import FileSum, sum_of_file
from gpr20_survey.folder import manifest, survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import Change
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.recording.mcap_writer import McapFile, RecordedMessage
from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.new_survey import metadata_of
from gpr20_vna_processing.mid.processing_records import Storage
from gpr20_vna_processing.mid.stored_traces import read_again

# As many contain a whole stop of a survey with up to four rotations.
RECENT_TRACES = 8
# The first stop, with which the drift is compared.
FIRST_TRACES = 4
COMMIT_BYTES = 1 << 20
NOTHING_STORED: Mapping[int, TraceFile] = {}


class OpenSurvey:
    """The files of one survey: traces, recording and log.

    Attributes:
        folder: The survey's folder.
        survey_id: UUID.
        opened_as: What the log said when the survey was opened.
        stored_traces: How many traces are durable in both forms.
        newest: The largest index of a trace that was published; -1 before.
    """

    def __init__(
        self,
        folder: Path,
        log: SurveyLog,
        recording: McapFile,
        storage: Storage,
        stored: Mapping[int, TraceFile] = NOTHING_STORED,
    ) -> None:
        """Take over the log, the recording, and the traces that both forms hold, by their index."""
        self.folder = folder
        self._log = log
        self.opened_as = log.description
        self.survey_id: str = self.opened_as["survey_id"]
        self.stored_traces = len(stored)
        self.newest = -1
        self._files = dict(stored)  # of each index whose JSON file is durable
        self._indices = {file.sample_id: index for index, file in stored.items()}
        # Of them those that are not durable in the recording, and those that it was given.
        self._pending: Dict[int, Tuple[Trace, RecordedMessage]] = {}
        self._collected: Set[int] = set()
        self._ending = False  # the recording accepts nothing more
        self._is_finished = False
        self._sums: Dict[str, FileSum] = {}  # of the finished recording
        self._recording = recording
        self._storage = storage

    @property
    def description(self) -> Dict[str, Any]:
        return self._log.description

    @property
    def pending(self) -> Tuple[Trace, ...]:
        """The traces that have a durable file, but were not published."""
        return tuple(trace for trace, _message in self._pending.values())

    def begin(
        self, added: Sequence[LogRecord], latched: Sequence[RecordedMessage], now_ns: int
    ) -> None:
        """Record how the survey begins, and write survey.json and the log of a new one.

        That is the records of its log that are not recorded yet, and the last latched messages.
        """
        topics = self._storage.topics
        text = survey_metadata.encode(self.description).decode("ascii")
        metadata = topics.metadata(text, now_ns)
        log = [topics.log(record, now_ns) for record in added]
        replay = topics.replay(self.description, self.folder, now_ns)
        self.record([replay, metadata, *log, *latched])
        self.commit()
        with self._writing(survey_folder.SURVEY_FILE):
            self._log.write_description()
        with self._writing(survey_folder.LOG_FILE):
            if not self._log.is_whole:
                self._log.write()  # last: a folder with a log is whole
        self._storage.publish(metadata)

    def is_called(self, name: str) -> bool:
        """Return whether a name is its id, or that of its folder."""
        return name in (self.survey_id, self.folder.name)

    def has_stored(self, trace: Trace) -> bool:
        """Return whether this very trace has a durable file."""
        file = self._files.get(trace.index)
        return file is not None and file.fingerprint == trace.fingerprint()

    def store(self, trace: Trace, time_ns: int) -> Path:
        """Store a trace that came now [ns] in its JSON file, which is returned, and the recording.

        One that is stored already with the same content is stored once.

        Raises:
            TraceRefusedError: The trace is of another survey, or its index or sample_id
                are taken by another.
            SurveyRefusedError: The survey is being closed.
            StorageFailedError: The disk refused; the same trace again continues where it failed.
        """
        self._check_not_closing()
        self._check_own(trace)
        self._keep_collected_small()
        path = self._traces / survey_folder.trace_file_name(trace)
        content = trace_files.encode(trace)
        failure = Message(
            "{trace} could not be written", trace=trace.label, details=printable(path)
        )
        with storing(failure, path):
            # Again, if it is stored already: somebody may have removed the file.
            durable_files.write_new_file(path, content)
        if trace.index not in self._files:
            self._pending[trace.index] = trace, self._storage.topics.trace(trace, time_ns)
            self._files[trace.index] = TraceFile.of(trace, content)
            self._indices[trace.sample_id] = trace.index
        self.commit()
        return path

    def resume(self, time_ns: int) -> None:
        """Note that the survey is resumed [ns since 1970, UTC], and commit; may be repeated."""
        self._check_not_closing()
        # The client may ask again before its first trace.
        values, last = {"stored_traces": self.stored_traces}, self._log.last
        if last.kind != Kind.RESUME.value or last.values != values:
            self._add_fact(Kind.RESUME, values, time_ns)
        self.commit()

    def reopened(self, repairs: Tuple[Message, ...]) -> ReopenedSurvey:
        """Return the answer for a survey that was opened again."""
        description = self.description
        report = description.get("report")
        failure = Message("the survey in {folder} could not be read", folder=printable(self.folder))
        with storing(failure, self.folder):
            recent = tuple(read_again(path, self.survey_id) for path in self._recent())
        return ReopenedSurvey(
            survey_id=self.survey_id,
            path=str(self.folder),
            metadata_json=json.dumps(metadata_of(description)),
            report_json="" if report is None else json.dumps(report),
            stored_indices=tuple(self._stored()),
            recent=recent,
            repairs=repairs,
        )

    def _stored(self) -> List[int]:
        return sorted(self._files.keys() - self._pending.keys())

    def _recent(self) -> List[Path]:
        # By their places in the plan: the clock may have been set back.
        stored = self._stored()
        newest = stored[-RECENT_TRACES:]
        first = [one for one in stored if one < FIRST_TRACES and one not in newest]
        return [self._traces / self._files[index].name for index in [*first, *newest]]

    def record(self, messages: Sequence[RecordedMessage]) -> None:
        """Record messages of other topics; StorageFailedError: the disk refuses them."""
        self._keep_collected_small()
        if not self._ending:
            for message in messages:
                self._recording.write(message)

    def commit(self) -> None:
        """Make everything recorded so far durable, and publish the traces among it."""
        for index, (_trace, message) in self._pending.items():
            if index not in self._collected:
                self._recording.write_alone(message)
                self._collected.add(index)
        with self._writing(survey_folder.MCAP_FILE):
            self._recording.commit()
        self._collected.clear()
        while self._pending:
            index = next(iter(self._pending))
            _trace, message = self._pending.pop(index)
            self.stored_traces += 1
            self.newest = max(self.newest, index)
            self._storage.publish(message)

    def change(self, change: Change, time_ns: int) -> Dict[str, Any]:
        """Add what a change says now [ns], if anything; return what the log says when durable.

        Raises:
            SurveyRefusedError: The survey is being closed, or the change is not possible.
            StorageFailedError: The disk refused; the log has its former records.
        """
        fact = change(self.description)
        if fact is not None and not self._log.has_note(*fact):
            self._check_not_closing()
            self._add_fact(fact.kind, fact.values, time_ns)
        return self.description

    def close(self, outcome: str, reason: Message, time_ns: int) -> None:
        """Finish the recording, write how the survey ended [ns], and its manifest; may be repeated.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        path = self.folder / survey_folder.MCAP_FILE
        if not self._is_finished:
            self.commit()
            self._ending = True
            with self._writing(survey_folder.MCAP_FILE):
                self._recording.finish()
            self._is_finished = True
        if path.name not in self._sums and path.exists():
            # Read once: the log and the manifest name its checksum.
            with storing(Message("{path} could not be read", path=printable(path)), path):
                self._sums[path.name] = sum_of_file(path)
        # Those of the traces are known since they were written, which makes this fast.
        traces = {manifest.trace_name(one.name): one.sum for one in self._files.values()}
        sums = {**traces, **self._sums}
        ending: Dict[str, Any] = {
            "ended": utc_time.iso_text(time_ns // utc_time.NS_PER_US),
            "outcome": outcome,
            "reason": str(reason),
            survey_metadata.REASON_MESSAGE: survey_metadata.message_record(reason),
            survey_metadata.FAULT_CODE: reason.fault_code,
            "stored_traces": self.stored_traces,
            manifest.CONTENT: manifest.content_sum(sums),
        }
        self._add(Kind.END, ending, time_ns)
        with self._writing(survey_folder.SURVEY_FILE):
            self._log.write_description()
        with self._writing(manifest.MANIFEST_FILE):
            # Last: a survey with a manifest has ended, and nothing changes any more.
            manifest.write_manifest(
                self.folder,
                self.survey_id,
                self._log.last,
                self._storage.revision,
                ending["ended"],
                sums,
            )

    def in_place(self) -> bool:
        """Return whether what is written ends up in the survey's folder, beside the last traces."""
        is_there = self._is_finished or self._recording.in_place()
        return is_there and self._traces.is_dir() and all(one.is_file() for one in self._recent())

    def abandon(self) -> None:
        """Leave the files as they are on the disk."""
        self._recording.abandon()

    def _add_fact(self, kind: Kind, values: Dict[str, Any], time_ns: int) -> None:
        """Add a fact to the log, to the recording and to what is published."""
        message = self._storage.topics.log(self._add(kind, values, time_ns), time_ns)
        self.record([message])
        self._storage.publish(message)

    def _add(self, kind: Kind, values: Dict[str, Any], time_ns: int) -> LogRecord:
        record = self._log.next(kind, values, utc_time.iso_text(time_ns // utc_time.NS_PER_US))
        with self._writing(survey_folder.LOG_FILE):
            return self._log.add(record)

    def _writing(self, name: str) -> ContextManager[None]:
        path = self.folder / name
        return storing(Message("{path} could not be written", path=printable(path)), path)

    def _keep_collected_small(self) -> None:
        # Memory must not grow while the disk is full.
        if self._recording.collected_bytes > COMMIT_BYTES:
            self.commit()

    def _check_not_closing(self) -> None:
        if self._ending:
            raise SurveyRefusedError(
                Message("the survey is being closed; stop it again", details="close_survey"),
                fault=faults.CLOSING,
            )

    def _check_own(self, trace: Trace) -> None:
        if trace.survey_id != self.survey_id:
            raise TraceRefusedError(
                Message(
                    "{trace} belongs to survey {survey}, but {open_survey} is open",
                    trace=trace.label,
                    survey=trace.survey_id,
                    open_survey=self.survey_id,
                ),
                fault=IN_USE,
            )
        index = self._indices.get(trace.sample_id, trace.index)
        if index != trace.index or (index in self._files and not self.has_stored(trace)):
            raise TraceRefusedError(
                Message(
                    "{trace} is refused: index {index} is already stored with other content in "
                    "{folder}, which was left alone",
                    trace=trace.label,
                    index=index,
                    folder=printable(self._traces),
                ),
                fault=DAMAGED,
            )

    @property
    def _traces(self) -> Path:
        return self.folder / survey_folder.TRACES_FOLDER

"""A survey whose folder is being written. Everything here runs on the storage thread."""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ContextManager, Dict, List, Mapping, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError, storing
from gpr20_survey.files import durable_files
from gpr20_survey.files.file_sums import FileSum, sum_of, sum_of_file
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.annotating import Change
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.results.reopened_survey import FIRST_TRACES, RECENT_TRACES, ReopenedSurvey
from gpr20_survey.trace import trace_json, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid import refusals
from gpr20_vna_processing.mid.publication import Publication

COMMIT_BYTES = 1 << 20


@dataclass
class _PendingTrace:
    """A trace whose JSON file is durable, but not yet the recording that holds it."""

    trace: Trace
    message: RecordedMessage
    is_recorded: bool = False
    """Whether the recording was given the message."""


class OpenSurvey:
    """The files of one survey: traces, recording and log."""

    def __init__(
        self,
        folder: Path,
        log: SurveyLog,
        recording: McapFile,
        topics: SurveyTopics,
        publication: Publication,
        stored: Optional[Mapping[int, TraceFile]] = None,
        recent: Sequence[Trace] = (),
    ) -> None:
        """Take over the files.

        Args:
            folder: The survey's folder.
            log: The survey's log, with its plan.
            recording: Where every message goes; it holds the traces that are stored.
            topics: Makes the messages of traces and of the log.
            publication: Publishes every trace and every record of the log when it is durable.
            stored: The traces that are stored already, by their index.
            recent: The first traces of the plan, and those that were stored last.
        """
        self.folder = folder
        self._log = log
        self.opened_as = log.description
        self.survey_id: str = self.opened_as["survey_id"]
        self._first = {one.index: one for one in recent if one.index < FIRST_TRACES}
        self._recent = deque(recent, maxlen=RECENT_TRACES)
        stored = stored or {}
        self.stored_traces = len(stored)
        # Fingerprint of each index whose JSON file is durable, and index of each sample.
        self._prints = {index: file.fingerprint for index, file in stored.items()}
        self._indices = {file.sample_id: index for index, file in stored.items()}
        self._sums = {manifest.trace_name(file.name): file.sum for file in stored.values()}
        self._pending: Dict[int, _PendingTrace] = {}  # of them those not durable in the recording
        self._ending = False  # the recording accepts nothing more
        self._is_finished = False
        self._recording = recording
        self._topics = topics
        self._publication = publication

    @property
    def description(self) -> Dict[str, Any]:
        """What the log says of the survey."""
        return self._log.description

    def is_called(self, name: str) -> bool:
        """Return whether a name is its id, or that of its folder."""
        return name in (self.survey_id, self.folder.name)

    def store(self, trace: Trace, time_ns: int) -> Path:
        """Store a trace in its JSON file and the recording; return when both are durable.

        A trace that is stored already with the same content is not written again.

        Args:
            trace: The trace.
            time_ns: When it came [ns since 1970, UTC].

        Returns:
            The JSON file.

        Raises:
            TraceRefusedError: The trace is of another survey, or its index or sample_id
                are taken by another.
            StorageFailedError: The disk refused; storing the same trace again continues
                where it failed.
        """
        self._check_survey(trace)
        self._keep_collected_small()
        path = self._traces / survey_folder.trace_file_name(trace)
        if trace.index in self._prints:
            self._check_same(trace, path)
        else:
            failure = Message(
                "{trace} could not be written", trace=trace.label, details=printable(path)
            )
            with storing(failure, path):
                content = trace_json.encode(trace)
                durable_files.write_new_file(path, content)
            self._sums[manifest.trace_name(path.name)] = sum_of(content)
            message = self._topics.trace(trace, time_ns)
            self._publication.expect(trace)
            self._pending[trace.index] = _PendingTrace(trace, message)
            self._prints[trace.index] = trace.fingerprint()
            self._indices[trace.sample_id] = trace.index
        self.commit()
        return path

    def resume(self, time_ns: int) -> None:
        """Note that the survey is resumed, and record what the recording still lacks.

        A call that is repeated adds nothing: the client asks again before its first trace.

        Args:
            time_ns: When that is [ns since 1970, UTC].

        Raises:
            SurveyRefusedError: The survey is being closed.
            StorageFailedError: The disk refused.
        """
        self._check_not_closing()
        values, last = {"stored_traces": self.stored_traces}, self._log.last
        if last.kind != Kind.RESUME.value or last.values != values:
            self.add(Kind.RESUME, values, time_ns)
        self.commit()

    def reopened(self, repairs: Tuple[Message, ...]) -> ReopenedSurvey:
        """Return the answer for a survey that was opened again."""
        description = self.description
        report = description.get("report")
        recent = {one.index for one in self._recent}
        first = [self._first[index] for index in sorted(self._first.keys() - recent)]
        return ReopenedSurvey(
            survey_id=self.survey_id,
            path=str(self.folder),
            metadata_json=json.dumps(survey_metadata.metadata_of(description)),
            report_json="" if report is None else json.dumps(report),
            stored_indices=tuple(self._stored_indices()),
            recent=(*first, *self._recent),
            repairs=repairs,
        )

    def _stored_indices(self) -> List[int]:
        return sorted(self._prints.keys() - self._pending.keys())

    def record(self, messages: Sequence[RecordedMessage]) -> None:
        """Record messages of other topics.

        Raises:
            StorageFailedError: The disk refuses; the messages were not recorded.
        """
        self._keep_collected_small()
        if not self._ending:
            for message in messages:
                self._recording.write(message)

    def commit(self) -> None:
        """Make everything recorded so far durable, and publish the traces among it.

        Raises:
            StorageFailedError: The disk refused.
        """
        for pending in self._pending.values():
            if not pending.is_recorded:
                self._recording.write_alone(pending.message)
                pending.is_recorded = True
        with self._storing():
            self._recording.commit()
        while self._pending:
            stored = self._pending.pop(next(iter(self._pending)))
            self.stored_traces += 1
            self._recent.append(stored.trace)
            if stored.trace.index < FIRST_TRACES:
                self._first[stored.trace.index] = stored.trace
            self._publication.stored(stored.trace, stored.message)

    def add(self, kind: Kind, values: Dict[str, Any], time_ns: int) -> None:
        """Add a fact to the log, to the recording and to what is published.

        Args:
            kind: What the fact is.
            values: The fact.
            time_ns: When that is [ns since 1970, UTC].

        Raises:
            SurveyRefusedError: The survey is being closed.
            StorageFailedError: The disk refused; the log has its former records.
        """
        self._check_not_closing()
        message = self._topics.log(self._add(kind, values, time_ns), time_ns)
        self.record([message])
        self._publication.logged(message)

    def change(self, change: Change, time_ns: int) -> Dict[str, Any]:
        """Add what a change says, if anything; return what the log says when it is durable.

        Raises:
            SurveyRefusedError: The survey is being closed, or the change is not possible.
            StorageFailedError: The disk refused; the log has its former records.
        """
        fact = change(self.description)
        if fact is not None and not self._log.has_note(*fact):
            self.add(fact.kind, fact.values, time_ns)
        return self.description

    def close(self, outcome: str, reason: Message, time_ns: int) -> None:
        """Finish the recording and write how the survey ended; may be repeated.

        Args:
            outcome: One word.
            reason: Why.
            time_ns: When [ns since 1970, UTC].

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        if not self._is_finished:
            self.commit()
            self._ending = True
            with self._storing():
                self._recording.finish()
            self._is_finished = True
        self._sum_recording()
        ending = {
            "ended": utc_time.iso_text(time_ns // utc_time.NS_PER_US),
            "outcome": outcome,
            "reason": str(reason),
            survey_metadata.REASON_MESSAGE: survey_metadata.message_record(reason),
            survey_metadata.FAULT_CODE: reason.fault_code,
            "stored_traces": self.stored_traces,
            manifest.CONTENT: manifest.content_sum(self._content_sums()),
        }
        self._add(Kind.END, ending, time_ns)
        self.write_description()

    def write_description(self) -> None:
        """Write survey.json, for readers at a glance.

        Raises:
            StorageFailedError: The disk refused.
        """
        path = self.folder / survey_folder.SURVEY_FILE
        with storing(Message("{path} could not be written", path=printable(path)), path):
            self._log.write_description()

    def write_manifest(self, revision: str) -> None:
        """Write the checksums of all files of a survey that was closed; may be repeated.

        Those of the traces are known since they were written, which makes this fast.

        Args:
            revision: Version of the suite.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        path = self.folder / manifest.MANIFEST_FILE
        with storing(Message("{path} could not be written", path=printable(path)), path):
            # Last: a survey with a manifest has ended, and nothing changes any more.
            manifest.write_manifest(
                self.folder,
                self.survey_id,
                self._log.last,
                revision,
                self.description["ended"],
                self._content_sums(),
            )

    def _storing(self) -> ContextManager[None]:
        path = self.folder / self._recording.name
        failure = Message("the recording could not be written", details=printable(path))
        return storing(failure, path)

    def in_place(self) -> bool:
        """Return whether what is written ends up in the survey's folder."""
        is_there = self._is_finished or self._recording.in_place()
        return is_there and self._traces.is_dir()

    def abandon(self) -> None:
        """Leave the files as they are on the disk."""
        self._recording.abandon()

    def _add(self, kind: Kind, values: Dict[str, Any], time_ns: int) -> LogRecord:
        path = self.folder / survey_folder.LOG_FILE
        record = self._log.next(kind, values, utc_time.iso_text(time_ns // utc_time.NS_PER_US))
        with storing(Message("{path} could not be written", path=printable(path)), path):
            return self._log.add(record)

    def _sum_recording(self) -> None:
        """Read the finished recording once: the log and the manifest name its checksum."""
        path = self.folder / self._recording.name
        if path.name not in self._sums and path.exists():
            with storing(Message("{path} could not be read", path=printable(path)), path):
                self._sums[path.name] = sum_of_file(path)

    def _content_sums(self) -> Dict[str, FileSum]:
        return {name: one for name, one in self._sums.items() if manifest.is_content(name)}

    def _keep_collected_small(self) -> None:
        # Memory must not grow while the disk is full.
        if self._recording.collected_bytes > COMMIT_BYTES:
            self.commit()

    def _check_not_closing(self) -> None:
        if self._ending:
            raise SurveyRefusedError(refusals.CLOSING)

    def _check_survey(self, trace: Trace) -> None:
        if self._ending:
            raise refusals.trace_while_closing(trace)
        if trace.survey_id != self.survey_id:
            raise refusals.trace_of_another_survey(trace, self.survey_id)
        index = self._indices.get(trace.sample_id, trace.index)
        if index != trace.index:
            raise refusals.sample_stored(trace, index)

    @property
    def _traces(self) -> Path:
        return self.folder / survey_folder.TRACES_FOLDER

    def _check_same(self, trace: Trace, path: Path) -> None:
        if trace.fingerprint() != self._prints[trace.index]:
            raise refusals.index_stored(trace, self._traces)
        if not path.is_file():
            raise refusals.file_missing(trace, self._traces)

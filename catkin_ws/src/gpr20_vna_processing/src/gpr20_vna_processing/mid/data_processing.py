"""Opening a survey, storing its traces, closing it."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, Callable, Dict, Optional, Sequence

from gpr20_vna_processing.errors import (
    ProcessingError,
    StorageFailedError,
    SurveyRefusedError,
    storing,
)
from gpr20_vna_processing.low import json_trace_file
from gpr20_vna_processing.low.recording import RecordedMessage
from gpr20_vna_processing.mid import new_survey, survey_folder, survey_metadata, utc_time
from gpr20_vna_processing.mid.ended_survey import find_ended_survey
from gpr20_vna_processing.mid.latched_topics import LatchedTopics
from gpr20_vna_processing.mid.open_survey import OpenSurvey
from gpr20_vna_processing.mid.processing_records import (
    ClosedSurvey,
    Limits,
    ProcessingState,
    ReopenedSurvey,
    Storage,
)
from gpr20_vna_processing.mid.reopening import Reopening, find_survey, reopened_survey
from gpr20_vna_processing.mid.storage_thread import StorageThread
from gpr20_vna_processing.mid.trace_record import TraceRecord

OUTCOMES = ("finished", "stopped", "failed")
INTERRUPTED = "interrupted"
MAX_REASON_CHARACTERS = 4096


class DataProcessing:
    """Keeps at most one survey open and makes its traces durable.

    Its methods may be called from any thread; all files are written by the StorageThread.
    """

    def __init__(
        self,
        storage: Storage,
        limits: Limits,
        on_opened: Callable[[str], None],
        on_stored: Callable[[TraceRecord], None],
    ) -> None:
        """Build the storage; `start` begins its thread.

        Args:
            storage: Files, disk, clock.
            limits: Bounds.
            on_opened: Told the JSON description of a survey that was opened.
            on_stored: Told of every trace once, when it is durable.
        """
        self._storage = storage
        self._limits = limits
        self._on_opened = on_opened
        self._on_stored = on_stored
        self._thread = StorageThread(
            self._write_messages, limits.queues, storage.clock, limits.period_s
        )
        self._latched = LatchedTopics()
        self._lock = threading.Lock()  # guards the two below
        self._last_error, self._failing = "", False
        # Changed on the storage thread only.
        self._survey: Optional[OpenSurvey] = None
        self._closed: Optional[ClosedSurvey] = None
        self._unrecorded = 0
        self._commit_due_s = 0.0

    def start(self) -> None:
        """Start the storage thread."""
        self._thread.start()

    def open_survey(
        self, survey_id: str, started_us: int, metadata_json: str, needed_bytes: int
    ) -> Path:
        """Make the folder of a survey and begin its recordings; may be repeated.

        Args:
            survey_id: UUID of the survey.
            started_us: When it started [us since 1970, UTC].
            metadata_json: JSON object that goes into survey.json.
            needed_bytes: Estimate of the whole survey [bytes].

        Returns:
            The survey's folder.

        Raises:
            SurveyRefusedError: A value is not allowed, the disk is too small or another
                survey is open.
            StorageFailedError: The disk refused.
        """
        folder = survey_folder.survey_folder(self._storage.data, survey_id, started_us)
        description = new_survey.describe(
            survey_id, started_us, metadata_json, self._storage.revision
        )
        self._do(lambda: self._open(folder, description, started_us, needed_bytes))
        return folder

    def interrupt_other(self, survey: str) -> str:
        """Close the open survey as interrupted, unless it is this one; it stays resumable.

        Whoever filled it has gone without closing it, if another survey shall be opened.

        Args:
            survey: Id of the survey that shall be opened, or the name of its folder.

        Returns:
            The name of the folder of the survey that was closed; empty if none was.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        return self._do(lambda: self._interrupt_other(survey), self._limits.long_timeout_s)

    def reopen_survey(self, survey: str) -> ReopenedSurvey:
        """Open a survey that was cut off or ended early, repaired; may be repeated.

        Args:
            survey: The survey's id, or the name of its folder.

        Raises:
            SurveyRefusedError: There is no such survey, it is complete, or another is open.
            StorageFailedError: The disk refused; asking again is safe.
        """
        return self._do(lambda: self._reopen(survey), self._limits.long_timeout_s)

    def report(self, survey_id: str, report_json: str) -> None:
        """Keep a report of the open survey in its survey.json, durably.

        Raises:
            SurveyRefusedError: The report is no JSON object, or the survey is not open.
            StorageFailedError: The disk refused; the former report is kept.
        """
        report = survey_metadata.parse_object(
            report_json, "report_json", survey_metadata.MAX_REPORT_BYTES
        )
        survey_folder.check_survey_id(survey_id)
        self._do(lambda: self._opened_as(survey_id).report(report))

    def store(self, trace: TraceRecord) -> Path:
        """Store a trace; return its JSON file when it is durable in all three forms.

        Raises:
            SurveyRefusedError: No survey is open.
            TraceRefusedError: The open survey does not take the trace.
            StorageFailedError: The disk refused or was too slow; asking again is safe.
        """
        return self._do(lambda: self._opened().store(trace, self._storage.now_ns()))

    def record(self, message: RecordedMessage) -> None:
        """Record a message of another topic; drop it, counted, if the disk is too slow."""
        if self._latched.note(message):
            self._thread.offer(message)

    def close_survey(self, survey_id: str, outcome: str, reason: str) -> ClosedSurvey:
        """Finish the recordings and write how the survey ended; may be repeated.

        Raises:
            SurveyRefusedError: A value is not allowed or the survey is not open.
            StorageFailedError: The disk refused; the survey is still open.
        """
        if outcome not in OUTCOMES:
            raise SurveyRefusedError(
                f"outcome is {outcome[:64]!r}; it must be one of {', '.join(OUTCOMES)}"
            )
        if len(reason) > MAX_REASON_CHARACTERS:
            raise SurveyRefusedError(
                f"reason has {len(reason)} characters; at most {MAX_REASON_CHARACTERS} are allowed"
            )
        survey_folder.check_survey_id(survey_id)
        return self._do(
            lambda: self._close(survey_id, outcome, reason), self._limits.long_timeout_s
        )

    def shut_down(self) -> None:
        """Finish the recordings of a survey that is still open and end the thread.

        Raises:
            StorageFailedError: The disk refused or was too slow.
        """
        try:
            self._do(self._interrupt)
        finally:
            self._thread.stop(self._limits.timeout_s)

    def state(self) -> ProcessingState:
        """Return what the operator should know."""
        survey = self._survey
        with self._lock:
            last_error, failing = self._last_error, self._failing
        return ProcessingState(
            survey_id=survey.survey_id if survey else "",
            folder=str(survey.folder) if survey else "",
            stored_traces=survey.stored_traces if survey else 0,
            unrecorded=self._unrecorded,
            last_error=last_error,
            failing=failing,
            queues=self._thread.state(),
        )

    def _do(self, work: Callable[[], Any], timeout_s: Optional[float] = None) -> Any:
        try:
            result = self._thread.do(work, timeout_s or self._limits.timeout_s)
        except ProcessingError as error:
            self._note(str(error), failing=isinstance(error, StorageFailedError))
            raise
        self._note("", failing=False)
        return result

    def _note(self, error: str, failing: bool) -> None:
        with self._lock:
            self._last_error, self._failing = error, failing

    def _opened(self) -> OpenSurvey:
        if self._survey is None:
            raise SurveyRefusedError("no survey is open; call open_survey first")
        return self._survey

    def _opened_as(self, survey_id: str) -> OpenSurvey:
        survey = self._opened()
        if survey.survey_id != survey_id:
            raise SurveyRefusedError(f"survey {survey_id} is not open; {survey.survey_id} is")
        return survey

    def _open(
        self, folder: Path, description: Dict[str, Any], started_us: int, needed_bytes: int
    ) -> None:
        if self._survey is not None and self._survey.opened_as == description:
            return  # the answer to the first call may have been lost
        now_ns = self._storage.now_ns()
        self._check_can_open(needed_bytes, now_ns)
        with storing("the survey's folder", folder):
            new_survey.make_folder(folder)
            recordings = self._storage.open_recordings(
                folder, description, started_us * utc_time.NS_PER_US
            )
        self._take(
            OpenSurvey(folder, description, recordings, self._storage.messages, self._on_stored),
            now_ns,
        )

    def _reopen(self, name: str) -> ReopenedSurvey:
        now_ns = self._storage.now_ns()
        survey = self._survey
        if survey is not None and name in (survey.survey_id, survey.folder.name):
            # Whoever filled it has gone, or has not received the first answer.
            survey.go_on(now_ns)
            return reopened_survey(survey, ())
        self._check_can_open(0, now_ns)
        folder, description = find_survey(self._storage.data, name)
        reopening = Reopening(folder, description, self._storage)
        repaired = reopening.repair(now_ns // utc_time.NS_PER_US)
        survey = OpenSurvey(
            folder,
            repaired.description,
            repaired.recordings,
            self._storage.messages,
            self._on_stored,
            repaired.stored,
            repaired.last,
        )
        self._take(survey, now_ns)
        return reopened_survey(survey, repaired.repairs)

    def _take(self, survey: OpenSurvey, now_ns: int) -> None:
        """Begin to record a survey whose files are whole but for what comes now."""
        content = survey_metadata.encode(survey.description)
        path = survey.folder / survey_folder.SURVEY_FILE
        try:
            self._begin_recording(survey, content.decode("ascii"), now_ns)
            with storing("the survey's description", path):
                # Last: a folder with a survey.json is whole.
                json_trace_file.write_new_file(path, content)
        except Exception:
            self._latched.end()
            survey.abandon()
            raise
        self._survey = survey
        self._on_opened(content.decode("ascii"))

    def _check_can_open(self, needed_bytes: int, now_ns: int) -> None:
        if self._survey is not None:
            raise SurveyRefusedError(
                f"survey {self._survey.survey_id} is open in {self._survey.folder}; close it first"
            )
        new_survey.check_clock(now_ns)
        new_survey.check_space(self._storage, needed_bytes, self._limits.disk_reserve_bytes)

    def _begin_recording(self, survey: OpenSurvey, text: str, now_ns: int) -> None:
        # From here on messages queue up behind this job; those before are in the snapshot.
        latched = self._latched.begin(now_ns)
        survey.record([self._storage.messages.metadata(text, now_ns), *latched])
        survey.commit()

    def _close(self, survey_id: str, outcome: str, reason: str) -> ClosedSurvey:
        if self._survey is None and self._closed and self._closed.survey_id == survey_id:
            return self._closed  # the answer to the first call may have been lost
        if self._survey is None:
            before = find_ended_survey(self._storage.data, survey_id, outcome)
            if before is not None:
                return before  # by a process that died before it could answer
        survey = self._opened_as(survey_id)
        ended = utc_time.iso_text(self._storage.now_ns() // utc_time.NS_PER_US)
        survey.close(outcome, reason, ended)
        if outcome != INTERRUPTED:
            # It reads the whole survey, for which a shut down leaves no time.
            survey.write_manifest(self._storage.revision)
        self._latched.end()
        self._closed = ClosedSurvey(survey_id, survey.folder, survey.stored_traces)
        self._survey = None
        return self._closed

    def _interrupt(self) -> None:
        if self._survey is not None:
            self._close(self._survey.survey_id, INTERRUPTED, "the storage was shut down")

    def _interrupt_other(self, survey: str) -> str:
        opened = self._survey
        if opened is None or survey in (opened.survey_id, opened.folder.name):
            return ""
        reason = f"left open by the control, which began {survey[:64]}"
        self._close(opened.survey_id, INTERRUPTED, reason)
        return opened.folder.name

    def _write_messages(self, messages: Sequence[RecordedMessage]) -> None:
        survey = self._survey
        if survey is None:
            return
        # Nobody waits for an answer here: the operator reads of errors in the diagnostics.
        try:
            self._unrecorded += survey.record(messages)
        except Exception as error:
            self._unrecorded += len(messages)
            self._note(str(error), failing=True)
        now_s = self._storage.clock.now_s()
        if now_s < self._commit_due_s:
            return
        self._commit_due_s = now_s + self._limits.period_s
        try:
            survey.commit()
        except ProcessingError as error:
            self._note(str(error), failing=True)

"""Opening a survey, storing its traces, closing it."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, Callable, Collection, Dict, Optional, Sequence

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import INTERNAL
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message, verbatim
from gpr20_survey.errors import ProcessingError, StorageFailedError, SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.annotating import Fact
from gpr20_survey.folder.log_record import NOTES, Kind
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.markers import Marker, new_marker, removed_marker
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid import new_survey
from gpr20_vna_processing.mid.current_survey import CurrentSurvey
from gpr20_vna_processing.mid.latched_topics import LatchedTopics
from gpr20_vna_processing.mid.processing_records import (
    AnnotatedSurvey,
    ClosedSurvey,
    Limits,
    MarkedSurvey,
    ProcessingState,
    Storage,
)
from gpr20_vna_processing.mid.storage_thread import StorageThread
from gpr20_vna_processing.mid.survey_end import OUTCOMES

MAX_REASON_CHARACTERS = 4096
NO_REASON = verbatim("")


class DataProcessing:
    """Has at most one survey open and makes its traces durable.

    Its methods may be called from any thread; all files are written by the StorageThread.
    """

    def __init__(
        self,
        storage: Storage,
        limits: Limits,
        on_opened: Callable[[str], None],
        on_stored: Callable[[RecordedMessage], None],
        on_logged: Callable[[RecordedMessage], None],
    ) -> None:
        """Build the storage; `start` begins its thread.

        Args:
            storage: Files, disk, clock.
            limits: Bounds.
            on_opened: Called with the JSON description of a survey that was opened.
            on_stored: Called with the message of every trace when it is durable; must not raise.
            on_logged: Likewise of every record of a survey's log.
        """
        self._storage = storage
        self._limits = limits
        self._thread = StorageThread(
            self._write_messages, limits.queues, storage.clock, limits.period_s
        )
        self._latched = LatchedTopics()
        # Changed on the storage thread only.
        self._survey = CurrentSurvey(
            storage, limits.disk_reserve_bytes, self._latched, on_opened, on_stored, on_logged
        )
        self._unrecorded = 0
        self._commit_due_s = 0.0
        self._lock = threading.Lock()  # guards the two below
        self._last_error: Optional[Message] = None
        self._failing = False

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
        self._do(lambda: self._survey.open(folder, description, needed_bytes))
        return folder

    def interrupt_other(self, survey: str) -> str:
        """Close the open survey as interrupted, unless it is this one; it stays resumable.

        If another survey is to be opened, the client that filled this one left it open.

        Args:
            survey: Id of the survey that is to be opened, or the name of its folder.

        Returns:
            The name of the folder of the survey that was closed; empty if none was.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        return self._do(lambda: self._survey.interrupt_other(survey), self._limits.long_timeout_s)

    def reopen_survey(self, survey: str) -> ReopenedSurvey:
        """Open a survey that was cut off or ended early, repaired; may be repeated.

        Args:
            survey: The survey's id, or the name of its folder.

        Raises:
            SurveyRefusedError: There is no such survey, it is complete, or another is open.
            StorageFailedError: The disk refused; the call may be repeated.
        """
        return self._do(lambda: self._survey.reopen(survey), self._limits.long_timeout_s)

    def report(self, survey_id: str, report_json: str) -> int:
        """Write a report of the open survey into its survey.json, durably.

        Returns:
            How many traces are stored.

        Raises:
            SurveyRefusedError: The report is no JSON object, or the survey is not open.
            StorageFailedError: The disk refused; the former report remains.
        """
        report = survey_metadata.parse_object(
            report_json, "report_json", survey_metadata.MAX_REPORT_BYTES
        )
        survey_folder.check_survey_id(survey_id)
        return self._do(lambda: self._survey.report(survey_id, report))

    def annotate(self, survey: str, annotation: Annotation) -> AnnotatedSurvey:
        """Replace the annotation of the open survey or of a past one, durably.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            annotation: The new annotation, whole.

        Raises:
            SurveyRefusedError: There is no such survey, or its survey.json is damaged.
            StorageFailedError: The disk refused; the former annotation remains.
        """
        return self._do(
            lambda: self._survey.annotate(survey, annotation), self._limits.long_timeout_s
        )

    def note(self, survey: str, kind: str, values_json: str) -> AnnotatedSurvey:
        """Add a note to the log of the open survey or of a past one; may be repeated.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            kind: One of `NOTES`.
            values_json: JSON object with the note and its time.

        Raises:
            SurveyRefusedError: A value is not allowed, or there is no such survey.
            StorageFailedError: The disk refused; the call may be repeated.
        """
        _check_one_of("kind", kind, [one.value for one in NOTES])
        fact = Fact(Kind(kind), survey_metadata.parse_object(values_json, "values_json"))
        return self._do(lambda: self._survey.note(survey, fact), self._limits.long_timeout_s)

    def add_marker(self, survey: str, marker: Marker) -> MarkedSurvey:
        """Add a marker to the open survey or to a past one, durably; may be repeated.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            marker: The marker, without its time.

        Raises:
            SurveyRefusedError: There is no such survey, its survey.json is damaged, it has
                another marker of this id or too many markers.
            StorageFailedError: The disk refused; the former markers remain.
        """
        return self._mark(survey, Kind.MARKER, lambda values, now: new_marker(values, marker, now))

    def remove_marker(self, survey: str, marker_id: str, author: str) -> MarkedSurvey:
        """Remove a marker, durably; it stays in survey.json as removed. May be repeated.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            marker_id: UUID of the marker.
            author: Who removes it.

        Raises:
            SurveyRefusedError: There is no such survey or marker, or survey.json is damaged.
            StorageFailedError: The disk refused; the marker is still there.
        """
        return self._mark(
            survey,
            Kind.MARKER_REMOVED,
            lambda values, now: removed_marker(values, marker_id, author, now),
        )

    def _mark(
        self,
        survey: str,
        kind: Kind,
        change: Callable[[Dict[str, Any], str], Optional[Dict[str, Any]]],
    ) -> MarkedSurvey:
        now = utc_time.iso_text(self._storage.now_ns() // utc_time.NS_PER_US)

        def fact(description: Dict[str, Any]) -> Optional[Fact]:
            values = change(description, now)
            return None if values is None else Fact(kind, values)

        return self._do(lambda: self._survey.mark(survey, fact), self._limits.long_timeout_s)

    def store(self, trace: Trace) -> Path:
        """Store a trace; return its JSON file when that and the MCAP are durable.

        Raises:
            SurveyRefusedError: No survey is open.
            TraceRefusedError: The open survey does not take the trace.
            StorageFailedError: The disk refused or was too slow; the call may be repeated.
        """
        return self._do(lambda: self._survey.opened().store(trace, self._storage.now_ns()))

    def record(self, message: RecordedMessage) -> None:
        """Record a message of another topic; drop it, counted, if the disk is too slow."""
        if self._latched.note(message):
            self._thread.offer(message)

    def close_survey(
        self,
        survey_id: str,
        outcome: str,
        reason: Message = NO_REASON,
        end: Sequence[RecordedMessage] = (),
    ) -> ClosedSurvey:
        """Finish the recordings and write how the survey ended; may be repeated.

        Args:
            survey_id: UUID of the survey.
            outcome: One of OUTCOMES.
            reason: Why it ended.
            end: The last messages of the recordings; none: a status that states the outcome.

        Raises:
            SurveyRefusedError: A value is not allowed or the survey is not open.
            StorageFailedError: The disk refused; the survey is still open.
        """
        _check_one_of("outcome", outcome, OUTCOMES)
        characters = len(str(reason))
        if characters > MAX_REASON_CHARACTERS:
            raise SurveyRefusedError(
                Message(
                    "reason has {count} characters; at most {most} are allowed",
                    count=characters,
                    most=MAX_REASON_CHARACTERS,
                )
            )
        survey_folder.check_survey_id(survey_id)
        return self._do(
            lambda: self._survey.close(survey_id, outcome, reason, end),
            self._limits.long_timeout_s,
        )

    def shut_down(self) -> None:
        """Finish the recordings of a survey that is still open and end the thread.

        Raises:
            StorageFailedError: The disk refused or was too slow.
        """
        try:
            self._do(self._survey.interrupt)
        finally:
            self._thread.stop(self._limits.timeout_s)

    def state(self) -> ProcessingState:
        """Return what the operator should know."""
        survey = self._survey.current
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
            unsigned=self._survey.unsigned,
        )

    def _do(self, work: Callable[[], Any], timeout_s: Optional[float] = None) -> Any:
        try:
            result = self._thread.do(work, timeout_s or self._limits.timeout_s)
        except ProcessingError as error:
            self._note(error.message, failing=isinstance(error, StorageFailedError))
            raise
        self._note(None, failing=False)
        return result

    def _note(self, error: Optional[Message], failing: bool) -> None:
        with self._lock:
            self._last_error, self._failing = error, failing

    def _write_messages(self, messages: Sequence[RecordedMessage]) -> None:
        survey = self._survey.current
        if survey is None:
            return
        # No caller waits for an answer here: the diagnostics show errors to the operator.
        try:
            self._unrecorded += survey.record(messages)
        except Exception as error:
            self._unrecorded += len(messages)
            self._note_unanswered(error)
        now_s = self._storage.clock.now_s()
        if now_s < self._commit_due_s:
            return
        self._commit_due_s = now_s + self._limits.period_s
        try:
            survey.commit()
        except Exception as error:
            self._note_unanswered(error)

    def _note_unanswered(self, error: Exception) -> None:
        """Note the error of the moment, for which no caller waits."""
        reason = _reason(error)
        # Once: the same happens several times a second.
        if not isinstance(error, Gpr20Error) and reason != self._last_error:
            log_fault("storage")
        self._note(reason, failing=True)


def _check_one_of(place: str, value: str, allowed: Collection[str]) -> None:
    if value not in allowed:
        raise SurveyRefusedError(
            Message(
                "{place} is {value}; it must be one of {allowed}",
                place=place,
                value=repr(value[:64]),
                allowed=", ".join(allowed),
            )
        )


def _reason(error: Exception) -> Message:
    if isinstance(error, Gpr20Error):
        return error.message
    return verbatim(str(error)).with_fault(INTERNAL)

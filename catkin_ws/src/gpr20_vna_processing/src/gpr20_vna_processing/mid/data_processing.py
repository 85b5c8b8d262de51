"""Opening a survey, storing its traces, closing it."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, Callable, Optional, Sequence

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import INTERNAL
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message, verbatim
from gpr20_survey.errors import ProcessingError, StorageFailedError
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.current_survey import CurrentSurvey
from gpr20_vna_processing.mid.facts import requested_fact
from gpr20_vna_processing.mid.processing_parameters import BYTES_PER_MB
from gpr20_vna_processing.mid.processing_records import (
    AddedFact,
    ClosedSurvey,
    ProcessingState,
    Storage,
)
from gpr20_vna_processing.mid.storage_thread import StorageThread

NO_REASON = verbatim("")


class DataProcessing:
    """Has at most one survey open and makes its traces durable.

    Its methods may be called from any thread; all files are written by the StorageThread, where
    `CurrentSurvey` does what they say.

    Attributes:
        start: Starts that thread.
        record: Records a message of another topic; drops it, counted, if the disk is too slow.
    """

    def __init__(self, storage: Storage) -> None:
        """Build the storage without starting it."""
        self._storage = storage
        self._limits = storage.parameters
        queue_bytes = round(self._limits.message_queue_mb * BYTES_PER_MB)
        period_s = self._limits.commit_period_s
        self._thread = StorageThread(self._write_messages, queue_bytes, period_s)
        self.start = self._thread.start
        self.record = self._thread.offer
        # Changed on the storage thread only.
        self._survey = CurrentSurvey(storage, self._thread)
        self._unrecorded = 0
        self._commit_due_s = 0.0
        self._lock = threading.Lock()  # guards the two below
        self._last_error: Optional[Message] = None
        self._failing = False

    def open_survey(
        self, survey_id: str, started_us: int, metadata_json: str, needed_bytes: int
    ) -> Path:
        """See `CurrentSurvey.open`."""
        given = (survey_id, started_us, metadata_json, needed_bytes)
        return self._do(lambda: self._survey.open(*given))

    def interrupt_other(self, survey: str) -> str:
        """See `CurrentSurvey.interrupt_other`."""
        return self._do_long(lambda: self._survey.interrupt_other(survey))

    def reopen_survey(self, survey: str) -> ReopenedSurvey:
        """See `CurrentSurvey.reopen`."""
        return self._do_long(lambda: self._survey.reopen(survey))

    def add_fact(self, survey: str, kind: str, values_json: str) -> AddedFact:
        """Add a fact to the log of the open survey or of a past one, durably; may be repeated.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            kind: One of `facts.KINDS`; a report is of the open survey only.
            values_json: JSON object with the fact.

        Raises:
            SurveyRefusedError: A value is not allowed, there is no such survey, or what is
                noted of it is damaged.
            InvalidValueError: A value is not allowed.
            StorageFailedError: The disk refused; the log has its former facts.
        """
        now = utc_time.iso_text(self._storage.now_ns() // utc_time.NS_PER_US)
        wanted, change = requested_fact(kind, values_json, now)
        return self._do_long(lambda: self._survey.add_fact(survey, wanted, change))

    def store(self, trace: Trace) -> Path:
        """See `OpenSurvey.store`."""
        return self._do(lambda: self._survey.opened().store(trace, self._storage.now_ns()))

    def close_survey(
        self,
        survey_id: str,
        outcome: str,
        reason: Message = NO_REASON,
        end: Sequence[RecordedMessage] = (),
    ) -> ClosedSurvey:
        """See `CurrentSurvey.close`."""
        return self._do_long(lambda: self._survey.close(survey_id, outcome, reason, end))

    def shut_down(self) -> None:
        """Finish the recording of a survey that is still open and end the thread.

        Raises:
            StorageFailedError: The disk refused or was too slow.
        """
        try:
            self._do(self._survey.shut_down)
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

    def _do_long(self, work: Callable[[], Any]) -> Any:
        return self._do(work, self._limits.long_timeout_s)

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
            survey.record(messages)
        except Exception as error:
            self._unrecorded += len(messages)
            self._note_unanswered(error)
        now_s = self._storage.clock.now_s()
        if now_s < self._commit_due_s:
            return
        self._commit_due_s = now_s + self._limits.commit_period_s
        try:
            survey.commit()
        except Exception as error:
            self._note_unanswered(error)

    def _note_unanswered(self, error: Exception) -> None:
        if isinstance(error, Gpr20Error):
            reason = error.message
        else:
            reason = verbatim(str(error)).with_fault(INTERNAL)
            # Once: the same happens several times a second.
            if reason != self._last_error:
                log_fault("storage")
        self._note(reason, failing=True)

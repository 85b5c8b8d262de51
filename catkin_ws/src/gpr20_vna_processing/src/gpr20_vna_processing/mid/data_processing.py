"""Opening a survey, storing its traces, closing it."""

from __future__ import annotations

import functools
from typing import Any, Callable, Optional, Sequence, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import INTERNAL
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message, verbatim
from gpr20_survey.errors import ProcessingError, StorageFailedError
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.trace import utc_time
from gpr20_vna_processing.mid.current_survey import CurrentSurvey
from gpr20_vna_processing.mid.facts import requested_fact
from gpr20_vna_processing.mid.processing_parameters import BYTES_PER_MB
from gpr20_vna_processing.mid.processing_records import ChangedSurvey, ProcessingState, Storage
from gpr20_vna_processing.mid.storage_thread import StorageThread


def _on_thread(method: Callable[..., Any], is_long: bool = True) -> Callable[..., Any]:
    """Return a method of DataProcessing that calls that of its CurrentSurvey on the thread."""

    @functools.wraps(method)
    def call(self: DataProcessing, *given: Any, **named: Any) -> Any:
        return self._do(lambda: method(self._survey, *given, **named), is_long)

    return call


class DataProcessing:
    """Has at most one survey open and makes its traces durable.

    Its methods may be called from any thread; all files are written by the StorageThread.

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
        # What was refused or failed last, if nothing succeeded since, and whether the disk refused.
        self._last: Tuple[Optional[Message], bool] = (None, False)

    open_survey = _on_thread(CurrentSurvey.open, is_long=False)
    store = _on_thread(CurrentSurvey.store, is_long=False)
    close_survey = _on_thread(CurrentSurvey.close)
    interrupt_other = _on_thread(CurrentSurvey.interrupt_other)
    reopen_survey = _on_thread(CurrentSurvey.reopen)

    def add_fact(self, survey: str, kind: str, values_json: str) -> ChangedSurvey:
        """See `requested_fact` and `CurrentSurvey.add_fact`."""
        now = utc_time.iso_text(self._storage.now_ns() // utc_time.NS_PER_US)
        wanted, change = requested_fact(kind, values_json, now)
        return self._do(lambda: self._survey.add_fact(survey, wanted, change))

    def shut_down(self) -> None:
        """Finish the recording of a survey that is still open and end the thread.

        Raises:
            StorageFailedError: The disk refused or was too slow.
        """
        try:
            self._do(self._survey.shut_down, is_long=False)
        finally:
            self._thread.stop(self._limits.timeout_s)

    def state(self) -> ProcessingState:
        """Return what the operator should know."""
        survey = self._survey.current
        last_error, failing = self._last
        queues = self._thread.state()
        return ProcessingState(
            survey_id=survey.survey_id if survey else "",
            folder=str(survey.folder) if survey else "",
            stored_traces=survey.stored_traces if survey else 0,
            unrecorded=queues.dropped + self._unrecorded,
            last_error=last_error,
            failing=failing,
            queues=queues,
            unsigned=self._survey.unsigned,
        )

    def _do(self, work: Callable[[], Any], is_long: bool = True) -> Any:
        limits = self._limits
        try:
            result = self._thread.do(work, limits.long_timeout_s if is_long else limits.timeout_s)
        except ProcessingError as error:
            self._last = error.message, isinstance(error, StorageFailedError)
            raise
        self._last = None, False
        return result

    def _write_messages(self, messages: Sequence[RecordedMessage]) -> None:
        survey = self._survey.current
        if survey is None:
            return
        if not self._succeeds(lambda: survey.record(messages)):
            self._unrecorded += len(messages)
        now_s = self._storage.clock.now_s()
        if now_s >= self._commit_due_s:
            self._commit_due_s = now_s + self._limits.commit_period_s
            self._succeeds(survey.commit)

    def _succeeds(self, work: Callable[[], None]) -> bool:
        """Do work for which no caller waits: the diagnostics show its errors to the operator."""
        try:
            work()
        except Gpr20Error as error:
            self._last = error.message, True
        except Exception as error:
            failure = verbatim(str(error)).with_fault(INTERNAL)
            former, _ = self._last
            # Once: the same happens several times a second.
            if failure != former:
                log_fault("storage")
            self._last = failure, True
        else:
            return True
        return False

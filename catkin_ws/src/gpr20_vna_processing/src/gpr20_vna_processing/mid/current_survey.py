"""The one survey that is open, as the storage's thread sees it."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Collection, Dict, Optional, Sequence, Tuple

from gpr20_common.faults import IN_USE
from gpr20_common.message import Message, verbatim
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError, storing
from gpr20_survey.faults import NONE_OPEN, STOPPED
from gpr20_survey.files import durable_files
from gpr20_survey.files.durable_files import locked
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import Change, add_to_survey, find_survey
from gpr20_survey.folder.signature import try_to_sign
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.plan.markers import MARKERS
from gpr20_survey.recording.mcap_writer import RecordedMessage
from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.low.bag_processes import bag_bytes
from gpr20_vna_processing.mid import new_survey
from gpr20_vna_processing.mid.facts import OF_MARKERS, check_one_of
from gpr20_vna_processing.mid.open_survey import OpenSurvey
from gpr20_vna_processing.mid.processing_records import OUTCOMES, ChangedSurvey, Storage, SurveyEnd
from gpr20_vna_processing.mid.reopening import Reopening
from gpr20_vna_processing.mid.storage_thread import StorageThread

MAX_REASON_BYTES = 16384
# Traces of the open survey wait meanwhile.
LOCK_WAIT_S = 0.3
BAG_WAIT_S = 1.0  # while the process that makes a bag adds it to the log
NO_REASON = verbatim("")


class CurrentSurvey:
    """Holds at most one open survey; all but `current` is for the storage's thread alone.

    Attributes:
        current: The open survey, if any.
        unsigned: Why the survey that was closed last is not signed, although there is a key.
    """

    def __init__(self, storage: Storage, thread: StorageThread) -> None:
        """Build it empty; the messages of other topics that are recorded are those of the thread.

        A trace is published once in the life of this process. It can be found stored when its
        survey is reopened although it was never published: the disk, or another process, failed
        between the first of its files and the last.
        """
        self._storage = storage
        self._signer = storage.parameters.signer()
        self._thread = thread
        self._lock = ExitStack()  # holds the lock of the open survey's folder
        # Of each survey that was open before: the largest index that was published, and the traces
        # that have a durable file, but were not. No time: clocks are set back.
        self._published: Dict[str, Tuple[int, Collection[Trace]]] = {}
        self.current: Optional[OpenSurvey] = None
        self.unsigned: Optional[Message] = None

    def opened(self, name: str = "") -> OpenSurvey:
        """Return the open survey if it has this id or folder; empty: whichever it is.

        Raises:
            SurveyRefusedError: None is open, or another one.
        """
        survey = self.current
        if survey is None:
            raise SurveyRefusedError(
                Message("no survey is open; start or resume one", details="open_survey"),
                fault=NONE_OPEN,
            )
        if name and not survey.is_called(name):
            raise SurveyRefusedError(
                Message(
                    "survey {survey} is not open; {open_survey} is open",
                    survey=name[:64],
                    open_survey=survey.survey_id,
                ),
                fault=IN_USE,
            )
        return survey

    def open(self, survey_id: str, started_us: int, metadata_json: str, needed_bytes: int) -> Path:
        """Make the folder of a survey and begin its recording; may be repeated.

        Its plan has the metadata; its time is in us since 1970, UTC.

        Raises:
            SurveyRefusedError: A value is not allowed, the clock is wrong, the disk is too small
                or another survey is open.
            StorageFailedError: The disk refused.
        """
        storage = self._storage
        folder = survey_folder.survey_folder(storage.data, survey_id, started_us)
        description = new_survey.describe(survey_id, started_us, metadata_json, storage.revision)
        if self.current is not None and self.current.opened_as == description:
            return folder  # the answer to the first call may have been lost
        now_ns = self._check_can_open()
        new_survey.check_space(storage, needed_bytes)
        # Its time is that of the survey: an opening that is repeated makes the same record.
        plan = LogRecord.after(None, Kind.PLAN, description, description["started"])
        failure = Message("the survey's folder {path} could not be made", path=printable(folder))
        with ExitStack() as lock:
            with storing(failure, folder):
                durable_files.ensure_folder(folder, storage.parameters.readable_by.folder_mode)
                lock.enter_context(locked(folder))
                new_survey.empty_folder(folder, plan)
                recording = storage.open_recording(folder / survey_folder.MCAP_FILE)
            log = SurveyLog(folder, [plan], whole=False)
            survey = OpenSurvey(folder, log, recording, storage)
            self._take(survey, log.records, now_ns)
            self._lock = lock.pop_all()
        return folder

    def reopen(self, name: str) -> ReopenedSurvey:
        """Open a survey that was cut off or ended early, by id or folder, repaired.

        Raises:
            SurveyRefusedError: There is no such survey, it is complete, another is open, or
                another process writes it.
            StorageFailedError: The disk refused; the call may be repeated.
        """
        survey = self.current
        if survey is not None and not survey.in_place():
            # Its files were moved, removed or replaced: those on the disk are what counts.
            self._abandon(survey)
        elif survey is not None and survey.is_called(name):
            # The client that filled it is gone, or has not received the first answer.
            survey.resume(self._storage.now_ns())
            return self._reopened(survey, ())
        now_ns = self._check_can_open()
        folder, _ = find_survey(self._storage.data, name)
        # For a copy of the recording now, and for its bag in the end.
        new_survey.check_space(self._storage, bag_bytes(folder))
        with ExitStack() as lock:
            failure = Message("the folder {path} could not be locked", path=printable(folder))
            with storing(failure, folder):
                lock.enter_context(locked(folder, BAG_WAIT_S))
            reopening = Reopening(folder, self._storage, self._signer)
            # Only now: a survey that is not resumed keeps its bag.
            self._storage.bags.cancel(folder)
            survey, added, repairs = reopening.repair(now_ns)
            self._take(survey, added, now_ns)
            self._lock = lock.pop_all()
        return self._reopened(survey, repairs)

    def _reopened(self, survey: OpenSurvey, repairs: Tuple[Message, ...]) -> ReopenedSurvey:
        """Publish the traces that are stored, but may not have been published.

        Subscribers recognize a repeated trace by its `sample_id`.
        """
        reopened = survey.reopened(repairs)
        newest, waiting = self._published.pop(survey.survey_id, (survey.newest, ()))
        again = {one.index: one for one in waiting if survey.has_stored(one)}
        for trace in reopened.recent[-1:]:
            # After it another process may have died before it published it.
            if trace.index > newest:
                again[trace.index] = trace
        survey.newest = max(newest, *again, -1)
        for index in sorted(again):
            message = self._storage.topics.trace(again[index], self._storage.now_ns())
            self._storage.publish(message)
        return reopened

    def _take(self, survey: OpenSurvey, added: Sequence[LogRecord], now_ns: int) -> None:
        """Begin to record a survey; `added` are the records of its log that are not recorded."""
        # From now on messages queue up behind this job; those before are in the snapshot.
        latched = self._thread.begin_recording(now_ns)
        try:
            survey.begin(added, latched, now_ns)
        except Exception:
            self._thread.end_recording()
            survey.abandon()
            raise
        self.current = survey

    def _check_can_open(self) -> int:
        """Return the present moment [ns since 1970, UTC]."""
        if self.current is not None:
            raise SurveyRefusedError(
                Message(
                    "survey {survey} is open in {folder}; stop it first",
                    survey=self.current.survey_id,
                    folder=printable(self.current.folder),
                    details="close_survey",
                ),
                fault=IN_USE,
            )
        self._storage.check_data()
        return new_survey.checked_time(self._storage.now_ns())

    def store(self, trace: Trace) -> Path:
        """See `OpenSurvey.store`."""
        return self.opened().store(trace, self._storage.now_ns())

    def close(
        self,
        survey_id: str,
        outcome: str,
        reason: Message = NO_REASON,
        end: Sequence[RecordedMessage] = (),
    ) -> ChangedSurvey:
        """Finish the recording and write how the survey ended; may be repeated.

        Without last messages the storage states the outcome, one of OUTCOMES, and the reason.

        Raises:
            SurveyRefusedError: A value is not allowed, or the survey is not open.
            StorageFailedError: The disk refused; the survey is still open.
        """
        check_one_of("outcome", outcome, OUTCOMES)
        size = len(str(reason).encode("utf-8", "surrogatepass"))
        survey_metadata.check_size(size, "reason", MAX_REASON_BYTES)
        survey_folder.check_survey_id(survey_id)
        before = self._ended_survey(survey_id, outcome) if self.current is None else None
        if before is not None:
            return before  # the answer to the first call may have been lost
        survey = self.opened(survey_id)
        now_ns = self._storage.now_ns()
        if not end:  # its client is gone, or did not say it
            sentence, (state, *_) = OUTCOMES[outcome]
            message = Message("{outcome}: {reason}", outcome=sentence, reason=reason)
            simulated = survey.description.get("simulated") is True
            status = SurveyEnd(survey_id, state, message, simulated, now_ns)
            end = [self._storage.end_status(status)]
        survey.record(end)
        survey.close(outcome, reason, now_ns)
        self.unsigned = try_to_sign(self._signer, survey.folder)
        self._release(survey)
        self._storage.bags.make(survey.folder)
        return ChangedSurvey(survey_id, survey.stored_traces)

    def _ended_survey(self, survey_id: str, outcome: str) -> Optional[ChangedSurvey]:
        try:
            folder, found = find_survey(self._storage.data, survey_id)
        except SurveyRefusedError:
            return None
        description = found.description
        # The manifest comes last: without it the survey was cut off while it was closed.
        closed = (folder / manifest.MANIFEST_FILE).is_file()
        if not closed or description.get("outcome") != outcome:
            return None
        return ChangedSurvey(survey_id, description.get("stored_traces", 0))

    def add_fact(self, survey: str, kind: Kind, change: Change) -> ChangedSurvey:
        """Add a fact to the log of a survey, by its id or folder; may be repeated.

        It is the open one without a name, and for a report.

        Raises:
            SurveyRefusedError: There is no such survey, what is noted of it is damaged, another
                process writes it, or the change is not possible.
            StorageFailedError: The disk refused; the call may be repeated.
        """
        now_ns, current = self._storage.now_ns(), self.current
        of_open = not survey or kind is Kind.REPORT
        if of_open or (current is not None and current.is_called(survey)):
            opened = self.opened(survey)
            folder, stored = opened.folder, opened.stored_traces
            description = opened.change(change, now_ns)
        else:
            (folder, _), stored = find_survey(self._storage.data, survey), 0
            now = utc_time.iso_text(now_ns // utc_time.NS_PER_US)
            description = add_to_survey(folder, change, now, LOCK_WAIT_S)
        markers = description.get(MARKERS, []) if kind in OF_MARKERS else ()
        return ChangedSurvey(description["survey_id"], stored, markers)

    def shut_down(self) -> None:
        """Close the open survey, if any, as one that can be resumed."""
        if self.current is not None:
            reason = Message("the storage was shut down").with_fault(STOPPED)
            self.close(self.current.survey_id, survey_metadata.INTERRUPTED, reason)

    def interrupt_other(self, survey: str) -> str:
        """Close the open survey, unless it is this one, as interrupted; return its folder's name.

        If another survey is to be opened, the client that filled this one left it open.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        opened = self.current
        if opened is None or opened.is_called(survey):
            return ""
        reason = Message("left open by the control, which began {survey}", survey=survey[:64])
        try:
            self.close(opened.survey_id, survey_metadata.INTERRUPTED, reason.with_fault(STOPPED))
        except StorageFailedError:
            if opened.in_place():
                raise
            # Its files are no longer in place: no reason to refuse every other survey.
            self._abandon(opened)
        return opened.folder.name

    def _abandon(self, survey: OpenSurvey) -> None:
        survey.abandon()
        self._release(survey)

    def _release(self, survey: OpenSurvey) -> None:
        self._published[survey.survey_id] = survey.newest, survey.pending
        self._lock.close()
        self._thread.end_recording()
        self.current = None

"""The one survey that is open, as the storage's thread sees it."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Callable, Optional, Sequence

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError, storing
from gpr20_survey.files.folder_lock import locked
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.annotating import Change, add_to_survey
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import find_survey
from gpr20_survey.folder.signature import try_to_sign
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.markers import MARKERS
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace import utc_time
from gpr20_vna_processing import faults
from gpr20_vna_processing.low.bag_processes import bag_bytes
from gpr20_vna_processing.mid import new_survey
from gpr20_vna_processing.mid.facts import OF_MARKERS, OF_THE_OPEN_SURVEY
from gpr20_vna_processing.mid.latched_topics import LatchedTopics
from gpr20_vna_processing.mid.open_survey import OpenSurvey
from gpr20_vna_processing.mid.processing_records import AddedFact, ClosedSurvey, Storage
from gpr20_vna_processing.mid.publication import Publication
from gpr20_vna_processing.mid.refusals import check_one_of
from gpr20_vna_processing.mid.reopening import Reopening
from gpr20_vna_processing.mid.survey_end import OUTCOMES, SurveyEnd

MAX_REASON_BYTES = 16384
# Traces of the open survey wait meanwhile.
LOCK_WAIT_S = 0.3


class CurrentSurvey:
    """Holds at most one open survey; all but `current` is for the storage's thread alone."""

    def __init__(self, storage: Storage, disk_reserve_bytes: int, latched: LatchedTopics) -> None:
        """Build it empty.

        Args:
            storage: Files, disk, clock.
            disk_reserve_bytes: What a new survey must leave free [bytes].
            latched: The last messages of latched topics, with which a recording begins.
        """
        self._storage = storage
        self._disk_reserve_bytes = disk_reserve_bytes
        self._latched = latched
        self._publication = Publication(storage.on_stored, storage.on_logged)
        self._survey: Optional[OpenSurvey] = None
        self._lock = ExitStack()  # holds the lock of the open survey's folder
        self.unsigned: Optional[Message] = None
        """Why the survey that was closed last is not signed, although there is a key."""

    @property
    def current(self) -> Optional[OpenSurvey]:
        """The open survey, if any."""
        return self._survey

    def opened(self) -> OpenSurvey:
        """Return the open survey.

        Raises:
            SurveyRefusedError: None is open.
        """
        if self._survey is None:
            raise SurveyRefusedError(
                Message("no survey is open; start or resume one", details="open_survey"),
                fault=faults.NONE_OPEN,
            )
        return self._survey

    def opened_as(self, name: str) -> OpenSurvey:
        """Return the open survey if it has this id or folder; empty: whichever it is.

        Raises:
            SurveyRefusedError: None is open, or another one.
        """
        survey = self.opened()
        if name and not survey.is_called(name):
            raise SurveyRefusedError(
                Message(
                    "survey {survey} is not open; {open_survey} is open",
                    survey=name[:64],
                    open_survey=survey.survey_id,
                ),
                fault=faults.OTHER_OPEN,
            )
        return survey

    def open(self, survey_id: str, started_us: int, metadata_json: str, needed_bytes: int) -> Path:
        """Make the folder of a survey and begin its recording; may be repeated.

        Args:
            survey_id: UUID of the survey.
            started_us: When it started [us since 1970, UTC].
            metadata_json: JSON object that goes into the plan.
            needed_bytes: Estimate of the whole survey [bytes].

        Returns:
            The survey's folder.

        Raises:
            SurveyRefusedError: A value is not allowed, the clock is wrong, the disk is too small
                or another survey is open.
            StorageFailedError: The disk refused.
        """
        folder = survey_folder.survey_folder(self._storage.data, survey_id, started_us)
        revision = self._storage.revision
        description = new_survey.describe(survey_id, started_us, metadata_json, revision)
        if self._survey is not None and self._survey.opened_as == description:
            return folder  # the answer to the first call may have been lost
        now_ns = self._storage.now_ns()
        self._check_can_open(needed_bytes, now_ns)
        failure = Message("the survey's folder {path} could not be made", path=printable(folder))
        plan = new_survey.plan_record(description)
        with ExitStack() as lock:
            with storing(failure, folder):
                new_survey.make_folder(folder, plan, self._storage.readers)
                lock.enter_context(locked(folder))
                new_survey.make_empty(folder, plan)
                path = folder / survey_folder.MCAP_FILE
                recording = self._storage.open_recording(path)
            log = SurveyLog(folder, [plan], whole=False)
            survey = OpenSurvey(folder, log, recording, self._storage.topics, self._publication)
            # The log last: a folder with one is whole.
            self._take(survey, log.records, now_ns, log.write)
            self._lock = lock.pop_all()
        return folder

    def reopen(self, name: str) -> ReopenedSurvey:
        """Open a survey that was cut off or ended early, repaired; may be repeated.

        Args:
            name: The survey's id, or the name of its folder.

        Raises:
            SurveyRefusedError: There is no such survey, it is complete, another is open, or
                another process writes it.
            StorageFailedError: The disk refused; the call may be repeated.
        """
        now_ns = self._storage.now_ns()
        survey = self._survey
        if survey is not None and not survey.in_place():
            # Its files were moved, removed or replaced: those on the disk are what counts.
            self._abandon()
        elif survey is not None and survey.is_called(name):
            # The client that filled it is gone, or has not received the first answer.
            survey.resume(now_ns)
            return survey.reopened(())
        self._check_can_open(0, now_ns)
        folder, _ = find_survey(self._storage.data, name)
        # For a copy of the recording now, and for its bag in the end.
        new_survey.check_space(self._storage, bag_bytes(folder), self._disk_reserve_bytes)
        self._storage.bags.cancel(folder)
        with ExitStack() as lock:
            failure = Message("the folder {path} could not be locked", path=printable(folder))
            with storing(failure, folder):
                lock.enter_context(locked(folder))
            # Again, because the process that held the lock may have closed the survey meanwhile.
            folder, _ = find_survey(self._storage.data, name)
            reopening = Reopening(folder, self._storage.topics, self._storage.signer)
            repaired = reopening.repair(now_ns // utc_time.NS_PER_US)
            survey = OpenSurvey(
                folder,
                repaired.log,
                repaired.recording,
                self._storage.topics,
                self._publication,
                repaired.stored,
                repaired.recent,
            )
            self._take(survey, repaired.added, now_ns)
            self._lock = lock.pop_all()
        last = repaired.recent[-1] if repaired.recent else None
        message_of = partial(self._storage.topics.trace, time_ns=now_ns)
        self._publication.reopened(survey.survey_id, repaired.stored, last, message_of)
        return survey.reopened(repaired.repairs)

    def _take(
        self,
        survey: OpenSurvey,
        added: Sequence[LogRecord],
        now_ns: int,
        write_log: Callable[[], None] = lambda: None,
    ) -> None:
        """Begin to record a survey whose files are whole but for what comes now.

        Args:
            survey: The survey.
            added: The records of its log that its recording does not hold yet.
            now_ns: The present moment [ns since 1970, UTC].
            write_log: Writes the log of a new survey.
        """
        text = survey_metadata.encode(survey.description).decode("ascii")
        path = survey.folder / survey_folder.LOG_FILE
        topics = self._storage.topics
        # From now on messages queue up behind this job; those before are in the snapshot.
        latched = self._latched.begin(now_ns)
        try:
            replay = topics.replay(survey.description, survey.folder, now_ns)
            log = [topics.log(record, now_ns) for record in added]
            survey.record([replay, topics.metadata(text, now_ns), *log, *latched])
            survey.commit()
            survey.write_description()
            with storing(Message("{path} could not be written", path=printable(path)), path):
                write_log()
        except Exception:
            self._latched.end()
            survey.abandon()
            raise
        self._survey = survey
        self._storage.on_opened(text)

    def _check_can_open(self, needed_bytes: int, now_ns: int) -> None:
        if self._survey is not None:
            raise SurveyRefusedError(
                Message(
                    "survey {survey} is open in {folder}; stop it first",
                    survey=self._survey.survey_id,
                    folder=printable(self._survey.folder),
                    details="close_survey",
                ),
                fault=faults.OTHER_OPEN,
            )
        new_survey.check_clock(now_ns)
        new_survey.check_space(self._storage, needed_bytes, self._disk_reserve_bytes)

    def close(
        self, survey_id: str, outcome: str, reason: Message, end: Sequence[RecordedMessage] = ()
    ) -> ClosedSurvey:
        """Finish the recording and write how the survey ended; may be repeated.

        Args:
            survey_id: UUID of the survey.
            outcome: One of OUTCOMES.
            reason: Why it ended.
            end: Its last messages; none: a status that states outcome and reason.

        Raises:
            SurveyRefusedError: A value is not allowed, or the survey is not open.
            StorageFailedError: The disk refused; the survey is still open.
        """
        check_one_of("outcome", outcome, OUTCOMES)
        size = len(str(reason).encode("utf-8", "surrogatepass"))
        survey_metadata.check_size(size, "reason", MAX_REASON_BYTES)
        survey_folder.check_survey_id(survey_id)
        if self._survey is None:
            before = self._ended_survey(survey_id, outcome)
            if before is not None:
                return before  # the answer to the first call may have been lost
        survey = self.opened_as(survey_id)
        now_ns = self._storage.now_ns()
        survey.record(end or [self._end_status(survey, outcome, reason, now_ns)])
        survey.close(outcome, reason, now_ns)
        # If a shut down leaves no time for it, the survey is not sealed, but can be resumed.
        survey.write_manifest(self._storage.revision)
        self.unsigned = try_to_sign(self._storage.signer, survey.folder)
        self._latched.end()
        self._lock.close()
        self._survey = None
        self._storage.bags.make(survey.folder)
        return ClosedSurvey(survey_id, survey.folder, survey.stored_traces)

    def _end_status(
        self, survey: OpenSurvey, outcome: str, reason: Message, now_ns: int
    ) -> RecordedMessage:
        simulated = survey.description.get("simulated") is True
        end = SurveyEnd(survey.survey_id, outcome, reason, simulated, now_ns)
        return self._storage.end_status(end)

    def _ended_survey(self, survey_id: str, outcome: str) -> Optional[ClosedSurvey]:
        try:
            folder, found = find_survey(self._storage.data, survey_id)
        except SurveyRefusedError:
            return None
        description = found.description
        stored = description.get("stored_traces")
        # The manifest comes last: without it the survey was cut off while it was closed.
        closed = (folder / manifest.MANIFEST_FILE).is_file()
        if not closed or description.get("outcome") != outcome or not isinstance(stored, int):
            return None
        return ClosedSurvey(survey_id, folder, stored)

    def add_fact(self, survey: str, kind: Kind, change: Change) -> AddedFact:
        """Add a fact to the log of a survey, whether it is open or not; may be repeated.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            kind: What the fact is.
            change: What is to be added.

        Raises:
            SurveyRefusedError: There is no such survey, what is noted of it is damaged, another
                process writes it, or the change is not possible.
            StorageFailedError: The disk refused; the call may be repeated.
        """
        now_ns, current = self._storage.now_ns(), self._survey
        of_open = not survey or kind in OF_THE_OPEN_SURVEY
        if of_open or (current is not None and current.is_called(survey)):
            opened = self.opened_as(survey)
            folder, stored = opened.folder, opened.stored_traces
            description = opened.change(change, now_ns)
        else:
            (folder, _), stored = find_survey(self._storage.data, survey), 0
            now = utc_time.iso_text(now_ns // utc_time.NS_PER_US)
            description = add_to_survey(folder, change, now, LOCK_WAIT_S)
        markers = description.get(MARKERS, []) if kind in OF_MARKERS else ()
        return AddedFact(description["survey_id"], folder, stored, markers)

    def shut_down(self) -> None:
        """Close the open survey, if any, as one that can be resumed.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        if self._survey is not None:
            reason = Message("the storage was shut down").with_fault(faults.SHUT_DOWN)
            self.close(self._survey.survey_id, INTERRUPTED, reason)

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
        opened = self._survey
        if opened is None or opened.is_called(survey):
            return ""
        reason = Message("left open by the control, which began {survey}", survey=survey[:64])
        try:
            self.close(opened.survey_id, INTERRUPTED, reason.with_fault(faults.LEFT_OPEN))
        except StorageFailedError:
            if opened.in_place():
                raise
            # Its files are no longer in place: no reason to refuse every other survey.
            self._abandon()
        return opened.folder.name

    def _abandon(self) -> None:
        assert self._survey is not None
        self._survey.abandon()
        self._lock.close()
        self._latched.end()
        self._survey = None

"""The one survey that is open, as the storage's thread sees it."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any, Callable, Dict, Optional, Sequence, Tuple

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError, storing
from gpr20_survey.files.folder_lock import locked
from gpr20_survey.folder import manifest, survey_folder, survey_metadata
from gpr20_survey.folder.annotating import Change, Fact, add_to_survey, annotate
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import find_survey
from gpr20_survey.folder.signature import try_to_sign
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.markers import markers_of
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace import utc_time
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid import new_survey
from gpr20_vna_processing.mid.latched_topics import LatchedTopics
from gpr20_vna_processing.mid.open_survey import OpenSurvey
from gpr20_vna_processing.mid.processing_records import (
    AnnotatedSurvey,
    ClosedSurvey,
    MarkedSurvey,
    Storage,
)
from gpr20_vna_processing.mid.publication import Publication
from gpr20_vna_processing.mid.reopening import Reopening
from gpr20_vna_processing.mid.survey_end import SurveyEnd


class CurrentSurvey:
    """Holds at most one open survey; all but `current` is for the storage's thread alone."""

    def __init__(
        self,
        storage: Storage,
        disk_reserve_bytes: int,
        latched: LatchedTopics,
        on_opened: Callable[[str], None],
        on_stored: Callable[[RecordedMessage], None],
        on_logged: Callable[[RecordedMessage], None],
    ) -> None:
        """Build it empty.

        Args:
            storage: Files, disk, clock.
            disk_reserve_bytes: What a new survey must leave free [bytes].
            latched: The last messages of latched topics, with which a recording begins.
            on_opened: Called with the JSON description of a survey that was opened.
            on_stored: Called with the message of every trace when it is durable; must not raise.
            on_logged: Likewise of every record of the survey's log.
        """
        self._storage = storage
        self._disk_reserve_bytes = disk_reserve_bytes
        self._latched = latched
        self._on_opened = on_opened
        self._publication = Publication(on_stored, on_logged)
        self._survey: Optional[OpenSurvey] = None
        self._lock = ExitStack()  # holds the lock of the open survey's folder
        self._closed: Optional[ClosedSurvey] = None
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

    def opened_as(self, survey_id: str) -> OpenSurvey:
        """Return the open survey if it is this one.

        Raises:
            SurveyRefusedError: It is not.
        """
        survey = self.opened()
        if survey.survey_id != survey_id:
            raise SurveyRefusedError(
                Message(
                    "survey {survey} is not open; {open_survey} is open",
                    survey=survey_id[:64],
                    open_survey=survey.survey_id,
                ),
                fault=faults.OTHER_OPEN,
            )
        return survey

    def open(self, folder: Path, description: Dict[str, Any], needed_bytes: int) -> None:
        """Make the folder of a survey and begin its recordings; may be repeated.

        Args:
            folder: The survey's folder, made here.
            description: What the log says of it at its beginning.
            needed_bytes: Estimate of the whole survey [bytes].

        Raises:
            SurveyRefusedError: Another survey is open, the clock is wrong or the disk too small.
            StorageFailedError: The disk refused.
        """
        if self._survey is not None and self._survey.opened_as == description:
            return  # the answer to the first call may have been lost
        now_ns = self._storage.now_ns()
        self._check_can_open(needed_bytes, now_ns)
        failure = Message("the survey's folder {path} could not be made", path=printable(folder))
        plan = new_survey.plan_record(description)
        with ExitStack() as lock:
            with storing(failure, folder):
                new_survey.make_folder(folder, plan, self._storage.readers)
                lock.enter_context(locked(folder))
                new_survey.make_empty(folder, plan)
                recordings = self._storage.open_recordings(folder, description)
            log = SurveyLog(folder, [plan], whole=False)
            survey = OpenSurvey(folder, log, recordings, self._storage.topics, self._publication)
            # The log last: a folder with one is whole.
            self._take(survey, log.records, now_ns, log.write)
            self._lock = lock.pop_all()

    def reopen(self, name: str) -> ReopenedSurvey:
        """Open a survey that was cut off or ended early, repaired; may be repeated.

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
        elif survey is not None and name in (survey.survey_id, survey.folder.name):
            # The client that filled it is gone, or has not received the first answer.
            survey.resume(now_ns)
            return survey.reopened(())
        self._check_can_open(0, now_ns)
        folder, _ = find_survey(self._storage.data, name)
        new_survey.check_space(self._storage, _copied_bytes(folder), self._disk_reserve_bytes)
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
                repaired.recordings,
                self._storage.topics,
                self._publication,
                repaired.stored,
                repaired.recent,
                repaired.types,
            )
            self._take(survey, repaired.added, now_ns)
            self._lock = lock.pop_all()
        self._publication.reopened(
            survey.survey_id,
            repaired.stored,
            repaired.recent[-1] if repaired.recent else None,
            lambda trace: self._storage.topics.trace(trace, now_ns),
        )
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
            added: The records of its log that its recordings do not hold yet.
            now_ns: The present moment [ns since 1970, UTC].
            write_log: Writes the log of a new survey.
        """
        text = survey_metadata.encode(survey.description).decode("ascii")
        path = survey.folder / survey_folder.LOG_FILE
        try:
            self._begin_recording(survey, text, added, now_ns)
            survey.write_description()
            with storing(Message("{path} could not be written", path=printable(path)), path):
                write_log()
        except Exception:
            self._latched.end()
            survey.abandon()
            raise
        self._survey = survey
        self._on_opened(text)

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

    def _begin_recording(
        self, survey: OpenSurvey, text: str, added: Sequence[LogRecord], now_ns: int
    ) -> None:
        # From now on messages queue up behind this job; those before are in the snapshot.
        latched = self._latched.begin(now_ns)
        topics = self._storage.topics
        replay = topics.replay(survey.description, survey.folder, now_ns)
        log = [topics.log(record, now_ns) for record in added]
        survey.record([replay, topics.metadata(text, now_ns), *log, *latched])
        survey.commit()

    def close(
        self, survey_id: str, outcome: str, reason: Message, end: Sequence[RecordedMessage] = ()
    ) -> ClosedSurvey:
        """Finish the recordings and write how the survey ended; may be repeated.

        Args:
            survey_id: UUID of the survey.
            outcome: One word.
            reason: Why it ended.
            end: Its last messages; none: a status that states outcome and reason.

        Raises:
            SurveyRefusedError: The survey is not open.
            StorageFailedError: The disk refused; the survey is still open.
        """
        if self._survey is None and self._closed and self._closed.survey_id == survey_id:
            return self._closed  # the answer to the first call may have been lost
        if self._survey is None:
            before = self._ended_survey(survey_id, outcome)
            if before is not None:
                return before  # by a process that died before it could answer
        survey = self.opened_as(survey_id)
        now_ns = self._storage.now_ns()
        survey.record(end or [self._end_status(survey, outcome, reason, now_ns)])
        survey.close(outcome, reason, now_ns)
        # If a shut down leaves no time for it, the survey is not sealed, but can be resumed.
        survey.write_manifest(self._storage.revision)
        self.unsigned = try_to_sign(self._storage.signer, survey.folder)
        self._latched.end()
        self._lock.close()
        self._closed = ClosedSurvey(survey_id, survey.folder, survey.stored_traces)
        self._survey = None
        return self._closed

    def _end_status(
        self, survey: OpenSurvey, outcome: str, reason: Message, now_ns: int
    ) -> RecordedMessage:
        simulated = survey.description.get("simulated") is True
        end = SurveyEnd.of(survey.survey_id, outcome, reason, simulated, now_ns)
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

    def report(self, survey_id: str, report: Dict[str, Any]) -> int:
        """Add a report to the log of the open survey; return how many traces are stored.

        Raises:
            SurveyRefusedError: The survey is not open, or is being closed.
            StorageFailedError: The disk refused; the former report remains.
        """
        survey = self.opened_as(survey_id)
        survey.add(Kind.REPORT, report, self._storage.now_ns())
        return survey.stored_traces

    def annotate(self, survey: str, annotation: Annotation) -> AnnotatedSurvey:
        """Replace the annotation of a survey, whether it is open or not.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            annotation: The new annotation; its heading is that of the former one at this position.

        Raises:
            SurveyRefusedError: There is no such survey, or its survey.json is damaged.
            StorageFailedError: The disk refused; the former annotation remains.
        """
        folder, description = self.change(survey, annotate(annotation))
        return AnnotatedSurvey(description["survey_id"], folder)

    def note(self, survey: str, fact: Fact) -> AnnotatedSurvey:
        """Add a note to the log of a survey, whether it is open or not; see `change`."""
        folder, description = self.change(survey, lambda _description: fact)
        return AnnotatedSurvey(description["survey_id"], folder)

    def mark(self, survey: str, change: Change) -> MarkedSurvey:
        """Add or remove a marker of a survey, whether it is open or not; see `change`."""
        folder, description = self.change(survey, change)
        return MarkedSurvey(description["survey_id"], folder, markers_of(description))

    def change(self, survey: str, change: Change) -> Tuple[Path, Dict[str, Any]]:
        """Add a fact to the log of a survey, whether it is open or not.

        Args:
            survey: The survey's id, or the name of its folder; empty: the open one.
            change: What is to be added.

        Returns:
            The folder, and the content of survey.json.

        Raises:
            SurveyRefusedError: There is no such survey, what is noted of it is damaged, another
                process writes it, or the change is not possible.
            StorageFailedError: The disk refused; the call may be repeated.
        """
        now_ns = self._storage.now_ns()
        opened = self.opened() if not survey else self._survey
        if opened is not None and survey in ("", opened.survey_id, opened.folder.name):
            return opened.folder, opened.change(change, now_ns)
        folder, _ = find_survey(self._storage.data, survey)
        now = utc_time.iso_text(now_ns // utc_time.NS_PER_US)
        return folder, add_to_survey(folder, change, now)

    def interrupt(self) -> None:
        """Close the open survey, if any, as one that can be resumed.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        if self._survey is not None:
            reason = Message("the storage was shut down").with_fault(faults.SHUT_DOWN)
            self.close(self._survey.survey_id, INTERRUPTED, reason)

    def interrupt_other(self, survey: str) -> str:
        """Close the open survey as interrupted, unless it is this one.

        Args:
            survey: Id of the survey that is to be opened, or the name of its folder.

        Returns:
            The name of the folder of the survey that was closed; empty if none was.

        Raises:
            StorageFailedError: The disk refused; the survey is still open.
        """
        opened = self._survey
        if opened is None or survey in (opened.survey_id, opened.folder.name):
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


def _copied_bytes(folder: Path) -> int:
    """Return the space that reopening a survey may need: both recordings may be copied [bytes]."""
    recordings = [folder / name for name in (survey_folder.BAG_FILE, survey_folder.MCAP_FILE)]
    return sum(path.lstat().st_size for path in recordings if path.is_file())

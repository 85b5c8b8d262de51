"""Reopening a survey that was cut off or ended early: read, decide, repair, continue.

The log says what was planned and noted, the JSON files and the MCAP what was measured; each judges
itself by its checksums. Damaged JSON files are put aside and written again from the MCAP; then the
log says that the survey was reopened, and from then on the manifest does not bind; then the MCAP is
written again beside the old one, which it replaces when it is whole; the bag is removed. Nothing is
changed before everything was read, and each step leaves a folder that can be reopened. The manifest
is compared with the files first, and removed last.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Callable, Iterator, List, Optional, Sequence, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError, storing
from gpr20_survey.faults import COMPLETE, DAMAGED, LOG_LOST, OTHER_VERSION
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, survey_folder, trace_files
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import RecoveredSurvey, open_log, recover, repairs_of
from gpr20_survey.folder.signature import Signer, is_signed
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.plan.recorded_plan import PlanFit, is_imported
from gpr20_survey.recording.mcap_writer import McapFile, RecordedMessage
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid.open_survey import OpenSurvey
from gpr20_vna_processing.mid.processing_records import Storage
from gpr20_vna_processing.mid.stored_traces import StoredTraces, read_again

SHOWN = 5  # traces that do not fit, or faults of the recording, that are named
COPIED_BYTES = 4 << 20  # what a copy holds in memory between two commits


class Reopening:
    """Repairs the files of one survey."""

    def __init__(self, folder: Path, storage: Storage, signer: Optional[Signer]) -> None:
        """Read every file of the survey; nothing is changed.

        Raises:
            SurveyRefusedError: The survey ended complete, or cannot continue: its traces do not
                fit its plan, or are of another version, or nothing shows what the plan was.
            StorageFailedError: The disk cannot be read.
        """
        self._folder = folder
        self._traces = folder / survey_folder.TRACES_FOLDER
        self._storage = storage
        # Whether a robot with a key has not signed it as it is.
        self._is_foreign = signer is not None and not signer.has_signed(folder)
        self._is_signed = is_signed(folder)
        failure = Message("the survey in {folder} could not be read", folder=printable(folder))
        with storing(failure, folder):
            self._recovered = recover(folder, asking_manifest=True)
            if is_imported(self._recovered.description):
                raise SurveyRefusedError(
                    Message(
                        "the survey in {folder} was imported; it has no plan that could be "
                        "continued",
                        folder=printable(folder),
                    ),
                    fault=COMPLETE,
                )
            records, survey_id = self._recovered.found.records, self._recovered.survey_id
            self._repairs = repairs_of(self._recovered)
            self._sealed = self._recovered.manifest
            is_binding = self._sealed is not None and self._sealed.is_binding(records)
            # Whether the log is that of the manifest, if there is one.
            self._is_covered = self._sealed is None or self._sealed.covers(records)
            misfits = _misfits_by(self._recovered)
            self._stored = StoredTraces(folder, survey_id, self._sealed, is_binding, misfits)
        self._check_can_continue()

    def repair(self, now_ns: int) -> Tuple[OpenSurvey, Sequence[LogRecord], Tuple[Message, ...]]:
        """Make all files whole, and open the recording at its end; may be repeated.

        Returns:
            The survey, the records of its log that the recording lacks (those of now, and those
            after its last commit), and what was repaired.

        Raises:
            StorageFailedError: The disk refused.
        """
        stored, now = self._stored, utc_time.iso_text(now_ns // utc_time.NS_PER_US)
        place = printable(self._folder)
        failure = Message("the survey in {folder} could not be repaired", folder=place)
        with storing(failure, self._folder):
            self._repairs += stored.changes()
            self._remove_torn()
            durable_files.ensure_folder(self._traces)
            self._repair_traces()
            damage = self._recovered.manifest_damage
            if damage is not None:
                self._set_aside(self._folder / manifest.MANIFEST_FILE, damage)
            log = open_log(self._folder, self._with_unproven(), now)
            log.add(log.next(Kind.RESUME, {"stored_traces": len(stored.truth)}, now))
            recording = self._write_recording()
            try:
                # Last: until now it shows which files were changed before.
                durable_files.remove_file(self._folder / manifest.SIGNATURE_FILE)
                durable_files.remove_file(self._folder / manifest.MANIFEST_FILE)
            except OSError:
                recording.abandon()
                raise
        survey = OpenSurvey(self._folder, log, recording, self._storage, stored.files.files)
        added = [one for one in log.records if one.sha256 not in stored.mcap.log]
        return survey, added, tuple(self._repairs)

    def _with_unproven(self) -> RecoveredSurvey:
        """Name what the recording, the manifest and its signature will vouch for from now on.

        These are the traces of which two forms contradict each other, and all of a survey that was
        changed since this robot signed it, or that it never signed.
        """
        entries = {
            manifest.trace_name(name): {
                "reason": "survey.mcap held another one with a right checksum"
            }
            for name in self._stored.contradicted
        }
        has_ended = self._recovered.description.get("ended") is not None
        # A robot with a key signs a survey that was closed, or still is.
        if self._is_foreign and (has_ended or self._is_signed or self._sealed is not None):
            entries["signature"] = {"reason": "it was not that of this robot and this manifest"}
        if not self._is_covered and not self._recovered.found.lost:
            entries["log"] = {"reason": "it did not end as the manifest said"}
        return replace(self._recovered, unconfirmed={**self._recovered.unconfirmed, **entries})

    def _check_can_continue(self) -> None:
        stored, description = self._stored, self._recovered.description
        folder, count = printable(self._folder), len(self._stored.truth)
        unread = [*(reason for _path, reason in stored.files.damaged), *stored.mcap.faults]
        for reason in unread:
            if reason.fault_code == OTHER_VERSION.code:  # it is no damage
                raise SurveyRefusedError(
                    Message(
                        "the survey in {folder} cannot be resumed: {reason}; nothing was changed",
                        folder=folder,
                        reason=reason,
                    )
                )
        misfits = stored.misfits
        if stored.files.foreign + stored.mcap.foreign and not stored.truth:
            misfits = [Message("every readable trace belongs to another survey")]
        if misfits:
            raise SurveyRefusedError(
                Message(
                    "the survey in {folder} cannot be resumed: {misfits}; restore its log from a "
                    "copy of the folder, or start a new survey; nothing was changed",
                    folder=folder,
                    misfits=in_a_row(misfits[:SHOWN]),
                    details=f"{len(misfits)} differences",
                ),
                fault=LOG_LOST,
            )
        planned = description.get("planned_traces", description.get("stored_traces"))
        finished = description.get("outcome") == "finished" and count == planned
        is_whole = self._recovered.found.is_whole and self._is_covered
        if finished and is_whole and stored.intact():
            raise SurveyRefusedError(
                Message(
                    "the survey in {folder} is finished and complete with {stored} traces; "
                    "nothing is left to measure, start a new survey",
                    folder=folder,
                    stored=count,
                ),
                fault=COMPLETE,
            )

    def _remove_torn(self) -> None:
        folders = [one for one in (self._folder, self._traces) if one.is_dir()]
        removed = sum(durable_files.remove_temporaries(one) for one in folders)
        if removed:
            self._repairs.append(
                Message("removed {count} files that were never finished", count=removed)
            )

    def _repair_traces(self) -> None:
        for path, reason in self._stored.files.damaged:
            self._set_aside(path, reason)
        lost = self._stored.truth.keys() - self._stored.files.files.keys()
        for trace in self._stored.mcap.traces(lost) if lost else ():
            content = trace_files.encode(trace)
            file = TraceFile.of(trace, content)
            durable_files.write_new_file(self._traces / file.name, content)
            self._stored.files.files[trace.index] = file
            written = Message("wrote {file} again from the recordings", file=file.name)
            self._repairs.append(written.with_fault(DAMAGED.as_warning()))

    def _write_recording(self) -> McapFile:
        """Replace the MCAP; return it, open at its end.

        It is copied, because the index of the whole file is in the memory of its writer. The bag is
        removed: it is made of the recording when the survey ends again.
        """
        path = self._folder / survey_folder.MCAP_FILE
        temporary = durable_files.temporary_path(path)
        recording = McapFile(temporary)
        try:
            for message in self._messages():
                if message.datatype == trace_message.DATATYPE:
                    recording.write_alone(message)
                else:
                    recording.write(message)
                if recording.collected_bytes > COPIED_BYTES:
                    recording.commit()
            recording.commit()
            self._keep_damaged(path)
            durable_files.remove_file(self._folder / survey_folder.BAG_FILE)
            recording.take_place_of(path)
        except BaseException:
            recording.abandon()
            temporary.unlink(missing_ok=True)  # it may have filled the disk
            raise
        return recording

    def _messages(self) -> Iterator[RecordedMessage]:
        """Yield every trace that is right once, and all other messages."""
        truth, prints = self._stored.truth, self._stored.mcap.prints
        yield from self._stored.mcap.messages(truth)
        missing = sorted(index for index, one in truth.items() if prints.get(index) != one)
        for index in missing:
            path = self._traces / self._stored.files.files[index].name
            trace = read_again(path, self._recovered.survey_id)
            yield self._storage.topics.trace(trace, trace.timestamp_us * utc_time.NS_PER_US)
        if missing:
            file = survey_folder.MCAP_FILE
            added = Message("added {count} traces to {file}", count=len(missing), file=file)
            self._repairs.append(added)

    def _keep_damaged(self, mcap: Path) -> None:
        """Keep an MCAP that is not whole in `damaged/`, and the bag: each may hold more."""
        found = self._stored.mcap.faults
        if not mcap.exists():
            found = [Message("{file} is missing", file=mcap.name)]
        for path in (mcap, self._folder / survey_folder.BAG_FILE):
            if found and path.exists():
                durable_files.keep_aside(path, self._folder / survey_folder.DAMAGED_FOLDER)
        if found:
            rebuilt = Message(
                "rebuilt {file}: {faults}", file=mcap.name, faults=in_a_row(found[:SHOWN])
            )
            self._repairs.append(rebuilt.reporting_only(DAMAGED.as_warning()))

    def _set_aside(self, path: Path, reason: Message) -> None:
        target = durable_files.move_aside(path, self._folder / survey_folder.DAMAGED_FOLDER)
        moved = Message(
            "moved {file} to {folder}/: {reason}",
            file=printable(path.name),
            folder=target.parent.name,
            reason=reason,
        )
        self._repairs.append(moved.reporting_only(DAMAGED.as_warning()))


def _misfits_by(recovered: RecoveredSurvey) -> Callable[[Trace], List[Message]]:
    try:
        return PlanFit(recovered.description).misfits
    except InvalidValueError:
        return lambda _trace: []  # surveys of other clients need not have a plan

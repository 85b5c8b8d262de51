"""Reopening a survey that was cut off or ended early: read, decide, repair, continue.

The log says what was planned and noted, the JSON files and the MCAP what was measured; each judges
itself by its checksums. Damaged JSON files are put aside and written again from the MCAP; then the
log says that the survey was reopened, and from then on the manifest does not bind; then the MCAP is
written again beside the old one, which it replaces when it is whole; the bag is removed. Nothing is
changed before everything was read, and each step leaves a folder that can be reopened. The manifest
is compared with the files first, and removed last.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import (
    ManifestDamagedError,
    storing,
)
from gpr20_survey.faults import REPAIRED
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, survey_folder
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.manifest import SIGNATURE_FILE, Manifest
from gpr20_survey.folder.recovery import RecoveredSurvey, open_log, recover, repairs_of
from gpr20_survey.folder.signature import Signer, is_signed
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.plan.imported import is_imported
from gpr20_survey.plan.recorded_plan import PlanFit
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.survey_topics import SurveyTopics, recorded_trace
from gpr20_survey.results.reopened_survey import FIRST_TRACES, RECENT_TRACES
from gpr20_survey.trace import trace_json, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid import refusals
from gpr20_vna_processing.mid.recording_repair import read_again, write_again
from gpr20_vna_processing.mid.stored_traces import RecordedTraces, StoredTraces


@dataclass(frozen=True)
class RepairedSurvey:
    """A survey whose files are whole again."""

    log: SurveyLog
    added: Tuple[LogRecord, ...]
    """The records of the log that the recording lacks."""
    recording: McapFile
    """Open at its end."""
    stored: Dict[int, TraceFile]
    """The trace of each index that is stored."""
    recent: Tuple[Trace, ...]
    """The first traces of the plan, and those that were stored last, the latest last."""
    repairs: Tuple[Message, ...]
    """What was repaired."""


class Reopening:
    """Repairs the files of one survey."""

    def __init__(self, folder: Path, topics: SurveyTopics, signer: Optional[Signer] = None) -> None:
        """Read every file of the survey; nothing is changed.

        Args:
            folder: The survey's folder.
            topics: Makes messages of traces.
            signer: Signed the survey, if its surveys are signed.

        Raises:
            SurveyRefusedError: The survey ended complete, or cannot continue: its traces do not
                fit its plan, or nothing shows what the plan was.
            StorageFailedError: The disk cannot be read.
        """
        self._folder = folder
        self._traces = folder / survey_folder.TRACES_FOLDER
        self._damaged = folder / survey_folder.DAMAGED_FOLDER
        self._topics = topics
        self._was_signed = signer is not None and signer.has_signed(folder)
        self._is_signed = is_signed(folder)
        self._has_key = signer is not None
        with storing(
            Message("the survey in {folder} could not be read", folder=printable(folder)), folder
        ):
            self._recovered = recover(folder, asking_manifest=True)
            description = self._recovered.description
            if is_imported(description):
                raise refusals.imported(folder)
            self._repairs = repairs_of(self._recovered)
            self._start = self._recovered.found.records[0].values
            survey_id = self._recovered.survey_id
            self._sealed, self._manifest_damage = _read_manifest(folder, survey_id)
            misfits = _misfits(description)
            mcap = RecordedTraces(folder / survey_folder.MCAP_FILE, survey_id, misfits)
            self._stored = StoredTraces(
                folder, mcap, survey_id, self._sealed, self._is_binding(), misfits
            )
        self._refuse(description)
        self._files = self._stored.files.files

    def repair(self, now_us: int) -> RepairedSurvey:
        """Make all files whole and open the recording at its end.

        Args:
            now_us: The present moment [us since 1970, UTC].

        Raises:
            StorageFailedError: The disk refused; the call may be repeated.
        """
        with storing(
            Message("the survey in {folder} could not be repaired", folder=printable(self._folder)),
            self._folder,
        ):
            now = utc_time.iso_text(now_us)
            self._repairs += self._stored.changes()
            self._remove_torn()
            durable_files.ensure_folder(self._traces)
            self._repair_traces()
            if self._manifest_damage is not None:
                self._set_aside(self._folder / manifest.MANIFEST_FILE, self._manifest_damage)
            log = open_log(self._folder, self._with_unproven(), now)
            log.add(log.next(Kind.RESUME, {"stored_traces": len(self._stored.truth)}, now))
            recent = self._recent()
            recording = write_again(
                self._folder, self._stored, self._topics, self._start, self._repairs
            )
            try:
                # Last: until now it shows which files were changed before.
                durable_files.remove_file(self._folder / SIGNATURE_FILE)
                durable_files.remove_file(self._folder / manifest.MANIFEST_FILE)
            except OSError:
                recording.abandon()
                raise
        return RepairedSurvey(
            log,
            self._not_recorded(log),
            recording,
            self._files,
            recent,
            tuple(self._repairs),
        )

    def _not_recorded(self, log: SurveyLog) -> Tuple[LogRecord, ...]:
        """Return those added now, and those that came after the last commit or the end."""
        recorded = self._stored.mcap.log
        return tuple(one for one in log.records if one.sha256 not in recorded)

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
        if self._has_key and not self._was_signed and self._should_be_signed():
            entries["signature"] = {"reason": "it was not that of this robot and this manifest"}
        if not self._is_covered() and not self._recovered.found.lost:
            entries["log"] = {"reason": "it did not end as the manifest said"}
        unconfirmed = {**self._recovered.unconfirmed, **entries}
        return replace(self._recovered, unconfirmed=unconfirmed)

    def _should_be_signed(self) -> bool:
        """Return whether a robot with a key signs such a survey: it was closed, or still is."""
        has_ended = self._recovered.description.get("ended") is not None
        return has_ended or self._is_signed or self._sealed is not None

    def _is_covered(self) -> bool:
        """Return whether the log is that of the manifest, if there is one."""
        return self._sealed is None or self._sealed.covers(self._recovered.found.records)

    def _is_binding(self) -> bool:
        return self._sealed is not None and self._sealed.is_binding(self._recovered.found.records)

    def _refuse(self, description: Dict[str, Any]) -> None:
        """Refuse a survey that cannot or need not continue.

        Raises:
            SurveyRefusedError: It cannot or need not.
        """
        stored = self._stored
        if stored.foreign and not stored.truth:
            raise refusals.only_foreign_traces(self._folder, description["survey_id"])
        if stored.misfits:
            raise refusals.traces_not_planned(self._folder, stored.misfits)
        planned = description.get("planned_traces", description.get("stored_traces"))
        finished = description.get("outcome") == "finished" and len(stored.truth) == planned
        is_whole = self._recovered.found.is_whole and self._is_covered()
        if finished and is_whole and stored.intact():
            raise refusals.survey_complete(self._folder, len(stored.truth))

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
        lost = self._stored.truth.keys() - self._files.keys()
        if not lost:
            return
        mcap = self._stored.mcap
        right = mcap.places(self._stored.truth)
        for place, message in enumerate(mcap.stored.messages()):
            if place in right:
                trace = recorded_trace(message)
                if trace is not None and trace.index in lost:
                    self._restore(trace)

    def _set_aside(self, path: Path, reason: Message) -> None:
        target = durable_files.move_aside(path, self._damaged)
        self._repairs.append(
            Message(
                "moved {file} to {folder}/: {reason}",
                file=printable(path.name),
                folder=target.parent.name,
                reason=reason,
            ).with_fault(REPAIRED)
        )

    def _restore(self, trace: Trace) -> None:
        content = trace_json.encode(trace)
        file = TraceFile.of(trace, content)
        durable_files.write_new_file(self._traces / file.name, content)
        self._files[trace.index] = file
        self._repairs.append(
            Message("wrote {file} again from the recordings", file=file.name).with_fault(REPAIRED)
        )

    def _recent(self) -> Tuple[Trace, ...]:
        # By their places in the plan: the clock may have been set back.
        ordered = sorted(self._files)
        newest = ordered[-RECENT_TRACES:]
        first = [one for one in ordered if one < FIRST_TRACES and one not in newest]
        paths = [self._traces / self._files[index].name for index in [*first, *newest]]
        return tuple(read_again(path, self._recovered.survey_id) for path in paths)


def _misfits(description: Dict[str, Any]) -> Callable[[Trace], List[Message]]:
    try:
        return PlanFit(description).misfits
    except InvalidValueError:
        return lambda _trace: []  # surveys of other clients need not have a plan


def _read_manifest(folder: Path, survey_id: str) -> Tuple[Optional[Manifest], Optional[Message]]:
    """Return the manifest of a survey, or what is wrong with it."""
    try:
        return manifest.read_manifest(folder, survey_id), None
    except FileNotFoundError:
        return None, None
    except ManifestDamagedError as error:
        return None, error.message

"""Reopening a survey that was cut off or ended early: read, decide, repair, continue.

`StoredForms` reads every trace in its three forms (JSON file, bag, MCAP), passes over what a
crash tore off the end of a recording, and decides which traces are true. Then damaged JSON
files are put aside and written again. A correct bag is continued behind its last whole chunk;
otherwise the bag, and the MCAP always, is written again beside the old one, which it replaces
when it is whole. Nothing is changed before everything was read, and each step leaves a folder
that can be reopened. The manifest is compared with the files first, then marked, and removed last.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Set, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.errors import (
    ManifestDamagedError,
    printable,
    storing,
)
from gpr20_survey.faults import REPAIRED
from gpr20_survey.files import durable_files
from gpr20_survey.folder import (
    manifest,
    sealing,
    survey_folder,
    survey_metadata,
)
from gpr20_survey.folder.description_copies import sealed_description
from gpr20_survey.folder.description_differences import differences
from gpr20_survey.folder.description_recovery import (
    NOT_ENDED,
    RecoveredDescription,
    repairs_of,
    start_of,
)
from gpr20_survey.folder.manifest import Manifest
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.plan.markers import MARKERS, markers_of
from gpr20_survey.recording.recording import Recording
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.results.reopened_survey import FIRST_TRACES, RECENT_TRACES
from gpr20_survey.trace import trace_json, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid import refusals
from gpr20_vna_processing.mid.planned_traces import PlannedTraces
from gpr20_vna_processing.mid.recording_repair import RecordingRepair, read_again
from gpr20_vna_processing.mid.stored_forms import StoredForms

MAX_RESUMPTIONS = 100_000


@dataclass(frozen=True)
class RepairedSurvey:
    """A survey whose files are whole again."""

    description: Dict[str, Any]
    recordings: List[Recording]
    """Open at their ends."""
    stored: Dict[int, TraceFile]
    """The trace of each index that is stored."""
    recent: Tuple[Trace, ...]
    """The first traces of the plan, and those that were stored last, the latest last."""
    repairs: Tuple[Message, ...]
    """What was repaired."""
    types: Dict[str, Set[str]]
    """The checksums of the message types that the recordings hold of each topic."""


class Reopening:
    """Repairs the files of one survey."""

    def __init__(self, folder: Path, recovered: RecoveredDescription, topics: SurveyTopics) -> None:
        """Read every file of the survey; nothing is changed.

        Args:
            folder: The survey's folder.
            recovered: What is known of the content of survey.json.
            topics: Makes messages of traces.

        Raises:
            SurveyRefusedError: The survey ended complete, or cannot continue: its traces do not
                fit its plan, or nothing shows what the plan was.
            StorageFailedError: The disk cannot be read.
        """
        self._folder = folder
        self._traces = folder / survey_folder.TRACES_FOLDER
        self._damaged = folder / survey_folder.DAMAGED_FOLDER
        self._recovered = recovered
        self._topics = topics
        self._repairs: List[Message] = []
        planned = PlannedTraces(folder, recovered)
        survey_id = recovered.best["survey_id"]
        self._description = recovered.best
        with storing(
            Message("the survey in {folder} could not be read", folder=printable(folder)), folder
        ):
            self._sealed, self._manifest_damage = _read_manifest(folder, survey_id)
            self._forms = StoredForms(folder, survey_id, self._sealed, planned.note)
            self._refuse_foreign()
            self._forms.leave_out(planned.damaged(self._forms.truth))
            self._description = planned.description(self._forms.truth)
            self._start = self._start_copy()
            survey_metadata.started_us(self._start)
            self._refuse_complete()
        self._files = self._forms.files.files

    def repair(self, now_us: int) -> RepairedSurvey:
        """Make all files whole and open the recordings at their ends.

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
            self._mark_manifest(now)
            self._mark_open(now)
            durable_files.ensure_folder(self._traces)
            self._remove_torn()
            self._repair_traces()
            recent = self._recent()
            recordings = RecordingRepair(
                self._folder, self._forms, self._topics, self._start, self._repairs
            ).write()
        return RepairedSurvey(
            self._description,
            recordings,
            self._files,
            recent,
            tuple(self._repairs),
            self._forms.md5sums(),
        )

    def _start_copy(self) -> Dict[str, Any]:
        """Return the MCAP's copy: it stays as it is when the file is written again."""
        copy = sealed_description(self._folder)
        if copy is None or differences(copy, self._description):
            return start_of(self._description)
        return copy

    def _refuse_foreign(self) -> None:
        if self._forms.foreign and not self._forms.truth:
            raise refusals.only_foreign_traces(self._folder, self._description["survey_id"])

    def _refuse_complete(self) -> None:
        stored = len(self._forms.truth)
        planned = self._description.get("planned_traces", self._description.get("stored_traces"))
        finished = self._description.get("outcome") == "finished"
        if finished and stored == planned and self._forms.intact():
            raise refusals.survey_complete(self._folder, stored)

    def _mark_manifest(self, now: str) -> None:
        if self._manifest_damage is not None:
            path = self._folder / manifest.MANIFEST_FILE
            self._set_aside(path, self._manifest_damage)
        elif self._sealed is not None and self._sealed.reopened is None:
            self._repairs += self._forms.other_changes()
            sealing.mark_reopened(self._folder, self._sealed, now)

    def _mark_open(self, now: str) -> None:
        path = self._folder / survey_folder.SURVEY_FILE
        wrong = repairs_of(self._recovered, self._description)
        self._repairs += wrong
        if (wrong or self._recovered.later_damaged) and path.exists():
            durable_files.keep_aside(path, self._damaged)
        self._description = {
            **self._without_wrong_entries(),
            **NOT_ENDED,
            "stored_traces": len(self._forms.truth),
        }
        self._description["resumed"] = [*self._description.get("resumed", []), now]
        durable_files.replace_file(path, survey_metadata.encode(self._description))

    def _without_wrong_entries(self) -> Dict[str, Any]:
        """Return the description without entries that the storage did not write so."""
        resumed = self._description.get("resumed", [])
        wrong = []
        if not isinstance(resumed, list) or len(resumed) >= MAX_RESUMPTIONS:
            wrong.append("resumed")
        if not isinstance(self._description.get("report", {}), dict):
            wrong.append("report")
        try:
            markers_of(self._description)
        except InvalidValueError:
            wrong.append(MARKERS)
        self._repairs += [
            Message("left out '{key}' of survey.json, which is damaged", key=key).with_fault(
                REPAIRED
            )
            for key in wrong
        ]
        return {key: value for key, value in self._description.items() if key not in wrong}

    def _remove_torn(self) -> None:
        removed = sum(durable_files.remove_temporaries(one) for one in (self._folder, self._traces))
        if removed:
            self._repairs.append(
                Message("removed {count} files that were never finished", count=removed)
            )

    def _repair_traces(self) -> None:
        for path, reason in self._forms.files.damaged:
            self._set_aside(path, reason)
        for index, file in list(self._files.items()):
            if file.fingerprint != self._forms.truth.get(index):
                reason = Message("the recordings hold other numbers")
                self._set_aside(self._traces / file.name, reason)
                del self._files[index]
        lost = self._forms.truth.keys() - self._files.keys()
        for recorded in self._forms.recordings if lost else ():
            for message in recorded.stored.messages():
                trace = self._forms.true_trace(message)
                if trace is not None and trace.index in lost:
                    self._restore(trace)
                    lost = lost - {trace.index}

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
        moments = {index: (file.timestamp_us, index) for index, file in self._files.items()}
        newest = sorted(moments, key=lambda index: moments[index])[-RECENT_TRACES:]
        first = sorted(one for one in moments if one < FIRST_TRACES and one not in newest)
        paths = [self._traces / self._files[index].name for index in [*first, *newest]]
        return tuple(read_again(path, self._description["survey_id"]) for path in paths)


def _read_manifest(folder: Path, survey_id: str) -> Tuple[Optional[Manifest], Optional[Message]]:
    """Return the manifest of a survey, or what is wrong with it."""
    try:
        return manifest.read_own_manifest(folder, survey_id), None
    except FileNotFoundError:
        return None, None
    except ManifestDamagedError as error:
        return None, error.message

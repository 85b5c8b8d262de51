"""Reopening a survey that was cut off or ended early: read, decide, repair, continue.

`StoredForms` reads every trace in its three forms (JSON file, bag, MCAP), passes over what a
crash tore off the end of a recording, and decides which traces are true. Then damaged JSON
files are put aside and written again. A correct bag is continued behind its last whole chunk;
otherwise the bag, and the MCAP always, is written again beside the old one, which it replaces
when it is whole. Nothing is changed before everything was read, and each step leaves a folder
that can be reopened.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import AbstractSet, Any, Dict, List, Optional, Set, Tuple

from gpr20_common.message import Message, in_a_row
from gpr20_survey.errors import (
    StorageFailedError,
    SurveyRefusedError,
    TraceRefusedError,
    printable,
    storing,
)
from gpr20_survey.files import durable_files
from gpr20_survey.folder import manifest, survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.survey_search import recorded_description
from gpr20_survey.folder.trace_files import TraceFile
from gpr20_survey.recording.bag_writer import BagFile
from gpr20_survey.recording.recording import Recording
from gpr20_survey.recording.recordings import new_mcap
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.trace import trace_json, trace_message, utc_time
from gpr20_survey.trace.trace import Trace
from gpr20_vna_processing.mid import refusals
from gpr20_vna_processing.mid.stored_forms import RecordedTraces, StoredForms

MAX_RESUMPTIONS = 100_000
SHOWN = 3  # faults of a recording that are named
COPIED_BYTES = 4 << 20  # what a copy holds in memory between two commits


@dataclass(frozen=True)
class RepairedSurvey:
    """A survey whose files are whole again."""

    description: Dict[str, Any]
    recordings: List[Recording]
    """Open at their ends."""
    stored: Dict[int, TraceFile]
    """The trace of each index that is stored."""
    last: Optional[Trace]
    """The trace that was stored last."""
    repairs: Tuple[Message, ...]
    """What was repaired."""
    types: Dict[str, Set[str]]
    """The checksums of the message types that the recordings hold of each topic."""


class Reopening:
    """Repairs the files of one survey."""

    def __init__(self, folder: Path, description: Dict[str, Any], topics: SurveyTopics) -> None:
        """Read every file of the survey; nothing is changed.

        Args:
            folder: The survey's folder.
            description: The content of survey.json.
            topics: Makes messages of traces.

        Raises:
            SurveyRefusedError: The survey ended complete, or cannot continue.
            StorageFailedError: The disk cannot be read.
        """
        self._folder = folder
        self._traces = folder / survey_folder.TRACES_FOLDER
        self._damaged = folder / survey_folder.DAMAGED_FOLDER
        self._description = description
        self._topics = topics
        self._repairs: List[Message] = []
        # The MCAP's copy stays as it is when the file is written again.
        copy = recorded_description(folder)
        own = copy is not None and copy["survey_id"] == description["survey_id"]
        self._start = copy if copy is not None and own else description
        survey_metadata.started_us(self._start)
        with storing(
            Message("the survey in {folder} could not be read", folder=printable(folder)), folder
        ):
            self._forms = StoredForms(folder, description["survey_id"])
            self._refuse_foreign()
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
            self._mark_open(utc_time.iso_text(now_us))
            durable_files.ensure_folder(self._traces)
            self._remove_torn()
            self._repair_traces()
            last = self._last()
            recordings = self._write_recordings()
        return RepairedSurvey(
            self._description,
            recordings,
            self._files,
            last,
            tuple(self._repairs),
            self._forms.md5sums(),
        )

    def _refuse_foreign(self) -> None:
        if self._forms.foreign and not self._forms.truth:
            raise refusals.only_foreign_traces(self._folder, self._description["survey_id"])

    def _refuse_complete(self) -> None:
        stored = len(self._forms.truth)
        planned = self._description.get("planned_traces", self._description.get("stored_traces"))
        finished = self._description.get("outcome") == "finished"
        if finished and stored == planned and self._forms.intact():
            raise refusals.survey_complete(self._folder, stored)

    def _mark_open(self, now: str) -> None:
        path = self._folder / survey_folder.SURVEY_FILE
        resumed = self._description.get("resumed", [])
        if not isinstance(resumed, list) or len(resumed) >= MAX_RESUMPTIONS:
            raise refusals.wrong_resumptions(path, MAX_RESUMPTIONS)
        self._save_damaged_description()
        self._description = {
            **self._description,
            "ended": None,
            "outcome": None,
            "reason": "",
            "stored_traces": len(self._forms.truth),
            "resumed": [*resumed, now],
        }
        durable_files.replace_file(path, survey_metadata.encode(self._description))

    def _save_damaged_description(self) -> None:
        path = self._folder / survey_folder.SURVEY_FILE
        try:
            if survey_metadata.read_description(path) == self._description:
                return
            self._repairs.append(
                Message("corrected survey.json: its copy in survey.mcap has another start")
            )
        except SurveyRefusedError:
            self._repairs.append(
                Message(
                    "wrote survey.json again as it was at the start, from survey.mcap; its list "
                    "of failed samples is lost"
                )
            )
        if path.exists():
            durable_files.keep_aside(path, self._damaged)

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
            )
        )

    def _restore(self, trace: Trace) -> None:
        file = TraceFile.of(trace)
        durable_files.write_new_file(self._traces / file.name, trace_json.encode(trace))
        self._files[trace.index] = file
        self._repairs.append(Message("wrote {file} again from the recordings", file=file.name))

    def _read(self, index: int) -> Trace:
        path = self._traces / self._files[index].name
        try:
            return trace_files.read_trace(path, self._description["survey_id"])
        except TraceRefusedError as error:
            raise StorageFailedError(
                Message(
                    "{path} changed while it was read: {reason}; try again",
                    path=printable(path),
                    reason=error.message,
                )
            ) from error

    def _last(self) -> Optional[Trace]:
        if not self._files:
            return None
        moments = {index: (file.timestamp_us, index) for index, file in self._files.items()}
        return self._read(max(moments, key=lambda index: moments[index]))

    def _write_recordings(self) -> List[Recording]:
        recordings: List[Recording] = []
        try:
            recordings.append(self._resume_bag() or self._write_again(self._forms.bag))
            recordings.append(self._write_again(self._forms.mcap))
            # Last: it vouches for files; in a survey that has not ended it is known to be old.
            self._remove_manifest()
        except BaseException:
            for recording in recordings:
                recording.abandon()
            raise
        return recordings

    def _remove_manifest(self) -> None:
        old = self._folder / manifest.MANIFEST_FILE
        if old.is_dir() and not old.is_symlink():
            self._set_aside(old, Message("this is a folder, not a file"))
        durable_files.remove_file(old)

    def _resume_bag(self) -> Optional[Recording]:
        """Continue the bag without its torn tail or its index, if all before that is right."""
        bag = self._forms.stored_bag.resume() if self._forms.bag_is_right() else None
        if bag is None:
            return None
        try:
            missing = self._forms.truth.keys() - self._forms.bag.prints.keys()
            self._add(missing, bag, self._forms.bag.name)
        except BaseException:
            bag.abandon()
            raise
        return bag

    def _write_again(self, recorded: RecordedTraces) -> Recording:
        """Replace a recording by a whole new file; a damaged one stays in `damaged/`."""
        path = recorded.stored.path
        temporary = durable_files.temporary_path(path)
        new: Recording
        if recorded is self._forms.bag:
            new = BagFile(temporary)
        else:
            new = new_mcap(temporary, self._start)
        faults = self._forms.faults_of(recorded)
        try:
            self._copy(recorded, new)
            if faults:
                durable_files.keep_aside(path, self._damaged)
            new.take_place_of(path)
        except BaseException:
            new.abandon()
            temporary.unlink(missing_ok=True)  # it may have filled the disk
            raise
        if faults:
            self._repairs.append(
                Message("rebuilt {file}: {faults}", file=path.name, faults=in_a_row(faults[:SHOWN]))
            )
        return new

    def _copy(self, recorded: RecordedTraces, new: Recording) -> None:
        """Write every true trace once and all other messages."""
        missing = set(self._forms.truth)
        for message in map(self._forms.with_certain_type, recorded.stored.messages()):
            if message.datatype != trace_message.DATATYPE:
                if message.topic != self._topics.trace_topic:
                    new.write(message)
            else:
                trace = self._forms.true_trace(message)
                if trace is not None and trace.index in missing:
                    missing.remove(trace.index)
                    own = self._topics.trace(trace, message.time_ns)
                    new.write_alone(replace(own, topic=message.topic))
            if new.collected_bytes > COPIED_BYTES:
                new.commit()
        self._add(missing, new, recorded.name)

    def _add(self, missing: AbstractSet[int], new: Recording, name: str) -> None:
        for index in sorted(missing):
            trace = self._read(index)
            new.write_alone(self._topics.trace(trace, trace.timestamp_us * utc_time.NS_PER_US))
            if new.collected_bytes > COPIED_BYTES:
                new.commit()
        new.commit()
        if missing:
            self._repairs.append(
                Message("added {count} traces to {file}", count=len(missing), file=name)
            )
